"""The portals of a tileset as a graph: gates, and ways between them through the cells that they share."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.reader import NavTileset
from tilesnav_ref.stream.sector import Sector

NOWHERE = -9999
"""What scipy puts where a node has no predecessor."""


@dataclass(frozen=True)
class Gates:
    """Portals, each once for both directions; lengths in metres, nav frame."""

    cells: NDArray[np.int64]
    """(G, 2) cells on its two sides, ascending."""
    offsets: NDArray[np.int64]
    """(G + 1,) first vertex of each gate, and the number of vertices."""
    vertices: NDArray[np.float64]
    """(V, 3) vertices around each gate; a gate is a convex polygon, or a line between two points."""
    cell_count: int

    @property
    def count(self) -> int:
        """Number of gates."""
        return len(self.cells)

    def polygon(self, gate: int) -> NDArray[np.float64]:
        """(K, 3) vertices around a gate."""
        return self.vertices[self.offsets[gate] : self.offsets[gate + 1]]

    @cached_property
    def middles(self) -> NDArray[np.float64]:
        """(G, 3) means of the vertices."""
        if self.count == 0:
            return np.zeros((0, 3))
        sums = np.add.reduceat(self.vertices, self.offsets[:-1], axis=0)
        return np.asarray(sums / np.diff(self.offsets)[:, None])

    @cached_property
    def _by_cell(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """(N + 1,) offsets and (2 G,) gates of each cell, ascending."""
        gates = np.repeat(np.arange(self.count), 2)
        order = np.argsort(self.cells.ravel(), kind="stable")
        counts = np.bincount(self.cells.ravel(), minlength=self.cell_count)
        return np.concatenate(([0], np.cumsum(counts))), gates[order]

    def of_cell(self, cell: int) -> NDArray[np.int64]:
        """Gates of a cell, ascending."""
        offsets, gates = self._by_cell
        return gates[offsets[cell] : offsets[cell + 1]]

    @cached_property
    def graph(self) -> csr_array:
        """(G, G) distance between the middles of every two gates of a cell.

        Notes
        -----
        Two gates share one cell at most, since a gate is all that two cells have in common.
        """
        offsets, gates = self._by_cell
        counts = np.diff(offsets)
        # Every gate of a cell with every gate of it: row i of the cell's square begins at its first gate.
        widths = np.repeat(counts, counts)
        firsts = np.repeat(offsets[:-1], counts)
        rows = np.repeat(np.arange(len(gates)), widths)
        columns = firsts[rows] + np.arange(len(rows)) - np.repeat(np.cumsum(widths) - widths, widths)
        sources, targets = gates[rows], gates[columns]
        apart = sources != targets
        sources, targets = sources[apart], targets[apart]
        lengths = np.linalg.norm(self.middles[sources] - self.middles[targets], axis=1)
        return csr_array((lengths, (sources, targets)), shape=(self.count, self.count))

    def select(self, kept: NDArray[np.int64], lines: NDArray[np.float64]) -> Gates:
        """Some gates, narrowed to lines (K, 2, 3) within them."""
        offsets = np.arange(len(kept) + 1, dtype=np.int64) * 2
        return Gates(self.cells[kept], offsets, lines.reshape(-1, 3), self.cell_count)


@dataclass(frozen=True)
class Reach:
    """Shortest ways from a start to all gates."""

    lengths: NDArray[np.float64]
    """(G,) m; infinity where no way leads."""
    before: NDArray[np.int64]
    """(G,) gate before each on its way; negative at the first and where no way leads."""

    def way(self, gate: int) -> list[int]:
        """Gates of the way to one, in order."""
        gates = [gate]
        while self.before[gates[-1]] >= 0:
            gates.append(int(self.before[gates[-1]]))
        return gates[::-1]


def reach_from_gate(gates: Gates, start: int) -> Reach:
    """Shortest ways from the middle of a gate (Dijkstra)."""
    lengths, before = dijkstra(gates.graph, indices=start, return_predecessors=True)
    return Reach(lengths, before.astype(np.int64))


def reach_from_point(gates: Gates, point: NDArray[np.float64], cell: int) -> Reach:
    """Shortest ways from a point (3,) in a cell through the middles of gates (Dijkstra)."""
    graph, first = gates.graph, gates.of_cell(cell)
    lengths = np.linalg.norm(gates.middles[first] - point, axis=1)
    size = gates.count + 1
    with_start = csr_array(
        (
            np.concatenate((graph.data, lengths)),
            np.concatenate((graph.indices, first.astype(graph.indices.dtype))),
            np.append(graph.indptr, graph.indptr[-1] + len(first)),
        ),
        shape=(size, size),
    )
    found, before = dijkstra(with_start, indices=gates.count, return_predecessors=True)
    before = before[:-1].astype(np.int64)
    return Reach(found[:-1], np.where(before == gates.count, NOWHERE, before))


def gates_of(tileset: NavTileset) -> Gates:
    """Collect the portals of all sectors; TilesetError where a polygon has fewer than three vertices."""
    parts = [_of_sector(sector) for sector in tileset.sectors]
    cells = np.concatenate([part[0] for part in parts])
    counts = np.concatenate([part[1] for part in parts])
    vertices = np.concatenate([part[2] for part in parts])
    return Gates(cells, np.concatenate(([0], np.cumsum(counts))), vertices, tileset.cell_count)


def _of_sector(sector: Sector) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Cells (G, 2), numbers of vertices (G,) and vertices of the portals to cells of a greater number."""
    starts = sector.targets.offsets.astype(np.int64)
    portals = starts[1:] - starts[:-1]
    sources = np.repeat(np.arange(sector.cell_count) + sector.first_cell, portals)
    targets = sector.targets.values.astype(np.int64)
    forward = sources < targets
    polygons = sector.polygons[forward].astype(np.int64)
    offsets = sector.vertices.offsets.astype(np.int64)
    counts = offsets[polygons + 1] - offsets[polygons]
    if counts.size and counts.min() < 3:
        raise TilesetError(str(sector.path), "portals", f"a polygon of {counts.min()} vertices", "3 or more")
    # The vertices of the polygons one behind the other.
    rows = np.repeat(offsets[polygons] - (np.cumsum(counts) - counts), counts) + np.arange(int(counts.sum()))
    return (
        np.column_stack((sources[forward], targets[forward])),
        counts,
        np.asarray(sector.vertices.values, np.float64).reshape(-1, 3)[rows],
    )
