"""A cell as the kernels see it: the eight corners of a prism over a trapezoid, and what follows from them.

Notes
-----
A prism is one array of 19 rows, so that a kernel hands over one argument:

- rows 0 to 7: corners, m; corner i is on the upper side of axis k where bit k of i is set;
- LOWER and UPPER: corners of the box around the prism, m;
- SHAPE: 1 where two sides slant, else 0, then the axes u and v: the sides across v slant along u;
- SIDES and the rows behind it: directions normal to the sides, three of a box and four of a slanted prism;
- EDGES and the rows behind it: directions of the edges, as many.

The directions have any length. Those of corners on the grid are exact, and so are their products with
differences of grid points: 24 bits times 24 bits.

What is proven rests on the corners alone: the least and the greatest value of a linear function are taken
over all eight of them, or, where SHAPE says box, component by component. The shape and the directions only
help to find good candidates.

References
----------
C. Ericson, "Real-Time Collision Detection", 2005, sections 5.1.2 (point and segment) and 5.1.3 (point and
box).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import inner_kernel, kernel

Vector = NDArray[np.float64]

LOWER = 8
UPPER = 9
SHAPE = 10
SIDES = 11
EDGES = 15
_ROWS = 19


@kernel
def dot(a: Vector, b: Vector) -> float:
    """Inner product of two (3,) vectors."""
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@inner_kernel
def is_slanted(prism: Vector) -> bool:
    """Whether the prism is not a box."""
    return bool(prism[SHAPE, 0] > 0.0)


@kernel
def _follow_slant(prism: Vector, axis: int, along: int) -> None:
    """Shape, side normals and edges of a prism whose sides across an axis slant along another."""
    prism[SHAPE, 0], prism[SHAPE, 1], prism[SHAPE, 2] = 1.0, along, axis
    for side in range(2):
        start = side << axis
        edge = prism[start | (1 << along)] - prism[start]
        # the row of the axis itself is the normal of no side, and the row of `along` the direction of no edge
        normal = SIDES + (axis if side == 0 else 3)
        prism[normal] = 0.0
        prism[normal, along], prism[normal, axis] = -edge[axis], edge[along]
        prism[EDGES + (along if side == 0 else 3)] = edge


@kernel
def describe_prism(corners: NDArray[np.generic], step: float) -> Vector:
    """Array of a prism.

    Parameters
    ----------
    corners
        (8, 3) int64 grid coordinates or float64; corner i is on the upper side of axis k where bit k of i is
        set.
    step
        What one unit of them is in metres.

    Returns
    -------
    ndarray
        (19, 3) float64, see the notes of this module.
    """
    prism = np.zeros((_ROWS, 3))
    for k in range(3):
        for i in range(8):
            prism[i, k] = corners[i, k] * step
        prism[LOWER, k] = np.min(prism[:8, k])
        prism[UPPER, k] = np.max(prism[:8, k])
        prism[SIDES + k, k] = prism[EDGES + k, k] = 1.0
    for k in range(3):
        for i in range(8):
            side = prism[UPPER if (i >> k) & 1 else LOWER, k]
            if prism[i, k] != side:
                across = 1 << ((k + 1) % 3)
                # the coordinate changes along that axis, or it must change along the other one
                changes = prism[0, k] != prism[across, k] or prism[1 << k, k] != prism[across | 1 << k, k]
                _follow_slant(prism, k, (k + 1) % 3 if changes else (k + 2) % 3)
                break
    return prism


@kernel
def moved_prism(prism: Vector, origin: Vector) -> Vector:
    """The prism in a frame with another origin (3,), m."""
    result = prism.copy()
    for i in range(UPPER + 1):
        for k in range(3):
            result[i, k] -= origin[k]
    return result


@inner_kernel
def extents(prism: Vector, origin: Vector, axis: Vector) -> tuple[float, float]:
    """Greatest values of axis.(p - origin) and of its negative over the prism, but for rounding."""
    if is_slanted(prism):
        over, under = -np.inf, -np.inf
        for i in range(8):
            value = 0.0
            for k in range(3):
                value += axis[k] * (prism[i, k] - origin[k])
            over, under = max(over, value), max(under, -value)
        return over, under
    height, spread = 0.0, 0.0
    for k in range(3):
        height += axis[k] * (0.5 * (prism[LOWER, k] + prism[UPPER, k]) - origin[k])
        spread += abs(axis[k]) * 0.5 * (prism[UPPER, k] - prism[LOWER, k])
    return spread + height, spread - height


@inner_kernel
def least_product(prism: Vector, axis: Vector) -> float:
    """Least axis.p over the prism; each product and sum is rounded."""
    least = 0.0
    if is_slanted(prism):
        least = np.inf
        for i in range(8):
            least = min(least, axis[0] * prism[i, 0] + axis[1] * prism[i, 1] + axis[2] * prism[i, 2])
        return float(least)
    for k in range(3):
        least += axis[k] * (prism[LOWER, k] if axis[k] > 0 else prism[UPPER, k])
    return float(least)


@kernel
def _is_in_base(prism: Vector, point: Vector, u: int, v: int) -> bool:
    """Whether a point whose coordinate u is within the prism lies between the slanted sides."""
    for side in range(2):
        a = side << v
        b = a | (1 << u)
        width = prism[b, u] - prism[a, u]
        out = (point[v] - prism[a, v]) * width - (point[u] - prism[a, u]) * (prism[b, v] - prism[a, v])
        if (out if side else -out) > 0.0:
            return False
    return True


@kernel
def _nearest_on_edges(prism: Vector, point: Vector, nearest: Vector) -> None:
    """Move coordinates u and v of nearest (3,) to the nearest place on the edges of the trapezoid, unless the
    point is over it."""
    u, v = int(prism[SHAPE, 1]), int(prism[SHAPE, 2])
    if nearest[u] == point[u] and _is_in_base(prism, point, u, v):
        return
    least = np.inf
    for edge in range(4):
        # two edges along u, at the sides of v, and two along v
        a = ((edge & 1) << v) if edge < 2 else ((edge & 1) << u)
        b = a | (1 << (u if edge < 2 else v))
        du, dv = prism[b, u] - prism[a, u], prism[b, v] - prism[a, v]
        square = du * du + dv * dv
        place = (point[u] - prism[a, u]) * du + (point[v] - prism[a, v]) * dv
        place = min(max(place / square, 0.0), 1.0) if square > 0.0 else 0.0
        pu, pv = prism[a, u] + place * du, prism[a, v] + place * dv
        away = (pu - point[u]) ** 2 + (pv - point[v]) ** 2
        if away < least:
            least = away
            nearest[u], nearest[v] = pu, pv


@inner_kernel
def nearest_in_prism(prism: Vector, point: Vector, nearest: Vector) -> None:
    """Write the point of the prism nearest to a point (3,) to nearest (3,)."""
    for k in range(3):
        nearest[k] = min(max(point[k], prism[LOWER, k]), prism[UPPER, k])
    if is_slanted(prism):
        _nearest_on_edges(prism, point, nearest)
