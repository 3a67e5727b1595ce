"""Whether a triangle meets the interior of a box, decided exactly in 64-bit integers.

Notes
-----
The open box B and the closed triangle T are disjoint exactly when the origin is not in the open polytope
B - T, that is when one of its facet planes separates them weakly. These planes are parallel to a side of
the box, to the triangle, or to one edge of each: the thirteen axes of the separating axis test. Touching is
therefore no meeting, and every comparison below admits equality.

Bounds: coordinates are smaller than 2**24 in magnitude (grid limit 2**23 plus the clearance), differences
than 2**25, a two-dimensional cross product than 2**51. Only the test by the triangle's plane is wider (76
bits); it takes the product in two halves.

References
----------
S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree: a hierarchical structure for rapid interference detection",
SIGGRAPH 1996.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel

_HALF = 26
_MASK = (1 << _HALF) - 1


@kernel
def sign_of_dot(normal: NDArray[np.int64], x: int, y: int, z: int) -> int:
    """Exact sign of normal . (x, y, z) for \\|normal\\| < 2**52 and \\|x\\|, \\|y\\|, \\|z\\| < 2**26 by
    component."""
    high = (normal[0] >> _HALF) * x + (normal[1] >> _HALF) * y + (normal[2] >> _HALF) * z
    low = (normal[0] & _MASK) * x + (normal[1] & _MASK) * y + (normal[2] & _MASK) * z
    high += low >> _HALF
    if high != 0:
        return 1 if high > 0 else -1
    return 1 if (low & _MASK) != 0 else 0


@kernel
def face_normal(triangle: NDArray[np.int64], normal: NDArray[np.int64]) -> None:
    """Cross product of two edges of a (3, 3) triangle, written to normal; components below 2**52."""
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        normal[k] = (triangle[1, i] - triangle[0, i]) * (triangle[2, j] - triangle[0, j]) - (
            triangle[1, j] - triangle[0, j]
        ) * (triangle[2, i] - triangle[0, i])


@kernel
def _apart_by_bounds(triangle: NDArray[np.int64], lower: NDArray[np.int64], upper: NDArray[np.int64]) -> bool:
    for k in range(3):
        if max(triangle[0, k], triangle[1, k], triangle[2, k]) <= lower[k]:
            return True
        if min(triangle[0, k], triangle[1, k], triangle[2, k]) >= upper[k]:
            return True
    return False


@kernel
def _apart_by_plane(
    triangle: NDArray[np.int64], normal: NDArray[np.int64], lower: NDArray[np.int64], upper: NDArray[np.int64]
) -> bool:
    """Whether the box lies on one side of the triangle's plane."""
    if normal[0] == 0 and normal[1] == 0 and normal[2] == 0:
        return False
    x0, x1 = lower[0] - triangle[0, 0], upper[0] - triangle[0, 0]
    y0, y1 = lower[1] - triangle[0, 1], upper[1] - triangle[0, 1]
    z0, z1 = lower[2] - triangle[0, 2], upper[2] - triangle[0, 2]
    if normal[0] < 0:
        x0, x1 = x1, x0
    if normal[1] < 0:
        y0, y1 = y1, y0
    if normal[2] < 0:
        z0, z1 = z1, z0
    return bool(sign_of_dot(normal, x1, y1, z1) <= 0 or sign_of_dot(normal, x0, y0, z0) >= 0)


@kernel
def _apart_by_edges(
    triangle: NDArray[np.int64], lower: NDArray[np.int64], upper: NDArray[np.int64], k: int
) -> bool:
    """Whether an edge separates the projections along coordinate axis k."""
    i, j = (k + 1) % 3, (k + 2) % 3
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        di, dj = triangle[b, i] - triangle[a, i], triangle[b, j] - triangle[a, j]
        if di == 0 and dj == 0:
            continue
        third = di * (triangle[c, j] - triangle[a, j]) - dj * (triangle[c, i] - triangle[a, i])
        p0, p1 = di * (lower[j] - triangle[a, j]), di * (upper[j] - triangle[a, j])
        q0, q1 = -dj * (lower[i] - triangle[a, i]), -dj * (upper[i] - triangle[a, i])
        if max(p0, p1) + max(q0, q1) <= min(0, third) or min(p0, p1) + min(q0, q1) >= max(0, third):
            return True
    return False


@kernel
def meets_box(
    triangle: NDArray[np.int64], lower: NDArray[np.int64], upper: NDArray[np.int64], normal: NDArray[np.int64]
) -> bool:
    """Whether a closed triangle meets the open box (lower, upper).

    Parameters
    ----------
    triangle
        (3, 3) grid coordinates, smaller than 2**24 in magnitude.
    lower, upper
        (3,) grid coordinates, lower < upper, same bound.
    normal
        (3,) room for the triangle's normal.

    Returns
    -------
    bool
        Exact; a triangle that only touches the boundary does not meet the interior. A degenerate triangle
        is taken for the segment or point that it is.

    Examples
    --------
    >>> t = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]])
    >>> room = np.empty(3, np.int64)
    >>> meets_box(t, np.array([0, 0, -1]), np.array([1, 1, 1]), room)
    True
    >>> meets_box(t, np.array([0, 0, 0]), np.array([1, 1, 1]), room)
    False
    """
    if _apart_by_bounds(triangle, lower, upper):
        return False
    face_normal(triangle, normal)
    if _apart_by_plane(triangle, normal, lower, upper):
        return False
    return not (
        _apart_by_edges(triangle, lower, upper, 0)
        or _apart_by_edges(triangle, lower, upper, 1)
        or _apart_by_edges(triangle, lower, upper, 2)
    )
