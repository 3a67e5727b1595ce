"""Bounds of L between a box and a triangle that need no search, to leave most faces of an object out.

Notes
-----
Four pairs of points give a lower bound: every corner and the centroid of the triangle with the nearest point
of the box. Height over the plane and distance give an upper bound. The best pair also points out a direction
for :func:`tilesnav_ref.lod.maximum.proven_bound`, which is then tight wherever the best pair is near the
optimum.
"""

from __future__ import annotations

import numpy as np

from tilesnav_ref.kernels import kernel
from tilesnav_ref.lod.maximum import proven_bound
from tilesnav_ref.lod.nearest import Vector, dot

_SAFETY = 1.0 + 2.0**-24
"""The height over the plane is a sum of three products with an error below 2**-50 of a coordinate difference,
which is less than 2**24 steps, while height and half extent of a box of two steps are together more than half
a step: 2**-25."""


@kernel
def _best_pair(lower: Vector, upper: Vector, triangle: Vector, normal: Vector, best: Vector) -> float:
    """Largest |n.r| / |r|^2 of the four pairs; best (3,) receives its r."""
    value, r = 0.0, np.empty(3)
    for i in range(4):
        for k in range(3):
            x = triangle[i, k] if i < 3 else (triangle[0, k] + triangle[1, k] + triangle[2, k]) / 3.0
            r[k] = min(max(x, lower[k]), upper[k]) - x
        square = dot(r, r)
        if square > 0.0 and abs(dot(normal, r)) > value * square:
            value = abs(dot(normal, r)) / square
            best[0], best[1], best[2] = r[0], r[1], r[2]
    return float(value)


@kernel
def _heights(lower: Vector, upper: Vector, triangle: Vector, normal: Vector) -> tuple[float, float]:
    """Greatest heights of the box over and under the triangle's plane; negative on a side where it is not."""
    height, spread = 0.0, 0.0
    for k in range(3):
        height += normal[k] * (0.5 * (lower[k] + upper[k]) - triangle[0, k])
        spread += abs(normal[k]) * 0.5 * (upper[k] - lower[k])
    # enlarged by the error of the sums, see _SAFETY
    slack = (_SAFETY - 1.0) * (abs(height) + spread)
    return spread + height + slack, spread - height + slack


@kernel
def _gap_square(lower: Vector, upper: Vector, triangle: Vector) -> float:
    """Square of the distance between a box and the bounds of a triangle, m2."""
    square = 0.0
    for k in range(3):
        low = min(triangle[0, k], triangle[1, k], triangle[2, k])
        high = max(triangle[0, k], triangle[1, k], triangle[2, k])
        square += max(low - upper[k], lower[k] - high, 0.0) ** 2
    return square


@kernel
def cheap_bounds(lower: Vector, upper: Vector, triangle: Vector, normal: Vector) -> tuple[float, float]:
    """Lower and upper bound of the largest |n.r| / |r|^2.

    Parameters
    ----------
    lower, upper
        (3,) corners of the box, m.
    triangle
        (3, 3) corners, m.
    normal
        (3,) unit normal, or zero for a degenerate triangle.

    Returns
    -------
    least, most
        1/m. ``most`` is the greatest height over the plane by the square of the distance to the triangle's
        bounds, infinite where these touch.
    """
    least = _best_pair(lower, upper, triangle, normal, np.empty(3))
    square = _gap_square(lower, upper, triangle)
    if square == 0.0:
        return least, np.inf
    over, under = _heights(lower, upper, triangle, normal)
    return least, max(over, under) * _SAFETY / square


@kernel
def paired_bound(lower: Vector, upper: Vector, triangle: Vector, normal: Vector) -> float:
    """Upper bound from the direction that the best of four pairs points out, 1/m; infinite: no proof.

    The side of the plane on which the best pair lies is bounded by that direction, the other side by height
    and distance.
    """
    r = np.empty(3)
    value = _best_pair(lower, upper, triangle, normal, r)
    if value == 0.0:
        return np.inf
    over, under = _heights(lower, upper, triangle, normal)
    other = under
    side = normal.copy()
    if dot(normal, r) < 0.0:
        other = over
        for k in range(3):
            side[k] = -side[k]
    for k in range(3):
        r[k] -= side[k] * (0.5 / value)  # from the centre of the ball of this value to the pair's point
    bound = proven_bound(lower, upper, triangle, side, r)
    if other <= 0.0:
        return float(bound)
    square = _gap_square(lower, upper, triangle)
    return np.inf if square == 0.0 else max(bound, other * _SAFETY / square)
