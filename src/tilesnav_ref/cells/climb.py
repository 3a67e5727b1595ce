"""Which cells a ground vehicle comes to: the graph of the places where it stands under cells.

Notes
-----
A node is a cell with a stand straight below it: the highest stand of a column that begins no higher than
the cell's lower side does, with nothing between them, and with the cell's upper side no higher than the given
height above it. Two nodes are
linked when they are in the same or in neighbouring columns, no gap between their heights is higher than the
step, and they belong to the same cell or to two cells that touch there. So a link is a way along the ground
through free space.

References
----------
M. Mononen, "Navigation mesh generation via voxelization and watershed partitioning", AiGameDev Paris 2010
(neighbouring spans within the walkable climb).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.buckets import FaceBuckets, boxes_with_faces
from tilesnav_ref.cells.standing import Stands, column_range
from tilesnav_ref.kernels import kernel

Frame = tuple[NDArray[np.int64], int, tuple[int, int]]
Table = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]


@dataclass(frozen=True)
class ClimbGraph:
    """Nodes in the order of their cells and stands, and links between them."""

    cells: NDArray[np.int64]
    """(N,) cell of each node."""
    stands: NDArray[np.int64]
    """(N,) stand of each node."""
    links: NDArray[np.int64]
    """(L, 2) nodes."""
    contacts: NDArray[np.int64]
    """(L,) contact that a link passes, or -1 within a cell."""


@kernel
def _height(cell: NDArray[np.int64], side: int, place: tuple[int, int]) -> float:
    """Height of the lower (0) or upper (4) side of a cell (8, 3) over a place of its plan."""
    share = np.empty(2)
    for k in range(2):
        low, high = cell[side, k], cell[side + 1 + k, k]
        share[k] = min(max((place[k] - low) / max(high - low, 1), 0.0), 1.0)
    first = cell[side, 2] + share[0] * (cell[side + 1, 2] - cell[side, 2])
    second = cell[side + 2, 2] + share[0] * (cell[side + 3, 2] - cell[side + 2, 2])
    return float(first + share[1] * (second - first))


@kernel
def _ends(cell: NDArray[np.int64], column: tuple[int, int, int]) -> tuple[int, int]:
    """Highest point of a cell's (8, 3) lower side over a column (x, y, size), and lowest of its upper."""
    x, y, size = column
    floor, top = _height(cell, 0, (x, y)), _height(cell, 4, (x, y))
    for corner in range(1, 4):
        place = (x + (corner & 1) * size, y + (corner >> 1) * size)
        floor, top = max(floor, _height(cell, 0, place)), min(top, _height(cell, 4, place))
    return math.ceil(floor), math.floor(top)


@kernel
def _visit_nodes(
    corners: NDArray[np.int64], frame: Frame, table: Table, height: int, nodes: NDArray[np.int64]
) -> int:
    """Count (nodes empty) or write cell, stand, column and lower end of the cell there of every node."""
    origin, size, shape = frame
    offsets, low, high = table
    count, store = 0, len(nodes) > 0
    for c in range(len(corners)):
        cell = corners[c]
        i0, i1 = column_range(cell[:, 0].min(), cell[:, 0].max(), origin[0], size, shape[0])
        j0, j1 = column_range(cell[:, 1].min(), cell[:, 1].max(), origin[1], size, shape[1])
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                column = i * shape[1] + j
                floor, top = _ends(cell, (origin[0] + i * size, origin[1] + j * size, size))
                s = offsets[column + 1] - 1
                while s >= offsets[column] and low[s] > floor:
                    s -= 1
                if s >= offsets[column] and top <= high[s] + height:
                    if store:
                        nodes[count, 0], nodes[count, 1], nodes[count, 2], nodes[count, 3] = (
                            c,
                            s,
                            column,
                            floor,
                        )
                    count += 1
    return count


def _free_nodes(
    corners: NDArray[np.int64], nodes: NDArray[np.int64], stands: Stands, space: tuple[FaceBuckets, int]
) -> NDArray[np.bool_]:
    """Which nodes (N, 4) have nothing between the stand and the cell; (N,) bool. ``space`` is faces and the
    clearance, within which of a cell no face is."""
    buckets, clearance = space
    cells, high = corners[nodes[:, 0]], stands.high[nodes[:, 1]]
    gaps = np.stack((cells.min(axis=1), cells.max(axis=1)), axis=1)
    place = stands.origin + np.column_stack(np.divmod(nodes[:, 2], stands.shape[1])) * stands.size
    gaps[:, 0, :2] = np.maximum(gaps[:, 0, :2], place)
    gaps[:, 1, :2] = np.minimum(gaps[:, 1, :2], place + stands.size)
    gaps[:, 0, 2], gaps[:, 1, 2] = high, nodes[:, 3]
    asked = np.flatnonzero(nodes[:, 3] > high + clearance)
    free = np.ones(len(nodes), np.bool_)
    free[asked] = ~boxes_with_faces(buckets, gaps[asked])
    return free


