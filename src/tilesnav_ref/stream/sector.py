"""The tables of one nav file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.container import Container, map_container
from tilesnav_ref.stream.fields import Fields

Table = NDArray[Any]


@dataclass(frozen=True)
class Limits:
    """What the numbers in a nav file are less than; from the entry object."""

    cells: int
    faces: int
    objects: int
    levels: int


@dataclass(frozen=True)
class Ragged:
    """Lists one behind the other."""

    offsets: NDArray[np.uint32]
    """(R + 1,)."""
    values: Table

    def row(self, index: int) -> Table:
        """Return one list."""
        return self.values[self.offsets[index] : self.offsets[index + 1]]


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
    reader = _TableReader(container, {})
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


@dataclass(frozen=True)
class _TableReader:
    container: Container
    owners: dict[int, str]
    """Place of the table of each buffer view that has been read."""

    def table(self, owner: Fields, name: str, dtype: str, shape: tuple[int, ...]) -> Table:
        """Read a table from a buffer view that no other table has."""
        table = self.container.table(owner, name, dtype, shape)
        view = owner.integer(name)
        if view in self.owners:
            raise owner.error(
                name, f"buffer view {view}, as {self.owners[view]}", "one table for each buffer view"
            )
        self.owners[view] = f"{owner.place}.{name}"
        return table

    def group_bytes(self) -> dict[str, int]:
        """Bytes of the tables that have been read, by group."""
        groups: dict[str, int] = {}
        for view, place in self.owners.items():
            first, last = self.container.views[view]
            group = place.partition(".")[0]
            groups[group] = groups.get(group, 0) + last - first
        return groups

    def plain(self, owner: Fields, name: str, dtype: str, shape: tuple[int, ...], limit: int) -> Table:
        """Read numbers that are all less than limit."""
        table = self.table(owner, name, dtype, shape)
        if table.size and int(table.max()) >= limit:
            raise owner.error(name, int(table.max()), f"numbers less than {limit}")
        return table

    def floats(self, owner: Fields, name: str, shape: tuple[int, ...]) -> Table:
        table = self.table(owner, name, "<f8", shape)
        if not np.isfinite(table).all():
            raise owner.error(name, "a value that is not finite", "finite numbers")
        return table

    def offsets(self, owner: Fields, name: str, rows: int, total: int) -> Table:
        offsets = self.table(owner, name, "<u4", (rows + 1,))
        if offsets[0] != 0 or offsets[-1] != total or np.any(offsets[1:] < offsets[:-1]):
            raise owner.error(name, "other offsets", f"offsets from 0 to {total} that do not decrease")
        return offsets

    def lists(self, owner: Fields, names: tuple[str, str], rows: int, total: int, limit: int) -> Ragged:
        """Read lists of numbers less than limit, strictly ascending within each list."""
        offsets = self.offsets(owner, names[0], rows, total)
        values = self.plain(owner, names[1], "<u4", (total,), limit)
        falls = np.flatnonzero(values[1:] <= values[:-1]) + 1
        inside = falls[~np.isin(falls, offsets)]
        if inside.size:
            raise owner.error(names[1], f"element {inside[0]} not above the one before", "ascending lists")
        return Ragged(offsets, values)

    def polygons(self, portals: Fields, rows: int) -> Ragged:
        total = portals.integer("vertexCount")
        return Ragged(
            self.offsets(portals, "polygonOffsets", rows, total), self.floats(portals, "vertices", (total, 3))
        )
