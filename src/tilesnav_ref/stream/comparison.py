"""What ordinary streaming of the same tileset costs along the same route."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.packet.change import make_packet
from tilesnav_ref.packet.model import ObjectFaces
from tilesnav_ref.packet.state import HeldState, Parts
from tilesnav_ref.stream.bandwidth import Series
from tilesnav_ref.stream.baseline import Loads, ScreenSettings, follow, range_selection, screen_selection
from tilesnav_ref.stream.delivery import Delivery
from tilesnav_ref.stream.glb import open_glb
from tilesnav_ref.stream.levels import LevelFaces, on_grid, smallest_first
from tilesnav_ref.stream.reader import NavTileset
from tilesnav_ref.stream.route import Route
from tilesnav_ref.stream.tiles import TileContent, TileTree, read_tiles

Points = NDArray[np.float64]


@dataclass(frozen=True)
class ComparisonSettings:
    """How other clients look at the route."""

    screen: ScreenSettings = field(default_factory=ScreenSettings)
    sensor_range: float = 100.0
    """m within which everything is sent; a common range of a LiDAR on a vehicle."""
    spacing: float = 1.0
    """m of the route from one look to the next."""

    def __post_init__(self) -> None:
        """ValueError naming the setting that is out of range."""
        for name in ("sensor_range", "spacing"):
            if not 1e-3 <= getattr(self, name) <= 1e6:
                raise ValueError(f"setting {name}: found {getattr(self, name)}; allowed: 0.001 to 1000000 m")


@dataclass(frozen=True)
class Rival:
    """One way of streaming, and what it costs."""

    name: str
    title: str
    memory: str
    """What the client holds."""
    coded: Series
    """With the geometry codec of packets, contents without header."""
    files: Series | None
    """With the bytes of the contents as they are; None where no such files exist."""


class ContentSizes:
    """Faces and bytes of contents, each worked out once."""

    def __init__(self, tileset: NavTileset) -> None:
        self._tileset = tileset
        self._known: dict[TileContent, tuple[int, int]] = {}

    def coded(self, content: TileContent) -> int:
        """Bytes of all its faces by the codec that packets choose."""
        return self._look(content)[0]

    def faces(self, content: TileContent) -> int:
        """Its number of faces."""
        return self._look(content)[1]

    def file(self, content: TileContent) -> int:
        """Bytes of its file."""
        return 0 if content.path is None else content.path.stat().st_size

    def _look(self, content: TileContent) -> tuple[int, int]:
        if content not in self._known:
            parts = _object(self._tileset, content) if content.path is None else _file(self._tileset, content)
            state = HeldState(bytes(8), 0, False, parts)
            self._known[content] = (len(make_packet(None, state).body), state.face_count)
        return self._known[content]


def rivals(delivery: Delivery, route: Route, speed: float, settings: ComparisonSettings) -> tuple[Rival, ...]:
    """Stream a tileset along a route in the ways that users have today.

    Parameters
    ----------
    speed : float
        m/s.

    Returns
    -------
    tuple of Rival
        By screen-space error with the tiles as they are written, the same with one tile an object, and
        all objects within a range at the finest level; each for a client that drops what it does not need
        and for one that drops nothing.

    Raises
    ------
    TilesetError
        When tiles or contents are not sound.
    """
    return tuple(_Comparison(delivery.tileset, route, speed, settings).rivals())


@dataclass(frozen=True)
class _Comparison:
    tileset: NavTileset
    route: Route
    speed: float
    settings: ComparisonSettings

    @cached_property
    def sizes(self) -> ContentSizes:
        return ContentSizes(self.tileset)

    @cached_property
    def places(self) -> NDArray[np.float64]:
        """(K,) m along the route."""
        return np.append(np.arange(0.0, self.route.length, self.settings.spacing), self.route.length)

    def rivals(self) -> Iterator[Rival]:
        points = self.route.at(self.places)
        to_tileset = self.tileset.tileset_from_nav
        in_tileset = points @ to_tileset[:3, :3].T + to_tileset[:3, 3]
        screen, reach = self.settings.screen, self.settings.sensor_range
        pixels = screen.maximum_error
        tiles, objects = read_tiles(self.tileset.path), object_tree(self.tileset)

        def by_screen(tree: TileTree, point: Points) -> list[int]:
            return screen_selection(tree, point, screen)

        def by_range(tree: TileTree, point: Points) -> list[int]:
            return range_selection(tree, point, reach)

        yield from self._both("tiles", f"tiles, {pixels:g} px", (tiles, in_tileset), by_screen)
        yield from self._both("objects", f"object tiles, {pixels:g} px", (objects, points), by_screen)
        yield from self._both("range", f"within {reach:g} m, finest", (objects, points), by_range)

    def _both(
        self,
        name: str,
        title: str,
        seen: tuple[TileTree, Points],
        select: Callable[[TileTree, Points], list[int]],
    ) -> Iterator[Rival]:
        tree, points = seen
        selections = [select(tree, point) for point in points]
        for forgets, ending, words in ((True, "drop", "needed"), (False, "keep", "all")):
            loads = follow(tree, selections, forgets)
            coded = self._series(loads, self.sizes.coded)
            files = self._series(loads, self.sizes.file) if name == "tiles" else None
            yield Rival(f"{name}-{ending}", title, words, coded, files)

    def _series(self, loads: Loads, size: Callable[[TileContent], int]) -> Series:
        return Series(
            self.places / self.speed,
            np.array([sum(map(size, loaded)) for loaded in loads.loaded], np.int64),
            np.array([sum(map(self.sizes.faces, held)) for held in loads.held], np.int64),
            self.route.length / self.speed,
        )


def object_tree(tileset: NavTileset) -> TileTree:
    """Give every object a tile of its own: the finest tiling that its levels allow; m, nav frame.

    Notes
    -----
    The tiles of an object are a chain of REPLACE from its coarsest level to its finest, with its own
    proven errors, made not to fall from fine to coarse, and the box around all its levels.
    """
    levels = tileset.levels
    geometries = [level.geometry for level in levels[::-1]] + [tileset.finest]
    numbers = [level.level for level in levels[::-1]] + [0]
    count = tileset.object_count
    bounds = [_bounds(geometry) for geometry in geometries]
    low = np.min([bound[0] for bound in bounds], axis=0) * tileset.step
    high = np.max([bound[1] for bound in bounds], axis=0) * tileset.step
    rising = np.maximum.accumulate([np.zeros(count), *(level.errors for level in levels)], axis=0)[::-1]
    tiles = len(geometries)
    # Row 0 is the root; the chain of object k has the rows from 1 + k * tiles.
    parents = np.arange(count * tiles) + 0
    parents[::tiles] = 0
    boxes = np.repeat(np.stack((low, high), axis=1), tiles, axis=0)
    boxes = np.concatenate(([[low.min(axis=0), high.max(axis=0)]], boxes))
    names = [(TileContent(None, k, number),) for k in range(count) for number in numbers]
    return TileTree(
        np.concatenate(([-1], parents)),
        np.concatenate(([np.inf], rising.T.ravel())),
        np.arange(count * tiles + 1) == 0,
        boxes.mean(axis=1),
        np.eye(3) * (boxes[:, 1] - boxes[:, 0])[:, None] / 2,
        ((), *names),
    )


def _bounds(geometry: LevelFaces) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(K, 3) least and greatest grid coordinates of every object."""
    firsts = geometry.offsets[:-1]
    corners = geometry.corners.astype(np.int64)
    return (
        np.minimum.reduceat(corners.min(axis=1), firsts, axis=0),
        np.maximum.reduceat(corners.max(axis=1), firsts, axis=0),
    )


def _object(tileset: NavTileset, content: TileContent) -> Parts:
    geometry = tileset.finest
    if content.level:
        geometry = next(level.geometry for level in tileset.levels if level.level == content.level)
    first, last = geometry.offsets[content.content_id : content.content_id + 2]
    return (_part(content.content_id, content.level, geometry.corners[first:last]),)


def _file(tileset: NavTileset, content: TileContent) -> Parts:
    contents = {0: tileset.contents, **tileset.coarse}[content.level]
    reference = contents[content.content_id]
    glb = open_glb(reference.path)
    corners = [on_grid(glb.corners(k), tileset.step, reference) for k in range(reference.object_count)]
    return tuple(_part(k, content.level, smallest_first(faces)) for k, faces in enumerate(corners))


def _part(number: int, level: int, corners: NDArray[np.int32]) -> ObjectFaces:
    return ObjectFaces(number, level, 0, np.arange(len(corners), dtype=np.uint32), corners)