@kernel
def _node(stands: NDArray[np.int64], start: int, end: int, stand: int) -> int:
    """Place of a stand among the ascending ones of a cell's nodes start:end, or -1."""
    last = end
    while start < end:
        middle = (start + end) >> 1
        if stands[middle] < stand:
            start = middle + 1
        else:
            end = middle
    return start if start < last and stands[start] == stand else -1


@kernel
def _visit_beside(
    node: tuple[int, int, int],
    stands: NDArray[np.int64],
    span: tuple[int, int],
    ground: tuple[tuple[int, int], Table, int],
    count: int,
    found: NDArray[np.int64],
) -> int:
    """Links of a node (number, column, contact) to nodes of a span in its own and the four columns around.

    ``ground`` is the shape, table and step of the columns; returns the new count.
    """
    shape, (offsets, low, high), step = ground
    number, column, contact = node
    here, i, j, store = stands[number], column // shape[1], column % shape[1], len(found) > 0
    for side in range(5):
        a = i + (1 if side == 1 else 0) - (1 if side == 2 else 0)
        b = j + (1 if side == 3 else 0) - (1 if side == 4 else 0)
        if not (0 <= a < shape[0] and 0 <= b < shape[1]):
            continue
        for s in range(offsets[a * shape[1] + b], offsets[a * shape[1] + b + 1]):
            if low[s] > high[here] + step or low[here] > high[s] + step:
                continue
            other = _node(stands, span[0], span[1], s)
            if other >= 0 and other != number:
                if store:
                    found[count, 0], found[count, 1], found[count, 2] = number, other, contact
                count += 1
    return count


@kernel
def _visit_links(
    graph: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]],
    contacts: tuple[NDArray[np.int64], NDArray[np.int64]],
    frame: Frame,
    table: Table,
    step: int,
    found: NDArray[np.int64],
) -> int:
    """Count (found empty) or write both nodes and the contact of every link."""
    starts, stands, columns = graph
    pairs, rectangles = contacts
    origin, size, shape = frame
    ground, count = (shape, table, step), 0
    for c in range(len(starts) - 1):
        for n in range(starts[c], starts[c + 1]):
            node, span = (n, columns[stands[n]], -1), (starts[c], starts[c + 1])
            count = _visit_beside(node, stands, span, ground, count, found)
    for q in range(len(pairs)):
        i0, i1 = column_range(rectangles[q, 0, 0] - 1, rectangles[q, 1, 0] + 1, origin[0], size, shape[0])
        j0, j1 = column_range(rectangles[q, 0, 1] - 1, rectangles[q, 1, 1] + 1, origin[1], size, shape[1])
        first, second = pairs[q]
        span = (starts[second], starts[second + 1])
        for n in range(starts[first], starts[first + 1]):
            column = columns[stands[n]]
            if i0 <= column // shape[1] <= i1 and j0 <= column % shape[1] <= j1:
                count = _visit_beside((n, column, q), stands, span, ground, count, found)
    return count


def climb_graph(
    corners: NDArray[np.int64],
    contacts: tuple[NDArray[np.int64], NDArray[np.int64]],
    stands: Stands,
    limits: tuple[int, int],
    space: tuple[FaceBuckets, int],
) -> ClimbGraph:
    """Find nodes and links.

    Parameters
    ----------
    corners
        (N, 8, 3) of the cells, grid.
    contacts
        (Q, 2) cells that touch, and (Q, 2, 3) bounds of where they do.
    stands
        Where vehicles stand.
    limits
        Height of a cell's upper side above a stand, and step, grid steps.
    space
        Faces, and the clearance of the cells, grid steps.
    """
    frame = (stands.origin, stands.size, stands.shape)
    table = (stands.offsets, stands.low, stands.high)
    corners = np.ascontiguousarray(corners)
    count = _visit_nodes(corners, frame, table, limits[0], np.empty((0, 4), np.int64))
    nodes = np.empty((count, 4), np.int64)
    if count:
        _visit_nodes(corners, frame, table, limits[0], nodes)
        nodes = nodes[_free_nodes(corners, nodes, stands, space)]
    starts = np.searchsorted(nodes[:, 0], np.arange(len(corners) + 1)).astype(np.int64)
    graph = (starts, np.ascontiguousarray(nodes[:, 1]), stands.column)
    count = _visit_links(graph, contacts, frame, table, limits[1], np.empty((0, 3), np.int64))
    links = np.empty((count, 3), np.int64)
    if count:
        _visit_links(graph, contacts, frame, table, limits[1], links)
    return ClimbGraph(nodes[:, 0], nodes[:, 1], links[:, :2], links[:, 2])
