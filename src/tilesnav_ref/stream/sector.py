"""The tables of one nav file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.container import map_container
from tilesnav_ref.stream.tables import Ragged, TableReader


@dataclass(frozen=True)
class Limits:
    """What the numbers in a nav file are less than; from the entry object."""

    cells: int
    faces: int
    objects: int
    levels: int


@dataclass(frozen=True)
class Sector:
    """Cells of one nav file, mapped into memory; lengths in metres, nav frame."""

    path: Path
    first_cell: int
    planes: NDArray[np.float64]
    """(N, 6, 4) outward unit normal and d; inside is n.x + d <= 0."""
    kinds: NDArray[np.uint8]
    """(N,) 0 aerial, 1 ground."""
    targets: Ragged
    """Global numbers of the cells behind the portals of each cell."""
    polygons: NDArray[np.uint32]
    """(M,) polygon of each directed portal."""
    vertices: Ragged
    """Vertices, rows of 3, of each polygon."""
    faces: Ragged
    """Faces of each cell."""
    proven_visible: NDArray[np.uint32]
    """(N,) number of the faces of each cell that are proven visible."""
    digests: NDArray[np.uint8]
    """(N, 32) SHA-256 of each state."""
    objects: Ragged
    """Visible objects of each cell."""
    codes: NDArray[np.uint8]
    """(Q,) level codes, parallel to the values of `objects`."""
    entered: Ragged
    """Faces entered behind each directed portal."""
    left: Ragged
    """Faces left behind each directed portal."""
    switched: Ragged
    """Objects switched behind each directed portal."""
    switch_codes: NDArray[np.uint8]
    """(S,) parallel to the values of `switched`."""
    table_bytes: dict[str, int]
    """Bytes of the tables by group."""

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return len(self.planes)

    @property
    def portal_count(self) -> int:
        """Number of directed portals."""
        return len(self.polygons)


def open_sector(path: Path, limits: Limits) -> Sector:
    """Map a nav file into memory.

    Raises
    ------
    TilesetError
        When container or tables are not sound: lengths, offsets, numbers out of range, order.
    """
    container = map_container(path)
    reader = TableReader(container, {})
    members = container.members
    place = members.fields("sector")
    count = place.integer("cellCount", 1, limits.cells)
    portals = members.fields("portals")
    portal_count, polygon_count = portals.integer("count"), portals.integer("polygonCount")
    pvs, lod, deltas = members.fields("pvs"), members.fields("lod"), members.fields("deltas")
    cells = members.fields("cells")
    return Sector(
        path=path,
        first_cell=place.integer("firstCell", 0, limits.cells - count),
        planes=reader.floats(cells, "planes", (count, 6, 4)),
        kinds=reader.plain(cells, "kinds", "u1", (count,), 2),
        targets=reader.lists(portals, ("offsets", "targets"), count, portal_count, limits.cells),
        polygons=reader.plain(portals, "polygons", "<u4", (portal_count,), polygon_count),
        vertices=reader.polygons(portals, polygon_count),
        faces=reader.lists(pvs, ("offsets", "faces"), count, pvs.integer("count"), limits.faces),
        proven_visible=reader.plain(pvs, "provenVisible", "<u4", (count,), limits.faces + 1),
        digests=reader.plain(pvs, "digests", "u1", (count, 32), 256),
        objects=reader.lists(lod, ("offsets", "objects"), count, lod.integer("count"), limits.objects),
        codes=reader.plain(lod, "codes", "u1", (lod.integer("count"),), limits.levels),
        entered=reader.lists(
            deltas, ("enteredOffsets", "entered"), portal_count, deltas.integer("enteredCount"), limits.faces
        ),
        left=reader.lists(
            deltas, ("leftOffsets", "left"), portal_count, deltas.integer("leftCount"), limits.faces
        ),
        switched=reader.lists(
            deltas,
            ("switchOffsets", "switchObjects"),
            portal_count,
            deltas.integer("switchCount"),
            limits.objects,
        ),
        switch_codes=reader.plain(
            deltas, "switchCodes", "u1", (deltas.integer("switchCount"),), limits.levels
        ),
        table_bytes=reader.group_bytes(),
    )
