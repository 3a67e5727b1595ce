"""Whether a triangle meets the relative interior of an axis-aligned rectangle, decided exactly.

Notes
-----
The triangle is cut by the rectangle's plane. A triangle inside that plane is tested against the rectangle
in two dimensions; any other leaves a segment or a point, whose ends are fractions with denominators below
2**25. The open rectangle and the segment are disjoint exactly when a side of the rectangle or the line of
the segment, which is where the triangle's plane passes, separates them weakly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.buckets import FaceBuckets, gather
from tilesnav_ref.cells.overlap import face_normal, sign_of_dot
from tilesnav_ref.kernels import kernel


@kernel
def _flat_meets(
    triangle: NDArray[np.int64], low: NDArray[np.int64], high: NDArray[np.int64], axis: int
) -> bool:
    """Triangle in the plane of the rectangle: separating axes in two dimensions."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    for k in (i, j):
        if max(triangle[0, k], triangle[1, k], triangle[2, k]) <= low[k]:
            return False
        if min(triangle[0, k], triangle[1, k], triangle[2, k]) >= high[k]:
            return False
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        di, dj = triangle[b, i] - triangle[a, i], triangle[b, j] - triangle[a, j]
        third = di * (triangle[c, j] - triangle[a, j]) - dj * (triangle[c, i] - triangle[a, i])
        p0, p1 = di * (low[j] - triangle[a, j]), di * (high[j] - triangle[a, j])
        q0, q1 = -dj * (low[i] - triangle[a, i]), -dj * (high[i] - triangle[a, i])
        if max(p0, p1) + max(q0, q1) <= min(0, third) or min(p0, p1) + min(q0, q1) >= max(0, third):
            return False
    return True


@kernel
def _cut_apart(
    triangle: NDArray[np.int64], low: NDArray[np.int64], high: NDArray[np.int64], axis: int, k: int
) -> bool:
    """Whether the cut of the triangle with the rectangle's plane lies beyond a side of the rectangle along
    axis k."""
    all_below, all_above = True, True
    for a in range(3):
        b = (a + 1) % 3
        da, db = triangle[a, axis] - low[axis], triangle[b, axis] - low[axis]
        if da == 0:
            all_below = all_below and triangle[a, k] <= low[k]
            all_above = all_above and triangle[a, k] >= high[k]
        if (da < 0 < db) or (db < 0 < da):
            # the edge crosses at a + (b - a) * da / (da - db); compare after multiplying by |da - db|
            width = abs(da - db)
            shift = (triangle[b, k] - triangle[a, k]) * abs(da)
            all_below = all_below and shift <= (low[k] - triangle[a, k]) * width
            all_above = all_above and shift >= (high[k] - triangle[a, k]) * width
    return all_below or all_above


@kernel
def _line_apart(
    triangle: NDArray[np.int64],
    low: NDArray[np.int64],
    high: NDArray[np.int64],
    normal: NDArray[np.int64],
    axis: int,
) -> bool:
    """Whether all corners of the rectangle lie on one closed side of the triangle's plane."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    point = np.empty(3, np.int64)
    point[axis] = low[axis] - triangle[0, axis]
    not_above, not_below = True, True
    for corner in range(4):
        point[i] = (low[i] if corner % 2 == 0 else high[i]) - triangle[0, i]
        point[j] = (low[j] if corner < 2 else high[j]) - triangle[0, j]
        sign = sign_of_dot(normal, point[0], point[1], point[2])
        not_above = not_above and sign <= 0
        not_below = not_below and sign >= 0
    return not_above or not_below


@kernel
def meets_rectangle(
    triangle: NDArray[np.int64],
    low: NDArray[np.int64],
    high: NDArray[np.int64],
    axis: int,
    normal: NDArray[np.int64],
) -> bool:
    """Whether a closed triangle meets the relative interior of a rectangle.

    Parameters
    ----------
    triangle
        (3, 3) grid coordinates, not degenerate, smaller than 2**24 in magnitude.
    low, high
        (3,) opposite corners of the rectangle; equal along ``axis``, low < high along the others.
    axis
        Coordinate axis that is normal to the rectangle.
    normal
        (3,) room for the triangle's normal.
    """
    below, above = False, False
    for a in range(3):
        below = below or triangle[a, axis] < low[axis]
        above = above or triangle[a, axis] > low[axis]
    if not below and not above:
        return bool(_flat_meets(triangle, low, high, axis))
    touches = False
    for a in range(3):
        touches = touches or triangle[a, axis] == low[axis]
    if not touches and not (below and above):
        return False
    if _cut_apart(triangle, low, high, axis, (axis + 1) % 3) or _cut_apart(
        triangle, low, high, axis, (axis + 2) % 3
    ):
        return False
    face_normal(triangle, normal)
    return not _line_apart(triangle, low, high, normal, axis)


@kernel
def _blocked(
    corners: NDArray[np.int64],
    frame: tuple[NDArray[np.int64], int, NDArray[np.int64]],
    lists: tuple[NDArray[np.int64], NDArray[np.int64]],
    rectangles: NDArray[np.int64],
    axes: NDArray[np.int64],
) -> NDArray[np.bool_]:
    result = np.zeros(len(rectangles), np.bool_)
    marks, room, normal = (
        np.full(len(corners), -1, np.int64),
        np.empty(len(corners), np.int64),
        np.empty(3, np.int64),
    )
    for r in range(len(rectangles)):
        count = gather(frame, lists, rectangles[r], (marks, r), room)
        for s in range(count):
            if meets_rectangle(corners[room[s]], rectangles[r, 0], rectangles[r, 1], axes[r], normal):
                result[r] = True
                break
    return result


def blocked_rectangles(
    buckets: FaceBuckets, rectangles: NDArray[np.int64], axes: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Which rectangles (R, 2, 3), normal to their axes (R,), have a face in their relative interior; (R,)
    bool."""
    frame = (buckets.origin, buckets.size, buckets.shape)
    return np.asarray(_blocked(buckets.corners, frame, (buckets.offsets, buckets.faces), rectangles, axes))
