"""What other ways of streaming the same tileset load along a route.

Notes
-----
Both look at places one after the other and load, at each, what they need there and do not hold. They are
given advantages that a viewer does not have: a content is there at once, none is asked for that is not
needed, ancestors of a tile that is shown are not loaded, and requests and headers cost nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.tiles import TileContent, TileTree

Points = NDArray[np.float64]


@dataclass(frozen=True)
class ScreenSettings:
    """The camera and the quality of a viewer."""

    maximum_error: float = 16.0
    """Pixels; the default of CesiumJS."""
    screen_height: int = 1080
    """Pixels."""
    field_of_view: float = 60.0
    """Degrees, vertical."""

    def __post_init__(self) -> None:
        """ValueError when a setting is out of range."""
        if not (self.maximum_error > 0 and self.screen_height > 0 and 0 < self.field_of_view < 180):
            raise ValueError(f"viewer: found {self}; allowed: positive values, less than 180 degrees")

    @property
    def pixels(self) -> float:
        """Pixels of a metre at a distance of one metre."""
        return self.screen_height / (2.0 * math.tan(math.radians(self.field_of_view) / 2.0))


def screen_selection(tree: TileTree, point: Points, settings: ScreenSettings) -> list[int]:
    """Choose the tiles that a viewer shows, seen from a point (3,) in the frame of the tileset.

    Returns
    -------
    list of int
        Tiles, ascending: all directions are looked at, since a LiDAR turns; nothing is culled.

    Notes
    -----
    A tile is refined where its geometric error, seen from the distance of its box, is more pixels than
    allowed; a refined tile is shown beside its children with ADD, and not with REPLACE.

    References
    ----------
    OGC 22-025r4, 3D Tiles Specification 1.1, 6.7 (geometric error, refinement).
    """
    distances = np.maximum(tree.distances(point), 1e-9)
    pixels = tree.errors * settings.pixels / distances
    has_children = np.zeros(tree.count, np.bool_)
    has_children[tree.parents[tree.parents >= 0]] = True
    refined = (pixels > settings.maximum_error) & has_children
    shown = np.zeros(tree.count, np.bool_)
    visited = np.zeros(tree.count, np.bool_)
    for tile, parent in enumerate(tree.parents):
        visited[tile] = parent < 0 or (visited[parent] and refined[parent])
        shown[tile] = visited[tile] and (not refined[tile] or tree.adds[tile])
    return [int(tile) for tile in np.flatnonzero(shown)]


def range_selection(tree: TileTree, point: Points, distance: float) -> list[int]:
    """Choose the tiles of the finest level whose boxes are within a distance, m, of a point (3,)."""
    near = tree.distances(point) <= distance
    return [
        int(tile)
        for tile in np.flatnonzero(near)
        if any(content.level == 0 for content in tree.contents[tile])
    ]


@dataclass(frozen=True)
class Loads:
    """Contents that a client loads at each place."""

    loaded: tuple[tuple[TileContent, ...], ...]
    """Of each place."""
    held: tuple[tuple[TileContent, ...], ...]
    """What it holds there."""


def follow(tree: TileTree, selections: Iterable[list[int]], forgets: bool) -> Loads:
    """Say what a client loads that needs these tiles at each place.

    Parameters
    ----------
    forgets : bool
        Whether it holds nothing but what it needs; otherwise it never drops anything.
    """
    loaded, held_at = [], []
    held: dict[TileContent, None] = {}
    for tiles in selections:
        needed = dict.fromkeys(content for tile in tiles for content in tree.contents[tile])
        loaded.append(tuple(content for content in needed if content not in held))
        held = needed if forgets else {**held, **needed}
        held_at.append(tuple(held))
    return Loads(tuple(loaded), tuple(held_at))
