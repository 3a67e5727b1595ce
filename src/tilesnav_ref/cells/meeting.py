"""Whether a triangle meets the interior of a prism over a trapezoid, decided exactly in 64-bit integers.

Notes
-----
The open prism P and the closed triangle T are disjoint exactly when a plane parallel to a side of the prism,
to the triangle, or to one edge of each separates them weakly: the separating axis test. An edge of the prism
has one of four directions (along v, along w, along either slanted side).

A cell with every plane moved outwards by the clearance is no prism with corners on the grid, because the
normals of slanted sides have irrational lengths. It lies in one: `inflate` moves the corners outwards and
rounds them away from the cell. So a triangle that does not meet that prism does not meet the moved cell.

Bounds: coordinates are smaller than 2**24 in magnitude, so differences than 2**25 and components of a cross
product than 2**51, as `sign_of_dot` asks.

References
----------
S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree: a hierarchical structure for rapid interference detection",
SIGGRAPH 1996.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.buckets import FaceBuckets, gather
from tilesnav_ref.cells.overlap import face_normal, sign_of_dot
from tilesnav_ref.cells.prisms import H0, H1, L0, L1, U0, U1, W0, W1, WIDTH, U, V, W, write_bounds
from tilesnav_ref.kernels import kernel

STEEPEST = 2
"""Largest slope of a slanted side, along v over along u. A steeper one is made with u and v exchanged."""
REACH = 5
"""A prism whose slopes are allowed reaches less than this many clearances, and three steps for rounding, out
of its bounds when it is inflated: 2 + sqrt(1 + 2 * 2) = 4.24."""


@kernel
def _ceil_divided(value: int, by: int) -> int:
    return -((-value) // by)


@kernel
def inflate(row: NDArray[np.int64], clearance: int, result: NDArray[np.int64]) -> None:
    """Write the row of a prism that holds the given one with every plane moved outwards by the clearance.

    For a box it is that polyhedron; else its slanted sides lie further out by a few grid steps at most.
    """
    result[:] = row
    result[U0], result[U1] = row[U0] - clearance, row[U1] + clearance
    result[W0], result[W1] = row[W0] - clearance, row[W1] + clearance
    run = row[U1] - row[U0]
    for side in range(2):
        near, far = L0 + 2 * side, L1 + 2 * side
        slant = row[far] - row[near]
        # a line moved by the clearance along its normal moves by clearance * |(run, slant)| / run along v;
        # the product is below 2**48, so its rounding is below 1, and 2 is more than that and the fraction
        shift = clearance * run
        if slant != 0 and clearance > 0:
            shift = int(clearance * math.sqrt(float(run * run + slant * slant))) + 2
        if side == 0:
            result[near] = row[near] - _ceil_divided(shift + slant * clearance, run)
            result[far] = row[far] - _ceil_divided(shift - slant * clearance, run)
        else:
            result[near] = row[near] + _ceil_divided(shift - slant * clearance, run)
            result[far] = row[far] + _ceil_divided(shift + slant * clearance, run)


@kernel
def _apart_by_sides(t: NDArray[np.int64], row: NDArray[np.int64]) -> bool:
    """Whether a side of the prism separates; triangle in the coordinates u, v, w."""
    if max(t[0, 0], t[1, 0], t[2, 0]) <= row[U0] or min(t[0, 0], t[1, 0], t[2, 0]) >= row[U1]:
        return True
    if max(t[0, 2], t[1, 2], t[2, 2]) <= row[W0] or min(t[0, 2], t[1, 2], t[2, 2]) >= row[W1]:
        return True
    run, low, high = row[U1] - row[U0], row[L1] - row[L0], row[H1] - row[H0]
    below, above = True, True
    for a in range(3):
        along = t[a, 0] - row[U0]
        below = below and (t[a, 1] - row[L0]) * run <= low * along
        above = above and (t[a, 1] - row[H0]) * run >= high * along
    return below or above


@kernel
def _apart_along(t: NDArray[np.int64], corners: NDArray[np.int64], normal: NDArray[np.int64]) -> bool:
    """Whether a plane with this normal separates triangle and corners (8, 3); no normal, no plane."""
    if normal[0] == 0 and normal[1] == 0 and normal[2] == 0:
        return False
    least, most = 0, 0
    for a in range(1, 3):
        x, y, z = t[a, 0] - t[least, 0], t[a, 1] - t[least, 1], t[a, 2] - t[least, 2]
        if sign_of_dot(normal, x, y, z) < 0:
            least = a
        x, y, z = t[a, 0] - t[most, 0], t[a, 1] - t[most, 1], t[a, 2] - t[most, 2]
        if sign_of_dot(normal, x, y, z) > 0:
            most = a
    below, above = True, True
    for c in range(8):
        if below:
            x, y, z = corners[c, 0] - t[least, 0], corners[c, 1] - t[least, 1], corners[c, 2] - t[least, 2]
            below = sign_of_dot(normal, x, y, z) <= 0
        if above:
            x, y, z = corners[c, 0] - t[most, 0], corners[c, 1] - t[most, 1], corners[c, 2] - t[most, 2]
            above = sign_of_dot(normal, x, y, z) >= 0
        if not below and not above:
            return False
    return True


@kernel
def _apart_by_edges(
    t: NDArray[np.int64], row: NDArray[np.int64], corners: NDArray[np.int64], normal: NDArray[np.int64]
) -> bool:
    """Whether a plane along an edge of each separates."""
    run = row[U1] - row[U0]
    for a in range(3):
        b = (a + 1) % 3
        du, dv, dw = t[b, 0] - t[a, 0], t[b, 1] - t[a, 1], t[b, 2] - t[a, 2]
        normal[0], normal[1], normal[2] = dv, -du, 0
        if _apart_along(t, corners, normal):
            return True
        normal[0], normal[1], normal[2] = -dw, 0, du
        if _apart_along(t, corners, normal):
            return True
        for side in range(2):
            slant = row[L1 + 2 * side] - row[L0 + 2 * side]
            normal[0], normal[1], normal[2] = -dw * slant, dw * run, du * slant - dv * run
            if _apart_along(t, corners, normal):
                return True
    return False


@kernel
def meets_prism(
    triangle: NDArray[np.int64], row: NDArray[np.int64], room: tuple[NDArray[np.int64], NDArray[np.int64]]
) -> bool:
    """Whether a closed triangle meets the open prism.

    Parameters
    ----------
    triangle
        (3, 3) grid coordinates, smaller than 2**24 in magnitude.
    row
        (11,) prism, same bound; see prisms.py.
    room
        (11, 3) and (3,) int64, written to.

    Returns
    -------
    bool
        Exact; a triangle that only touches the boundary does not meet the interior. A degenerate triangle
        is taken for the segment or point that it is.

    Examples
    --------
    >>> t = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]])
    >>> room = np.empty((11, 3), np.int64), np.empty(3, np.int64)
    >>> meets_prism(t, np.array([0, 1, 2, 0, 4, -1, 1, 3, 0, 9, 9]), room)
    True
    >>> meets_prism(t, np.array([0, 1, 2, 0, 4, -1, 1, 4, 0, 9, 9]), room)
    False
    """
    corners, normal = room
    t = corners[8:]
    for a in range(3):
        t[a, 0], t[a, 1], t[a, 2] = triangle[a, row[U]], triangle[a, row[V]], triangle[a, row[W]]
    if _apart_by_sides(t, row):
        return False
    for c in range(8):
        up, right, deep = c & 1, (c >> 1) & 1, (c >> 2) & 1
        corners[c, 0], corners[c, 1], corners[c, 2] = row[U0 + up], row[L0 + 2 * right + up], row[W0 + deep]
    face_normal(t, normal)
    if _apart_along(t, corners, normal):
        return False
    return not _apart_by_edges(t, row, corners, normal)


@kernel
def is_clear(
    corners: NDArray[np.int64],
    row: NDArray[np.int64],
    clearance: int,
    room: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]],
) -> bool:
    """Whether none of the faces (F, 3, 3) meets the prism with every plane moved outwards by the clearance.

    ``room`` is (11, 3), (3,) and (11,).
    """
    inflated, clear = room[2], True
    inflate(row, clearance, inflated)
    for f in range(len(corners)):
        if meets_prism(corners[f], inflated, (room[0], room[1])):
            clear = False
            break
    return clear


@kernel
def _occupied(
    corners: NDArray[np.int64],
    frame: tuple[NDArray[np.int64], int, NDArray[np.int64]],
    lists: tuple[NDArray[np.int64], NDArray[np.int64]],
    prisms: tuple[NDArray[np.int64], int],
    chosen: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    rows, clearance = prisms
    result = np.zeros(len(rows), np.bool_)
    marks, near = np.full(len(corners), -1, np.int64), np.empty(len(corners), np.int64)
    room, inflated = (np.empty((11, 3), np.int64), np.empty(3, np.int64)), np.empty(WIDTH, np.int64)
    bounds = np.empty((2, 3), np.int64)
    for p in range(len(rows)):
        inflate(rows[p], clearance, inflated)
        write_bounds(inflated, bounds)
        count = gather(frame, lists, bounds, (marks, p), near)
        for s in range(count):
            if chosen[near[s]] and meets_prism(corners[near[s]], inflated, room):
                result[p] = True
                break
    return result


def prisms_with_faces(
    buckets: FaceBuckets,
    prisms: NDArray[np.int64],
    clearance: int = 0,
    chosen: NDArray[np.bool_] | None = None,
) -> NDArray[np.bool_]:
    """Which open prisms (P, 11), inflated, meet a (chosen) face; for prisms inside the box of the buckets.

    Returns
    -------
    ndarray
        (P,) bool; exact without a clearance, else see :func:`inflate`.
    """
    if chosen is None:
        chosen = np.ones(len(buckets.corners), np.bool_)
    frame = (buckets.origin, buckets.size, buckets.shape)
    lists = (buckets.offsets, buckets.faces)
    return np.asarray(_occupied(buckets.corners, frame, lists, (prisms, clearance), chosen))
