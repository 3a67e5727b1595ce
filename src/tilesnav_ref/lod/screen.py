"""Bounds of L between a prism and a triangle that need no search, to leave most faces of an object out.

Notes
-----
Four pairs of points give a lower bound: every corner and the centroid of the triangle with the nearest point
of the prism. The height of the prism over the plane and the distance of the box around it give an upper
bound: no point of the prism is nearer than the box. The best pair also points out a direction
for :func:`tilesnav_ref.lod.maximum.proven_bound`, which is then tight wherever the best pair is near the
optimum.
"""

from __future__ import annotations

import numpy as np

from tilesnav_ref.kernels import inner_kernel, kernel
from tilesnav_ref.lod.maximum import proven_bound
from tilesnav_ref.lod.prism import LOWER, UPPER, Vector, dot, extents, is_slanted, nearest_in_prism

_SAFETY = 1.0 + 2.0**-24
"""The height over the plane is a sum of three products with an error below 2**-50 of a coordinate difference,
which is less than 2**24 steps, while height and half extent of a box of two steps are together more than half
a step: 2**-25."""
_HEIGHT_ERROR = 2.0**-49
"""The same error, and that of the unit normal, as a share of the sum of the magnitudes of the products."""


@inner_kernel
def _best_pair(prism: Vector, triangle: Vector, normal: Vector, work: Vector) -> float:
    """Largest |n.r| / |r|^2 of the four pairs; work[0] receives its r."""
    value, best, r, slanted = 0.0, work[0], work[1], is_slanted(prism)
    for i in range(4):
        for k in range(3):
            x = triangle[i, k] if i < 3 else (triangle[0, k] + triangle[1, k] + triangle[2, k]) / 3.0
            work[2, k] = x
            r[k] = min(max(x, prism[LOWER, k]), prism[UPPER, k]) - x
        if slanted:
            nearest_in_prism(prism, work[2], r)
            r -= work[2]
        square = dot(r, r)
        if square > 0.0 and abs(dot(normal, r)) > value * square:
            value = abs(dot(normal, r)) / square
            best[0], best[1], best[2] = r[0], r[1], r[2]
    return float(value)


@inner_kernel
def _heights(prism: Vector, triangle: Vector, normal: Vector) -> tuple[float, float]:
    """Greatest heights of the prism over and under the plane of the triangle; negative where it is not."""
    over, under = extents(prism, triangle[0], normal)
    slack = (_SAFETY - 1.0) * max(over, under)
    if is_slanted(prism):
        # across a plane nearly along a slanted side, a prism can be far thinner than a step
        size = 0.0
        for k in range(3):
            low, high = prism[LOWER, k] - triangle[0, k], prism[UPPER, k] - triangle[0, k]
            size += abs(normal[k]) * max(abs(low), abs(high))
        slack += _HEIGHT_ERROR * size
    return over + slack, under + slack


@inner_kernel
def _gap_square(prism: Vector, triangle: Vector) -> float:
    """Square of the distance between the box around a prism and the bounds of a triangle, m2."""
    square = 0.0
    for k in range(3):
        low = min(triangle[0, k], triangle[1, k], triangle[2, k])
        high = max(triangle[0, k], triangle[1, k], triangle[2, k])
        square += max(low - prism[UPPER, k], prism[LOWER, k] - high, 0.0) ** 2
    return square


@kernel
def cheap_bounds(prism: Vector, triangle: Vector, normal: Vector, work: Vector) -> tuple[float, float]:
    """Lower and upper bound of the largest |n.r| / |r|^2.

    Parameters
    ----------
    prism
        (19, 3) array of :func:`tilesnav_ref.lod.prism.describe_prism`, m.
    triangle
        (3, 3) corners, m.
    normal
        (3,) unit normal, or zero for a degenerate triangle.
    work
        (3, 3) room to work in; a caller with many triangles makes it once.

    Returns
    -------
    least, most
        1/m. ``most`` is the greatest height over the plane by the square of the distance to the triangle's
        bounds, infinite where these touch.
    """
    least = _best_pair(prism, triangle, normal, work)
    square = _gap_square(prism, triangle)
    if square == 0.0:
        return least, np.inf
    over, under = _heights(prism, triangle, normal)
    return least, max(over, under) * _SAFETY / square


@kernel
def paired_bound(prism: Vector, triangle: Vector, normal: Vector, work: Vector) -> float:
    """Upper bound from the direction that the best of four pairs points out, 1/m; infinite: no proof.

    The side of the plane on which the best pair lies is bounded by that direction, the other side by height
    and distance.
    """
    value, r = _best_pair(prism, triangle, normal, work), work[0]
    if value == 0.0:
        return np.inf
    over, under = _heights(prism, triangle, normal)
    other = under
    side = normal.copy()
    if dot(normal, r) < 0.0:
        other = over
        for k in range(3):
            side[k] = -side[k]
    for k in range(3):
        r[k] -= side[k] * (0.5 / value)  # from the centre of the ball of this value to the pair's point
    bound = proven_bound(prism, triangle, side, r)
    if other <= 0.0:
        return float(bound)
    square = _gap_square(prism, triangle)
    return np.inf if square == 0.0 else max(bound, other * _SAFETY / square)
