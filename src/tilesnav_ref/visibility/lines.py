"""Free lines: every cell that a free segment between two faces crosses sees both faces.

So one ray serves all cells on its way. Embree finds the two ends of a line in float32; that is a suggestion.
For each cell on the line an exact segment from a point of the cell to a point of the face decides.

References
----------
J. Bittner, O. Mattausch, P. Wonka, V. Havran, M. Wimmer, Adaptive global visibility sampling, ACM TOG 28
(2009): a ray is shared by the view cells that it crosses.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.visibility.geometry import box_hierarchy
from tilesnav_ref.visibility.prisms import bounds_of, holds, slant
from tilesnav_ref.visibility.segments import nearest_inner_point
from tilesnav_ref.visibility.sight import STACK, inverse_direction, sees

LEAF_CELLS = 2
FAR = 2.0**31
"""Fine units; farther than any two points of a scene are apart."""


class CellPrisms(NamedTuple):
    """Cells for the kernels, with a hierarchy over them; fine units."""

    prisms: NDArray[np.float64]
    """(N, 8, 3)."""
    boxes: NDArray[np.float64]
    """(N, 2, 3) around them."""
    lower: NDArray[np.float64]
    """(B, 3) lower corner of each node."""
    upper: NDArray[np.float64]
    """(B, 3)."""
    child: NDArray[np.int32]
    """(B,) first child; the second follows it; -1 in a leaf."""
    first: NDArray[np.int32]
    """(B,) first position in order."""
    number: NDArray[np.int32]
    """(B,) number of cells below the node."""
    order: NDArray[np.int32]
    """(N,) cells in the order of the leaves."""


def cell_prisms(prisms: NDArray[np.float64]) -> CellPrisms:
    """Hierarchy over prisms (N, 8, 3)."""
    prisms = np.ascontiguousarray(prisms)
    boxes = bounds_of(prisms)
    return CellPrisms(prisms, boxes, *box_hierarchy(boxes[:, 0].copy(), boxes[:, 1].copy(), LEAF_CELLS))


@kernel
def share_lines(geometry, cells, lines, hits, seen):  # type: ignore[no-untyped-def]
    """Set seen[cell, face] for the faces at both ends of lines, for every cell that a line crosses.

    Parameters
    ----------
    geometry : Geometry
    cells : CellPrisms
    lines : (L, 3) points, fine units, and (L, 3) unit directions.
    hits : (2 L,) first faces hit, along the directions and then against them, -1 for none, and (2 L, 2)
        barycentric weights of corners 1 and 2. They are only suggestions.
    seen : (N, F) uint8. Entries are only ever set, to 1, so that threads may share it.
    """
    points, directions = lines
    faces, weights = hits
    number = len(points)
    for i in range(number):
        front, back = faces[i], faces[number + i]
        if front < 0 and back < 0:
            continue
        start = (points[i, 0], points[i, 1], points[i, 2])
        along = (float(directions[i, 0]), float(directions[i, 1]), float(directions[i, 2]))
        ends = (
            _end(geometry, front, weights[i], start),
            _end(geometry, back, weights[number + i], start),
        )
        least = _distance(start, along, ends[1][1]) if back >= 0 else -FAR
        most = _distance(start, along, ends[0][1]) if front >= 0 else FAR
        _walk(geometry, cells, (start, along, least, most), ends, seen)


@kernel
def share_passed(geometry, cells, lines, hits, seen):  # type: ignore[no-untyped-def]
    """Set seen[cell, face] for porous faces on lines, for every cell that sees them through what is porous.

    As `share_lines`, but `lines` has a third member: (2 L,) how far the line is free of opaque faces, along
    the directions and then against them, fine units.
    """
    points, directions, free = lines
    faces, weights = hits
    number = len(points)
    for i in range(number):
        if faces[i] < 0 and faces[number + i] < 0:
            continue
        start = (points[i, 0], points[i, 1], points[i, 2])
        along = (float(directions[i, 0]), float(directions[i, 1]), float(directions[i, 2]))
        ends = (
            _end(geometry, faces[i], weights[i], start),
            _end(geometry, faces[number + i], weights[number + i], start),
        )
        _walk(geometry, cells, (start, along, -free[number + i], free[i]), ends, seen)


@kernel
def _end(geometry, face, weights, start):  # type: ignore[no-untyped-def]
    """A face (-1: none) with the exact point on it that is nearest to a suggestion."""
    if face < 0:
        return face, start
    return face, nearest_inner_point(geometry.corners[face], weights[0], weights[1])


@kernel
def _distance(start, along, point):  # type: ignore[no-untyped-def]
    return (
        (point[0] - start[0]) * along[0] + (point[1] - start[1]) * along[1] + (point[2] - start[2]) * along[2]
    )


@kernel
def _walk(geometry, cells, line, ends, seen):  # type: ignore[no-untyped-def]
    """Visit the cells that a line crosses between its ends."""
    start, along, _, _ = line
    inverse = inverse_direction((0.0, 0.0, 0.0), along)
    stack = np.empty(STACK, np.int32)
    stack[0] = 0
    top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        enter, leave = _clip(cells.lower[node], cells.upper[node], line, inverse)
        if enter >= leave:
            continue
        if cells.child[node] >= 0:
            stack[top] = cells.child[node]
            stack[top + 1] = cells.child[node] + 1
            top += 2
            continue
        for k in range(cells.first[node], cells.first[node] + cells.number[node]):
            cell = cells.order[k]
            wanted = False
            for face, _ in ends:
                wanted = wanted or (face >= 0 and seen[cell, face] == 0)
            if not wanted:
                continue
            enter, leave = _clip(cells.boxes[cell, 0], cells.boxes[cell, 1], line, inverse)
            enter, leave = _clip_slants(cells.prisms[cell], (start, along, enter, leave))
            if enter < leave:
                at = _point_at(start, along, (enter + leave) / 2)
                _look(geometry, cells.prisms[cell], at, ends, seen[cell])


@kernel
def _clip(lower, upper, line, inverse):  # type: ignore[no-untyped-def]
    """The part of a line within a box, as distances from its start; empty where enter >= leave."""
    start, _, enter, leave = line
    for k in range(3):
        if inverse[k] == 0.0:
            if start[k] <= lower[k] or start[k] >= upper[k]:
                return 1.0, 0.0
        else:
            a = (lower[k] - start[k]) * inverse[k]
            b = (upper[k] - start[k]) * inverse[k]
            enter = max(enter, min(a, b))
            leave = min(leave, max(a, b))
    return enter, leave


@kernel
def _clip_slants(prism, line):  # type: ignore[no-untyped-def]
    """The part of a line between the slanted sides of a prism, about: points on it are decided exactly."""
    start, along, enter, leave = line
    u, v = slant(prism)
    if v < 0:
        return enter, leave
    for side in range(2):
        first = prism[side << v, v]
        slope = (prism[side << v | 1 << u, v] - first) / (prism[7, u] - prism[0, u])
        turn = 1.0 if side == 0 else -1.0
        height = turn * (start[v] - first - slope * (start[u] - prism[0, u]))
        rate = turn * (along[v] - slope * along[u])
        if rate > 0.0:
            enter = max(enter, -height / rate)
        elif rate < 0.0:
            leave = min(leave, -height / rate)
        elif height <= 0.0:
            return 1.0, 0.0
    return enter, leave


@kernel
def _point_at(start, along, distance):  # type: ignore[no-untyped-def]
    """The integer point nearest to a point of a line."""
    return (
        np.round(start[0] + distance * along[0]),
        np.round(start[1] + distance * along[1]),
        np.round(start[2] + distance * along[2]),
    )


@kernel
def _look(geometry, prism, point, ends, seen):  # type: ignore[no-untyped-def]
    """Decide by exact segments from an integer point, if that is inside the prism (8, 3)."""
    if not holds(prism, point):
        return
    for face, target in ends:
        if face >= 0 and seen[face] == 0 and sees(geometry, point, target, face):
            seen[face] = 1


@kernel
def worth_aiming(geometry, seen, cell, others):  # type: ignore[no-untyped-def]
    """Faces not seen from a cell that share an edge with one that is, or that one of some other cells sees.

    `seen` is (N, F) uint8, `others` (K,) cells. Returns ascending faces, int64.
    """
    mark = np.zeros(len(geometry.corners), np.bool_)
    for face in range(len(mark)):
        if seen[cell, face] == 0:
            continue
        for k in range(3):
            edge = geometry.face_edges[face, k]
            for j in range(geometry.edge_offsets[edge], geometry.edge_offsets[edge + 1]):
                mark[geometry.edge_faces[j]] = True
    for other in others:
        for face in range(len(mark)):
            if seen[other, face] != 0:
                mark[face] = True
    for face in range(len(mark)):
        if seen[cell, face] != 0:
            mark[face] = False
    return np.flatnonzero(mark)
