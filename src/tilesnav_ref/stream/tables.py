"""Tables of a container: plain ones and lists one behind the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.container import Container
from tilesnav_ref.stream.fields import Fields

Table = NDArray[Any]


def lengths(offsets: NDArray[Any]) -> NDArray[np.int64]:
    """(R,) differences of neighbouring offsets; files have them without sign, so they are widened first."""
    return np.asarray(np.diff(offsets.astype(np.int64)), dtype=np.int64)


@dataclass(frozen=True)
class Ragged:
    """Lists one behind the other."""

    offsets: NDArray[Any]
    """(R + 1,) uint32 as files have them, or int64."""
    values: Table

    def row(self, index: int) -> Table:
        """Return one list."""
        return self.values[self.offsets[index] : self.offsets[index + 1]]

    def lengths(self) -> NDArray[np.int64]:
        """(R,) number of elements of every list."""
        return lengths(self.offsets)

    def take(self, rows: NDArray[np.int64]) -> Ragged:
        """Return the lists of some rows in the order of these.

        Examples
        --------
        >>> lists = Ragged(np.array([0, 2, 2, 3]), np.array([7, 8, 9]))
        >>> taken = lists.take(np.array([2, 0]))
        >>> taken.offsets.tolist(), taken.values.tolist()
        ([0, 1, 3], [9, 7, 8])
        """
        starts = self.offsets[rows].astype(np.int64)
        lengths = self.offsets[rows + 1].astype(np.int64) - starts
        offsets = np.concatenate((np.zeros(1, np.int64), np.cumsum(lengths)))
        places = np.arange(offsets[-1]) + np.repeat(starts - offsets[:-1], lengths)
        return Ragged(offsets, self.values[places])


@dataclass(frozen=True)
class TableReader:
    """Reads the tables of a container, each from a buffer view of its own."""

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
        """Read numbers that are all finite."""
        table = self.table(owner, name, "<f8", shape)
        if not np.isfinite(table).all():
            raise owner.error(name, "a value that is not finite", "finite numbers")
        return table

    def offsets(self, owner: Fields, name: str, rows: int, total: int) -> Table:
        """Read offsets of lists: from 0 to the total, not decreasing."""
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
        """Read the vertices of polygons."""
        total = portals.integer("vertexCount")
        return Ragged(
            self.offsets(portals, "polygonOffsets", rows, total), self.floats(portals, "vertices", (total, 3))
        )
