"""Opening a tileset folder: cells, portals, sets, levels and deltas, mapped into memory."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.contents import EXTENSION, ContentRef, find_contents, object_offsets
from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.fields import JSON_LIMIT, Fields, parse_object
from tilesnav_ref.stream.glb import open_glb
from tilesnav_ref.stream.levels import Level, LevelFaces, LevelScale, read_faces, read_level, read_scale
from tilesnav_ref.stream.sector import Limits, Sector, open_sector
from tilesnav_ref.stream.state import Delta, State
from tilesnav_ref.stream.uris import read_bytes, resolve_uri


@dataclass(frozen=True)
class NavTileset:
    """A tileset with 3DTILES_nav; lengths in metres, nav frame."""

    path: Path
    """tileset.json."""
    step: float
    """Grid step, m."""
    tileset_from_nav: NDArray[np.float64]
    """(4, 4)."""
    clearance: float
    face_count: int
    object_count: int
    cell_count: int
    portal_count: int
    """Directed portals."""
    provenance: dict[str, Any]
    sectors: tuple[Sector, ...]
    contents: tuple[ContentRef, ...]
    max_range: float | None = None
    """Metres within which a face counts as visible; None for any distance."""
    certificates: tuple[Path, ...] = ()
    """Certificate files, of the sectors that have one."""
    coarse: dict[int, tuple[ContentRef, ...]] = field(default_factory=dict)
    """Contents with face maps of every level above 0; levels ascend."""
    scale: LevelScale = field(default_factory=LevelScale)
    """What level codes stand for."""

    @property
    def porous_objects(self) -> NDArray[np.int64]:
        """Numbers of the objects that are seen and hide nothing, ascending."""
        return self._objects([content.porous for content in self.contents])

    @property
    def one_sided_objects(self) -> NDArray[np.int64]:
        """Numbers of the objects whose faces are seen from their front only, ascending."""
        return self._objects([content.one_sided for content in self.contents])

    def _objects(self, indices: list[tuple[int, ...]]) -> NDArray[np.int64]:
        firsts = np.cumsum([0, *(content.object_count for content in self.contents)])
        numbers = [first + i for first, of_content in zip(firsts, indices, strict=False) for i in of_content]
        return np.array(numbers, np.int64)

    @cached_property
    def object_offsets(self) -> NDArray[np.int64]:
        """(K + 1,) first face of every object and the number of faces; read from the contents."""
        return object_offsets(self.contents)

    @cached_property
    def finest(self) -> LevelFaces:
        """Faces of level 0; read from the contents."""
        return read_faces(self.contents, self.object_offsets, self.step)

    @cached_property
    def levels(self) -> tuple[Level, ...]:
        """The coarse levels, ascending; read from contents and face maps, each with every check.

        Raises
        ------
        TilesetError
            When a content or a face map is not sound, or an object is not stood for exactly once.
        """
        return tuple(
            read_level(contents, self.object_offsets, self.step) for contents in self.coarse.values()
        )

    def state(self, cell: int) -> State:
        """What a client in a cell holds."""
        sector, row = self._locate(cell)
        codes = sector.codes[sector.objects.offsets[row] : sector.objects.offsets[row + 1]]
        return State(sector.faces.row(row), sector.objects.row(row), codes)

    def digest(self, cell: int) -> bytes:
        """SHA-256 that the file states for the state of a cell."""
        sector, row = self._locate(cell)
        return bytes(sector.digests[row])

    def neighbours(self, cell: int) -> NDArray[np.uint32]:
        """Cells behind the portals of a cell, ascending."""
        sector, row = self._locate(cell)
        return np.asarray(sector.targets.row(row), dtype=np.uint32)

    def delta(self, source: int, target: int) -> Delta:
        """Return the change on the way from a cell to a neighbour.

        Raises
        ------
        KeyError
            When there is no portal between them.
        """
        sector, portal = self._portal(source, target)
        codes = sector.switch_codes[sector.switched.offsets[portal] : sector.switched.offsets[portal + 1]]
        return Delta(sector.entered.row(portal), sector.left.row(portal), sector.switched.row(portal), codes)

    def portal_polygon(self, source: int, target: int) -> NDArray[np.float64]:
        """(V, 3) vertices around the polygon between two neighbours; KeyError when there is no portal."""
        sector, portal = self._portal(source, target)
        return np.asarray(sector.vertices.row(int(sector.polygons[portal])), dtype=np.float64)

    def corners(self, content_id: int) -> NDArray[np.float32]:
        """(F, 3, 3) corners of the faces of one content, in the order of their numbers."""
        content = self.contents[content_id]
        glb = open_glb(content.path)
        return np.concatenate([glb.corners(i) for i in range(len(glb.primitives))])

    def _locate(self, cell: int) -> tuple[Sector, int]:
        if not 0 <= cell < self.cell_count:
            raise IndexError(f"cell {cell}; allowed: 0 to {self.cell_count - 1}")
        firsts = [sector.first_cell for sector in self.sectors]
        sector = self.sectors[int(np.searchsorted(firsts, cell, side="right")) - 1]
        return sector, cell - sector.first_cell

    def _portal(self, source: int, target: int) -> tuple[Sector, int]:
        sector, row = self._locate(source)
        targets = sector.targets.row(row)
        place = int(np.searchsorted(targets, target))
        if place == len(targets) or targets[place] != target:
            raise KeyError(f"no portal leads from cell {source} to cell {target}")
        return sector, int(sector.targets.offsets[row]) + place


def open_tileset(place: Path) -> NavTileset:
    """Open a tileset.

    Parameters
    ----------
    place : Path
        A folder with tileset.json, or the entry tileset itself.

    Raises
    ------
    TilesetError
        When a file cannot be read, or is not what the specification calls for as far as reading depends on
        it.
    """
    path = place / "tileset.json" if place.is_dir() else place
    tileset = parse_object(read_bytes(path, JSON_LIMIT), str(path))
    if not tileset.has("extensions") or not tileset.fields("extensions").has(EXTENSION):
        raise tileset.error(
            "extensions", "nothing", f"an object {EXTENSION}: this tileset has no navigation data"
        )
    entry = tileset.fields("extensions").fields(EXTENSION)
    _check_version(entry)
    root = path.parent.resolve()
    scale = read_scale(entry.fields("lod"))
    limits = Limits(
        cells=entry.integer("cellCount", 1),
        faces=entry.integer("faceCount"),
        objects=entry.integer("objectCount"),
        levels=scale.level_count,
    )
    contents = find_contents(tileset, path.resolve(), root)
    if sum(content.face_count for content in contents.fine) != limits.faces:
        raise entry.error("faceCount", limits.faces, "the sum over the contents of level 0")
    if sum(content.object_count for content in contents.fine) != limits.objects:
        raise entry.error("objectCount", limits.objects, "the sum over the contents of level 0")
    return NavTileset(
        path=path,
        step=2.0 ** entry.fields("grid").integer("exponent", -20, 0),
        tileset_from_nav=np.reshape(entry.numbers("transform", 16), (4, 4)).T,
        clearance=entry.number("clearance"),
        face_count=limits.faces,
        object_count=limits.objects,
        cell_count=limits.cells,
        portal_count=entry.integer("portalCount"),
        provenance=entry.fields("provenance").members,
        sectors=_open_sectors(entry, root, limits),
        contents=contents.fine,
        max_range=_max_range(entry),
        certificates=tuple(
            resolve_uri(stated.fields("certificates"), root, root)
            for stated in entry.list_of_fields("sectors")
            if stated.has("certificates")
        ),
        coarse=contents.coarse,
        scale=scale,
    )


def _max_range(entry: Fields) -> float | None:
    if not entry.has("visibility"):
        return None
    visibility = entry.fields("visibility")
    value = visibility.number("maxRange")
    if value <= 0:
        raise visibility.error("maxRange", value, "a number greater than 0")
    return value


def _check_version(entry: Fields) -> None:
    version = entry.text("version")
    if version.split(".")[:2] != ["0", "1"]:
        raise entry.error("version", version, "0.1.x")


def _open_sectors(entry: Fields, root: Path, limits: Limits) -> tuple[Sector, ...]:
    sectors: list[Sector] = []
    next_cell = 0
    for stated in entry.list_of_fields("sectors"):
        sector = open_sector(resolve_uri(stated, root, root), limits)
        expected = (stated.integer("firstCell"), stated.integer("cellCount"))
        if (sector.first_cell, sector.cell_count) != expected or sector.first_cell != next_cell:
            found = f"cells from {sector.first_cell}, {sector.cell_count} of them"
            allowed = (
                f"{expected[1]} cells from {expected[0]}, as the entry object states, and from {next_cell}"
            )
            raise TilesetError(str(sector.path), "sector", found, allowed)
        sectors.append(sector)
        next_cell += sector.cell_count
    portals = sum(sector.portal_count for sector in sectors)
    if next_cell != limits.cells or portals != entry.integer("portalCount"):
        raise entry.error(
            "sectors", f"{next_cell} cells, {portals} portals", "cellCount cells, portalCount portals"
        )
    return tuple(sectors)
