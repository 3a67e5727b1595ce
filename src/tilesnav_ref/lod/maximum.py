"""The largest L = |n.r| / |r|^2 between a prism and a triangle, with a proof of its upper bound.

Notes
-----
Let D = C - T be the differences r = p - x of points of the prism C over a trapezoid (a box, for one) and
the triangle T with unit normal n. On the side n.r > 0 the value 1 / L = |r|^2 / (n.r) is a convex function (a
square over a linear function), and "1 / L <= m" is the ball with centre c = m n / 2 and radius m / 2, which
touches T's plane at the origin and lies on that side. Hence a prism that straddles the plane needs no
cutting: both sides are taken with the whole of D.

*Search.* Minimising |r|^2 / (n.r) by Dinkelbach's method: from the value m of some r, take the point of D
nearest to c(m), and its value as the next m. The values fall superlinearly to the minimum.

*Proof.* For any u and the support s(u) = min over D of u.r, every r of D has u.r >= s, while every point of
the ball of m has u.r <= m (|u| + u.n) / 2. So no r of D is in the ball when m < 2 s / (|u| + u.n), and

    L <= (|u| + u.n) / (2 s(u))    whenever s(u) > 0.

The support is a minimum over the 8 corners of C and a maximum over the 3 of T, whatever the search did. With
u = q - c at the optimum q the bound is tight. The returned value is such a bound, enlarged by the rounding of
its terms, hence never below the true maximum; if the search failed, it would be too large, never too small.

Contact (0 in D) gives infinity: D has interior, so that r can go to 0 along a direction that leaves T's
plane.

References
----------
W. Dinkelbach, "On nonlinear fractional programming", Management Science 13(7), 1967.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.lod.nearest import holds_difference, nearest_difference
from tilesnav_ref.lod.prism import (
    LOWER,
    UPPER,
    Vector,
    describe_prism,
    dot,
    extents,
    least_product,
    moved_prism,
)

TOLERANCE = 1e-9
"""The search ends when bound and value agree to this relative distance: far below one level of any base,
and above the rounding of the support, about 1e-15 times the ratio of the extent of D to s."""
_ROUNDS = 64
"""Dinkelbach's method takes about five rounds; this is where a search that rounding stalls gives up."""
_ROUNDING = 32 * 2.0**-53
"""A sum of six products of float64, with operands rounded once, is exact to less than this times the sum of
magnitudes."""


@kernel
def unit_normal(triangle: Vector, normal: Vector) -> None:
    """Unit normal of a (3, 3) triangle, written to normal; zero for a degenerate triangle.

    Differences of grid coordinates times a power of two have at most 24 bits, so the cross product before
    its division by the length is exact.
    """
    a, b = triangle[1] - triangle[0], triangle[2] - triangle[0]
    normal[0] = a[1] * b[2] - a[2] * b[1]
    normal[1] = a[2] * b[0] - a[0] * b[2]
    normal[2] = a[0] * b[1] - a[1] * b[0]
    length = np.sqrt(dot(normal, normal))
    if length > 0.0:
        normal /= length


@kernel
def _best_vertex(prism: Vector, triangle: Vector, normal: Vector, r: Vector) -> float:
    """Smallest |r|^2 / (n.r) over the 24 differences of corners with n.r > 0; infinity where there is
    none."""
    best = np.inf
    for i in range(24):
        for k in range(3):
            r[k] = prism[i & 7, k] - triangle[i >> 3, k]
        height = dot(normal, r)
        if height > 0.0:
            best = min(best, dot(r, r) / height)
    return best


@kernel
def proven_support(prism: Vector, triangle: Vector, u: Vector) -> float:
    """Lower bound of u.r over all r = p - x of a prism and a triangle, rounding included."""
    near, size = least_product(prism, u), 0.0
    for k in range(3):
        # of all corners the box around them has the greatest magnitudes
        size += abs(u[k]) * max(abs(prism[LOWER, k]), abs(prism[UPPER, k]))
    far, extent = -np.inf, 0.0
    for i in range(3):
        far = max(far, dot(u, triangle[i]))
        extent = max(
            extent, abs(u[0] * triangle[i, 0]) + abs(u[1] * triangle[i, 1]) + abs(u[2] * triangle[i, 2])
        )
    return float(near - far - _ROUNDING * (size + extent))


@kernel
def proven_bound(prism: Vector, triangle: Vector, normal: Vector, u: Vector) -> float:
    """Upper bound of n.r / |r|^2 over D from a direction u (not zero); infinity where it proves nothing.

    Parameters
    ----------
    prism
        (19, 3) array of :func:`tilesnav_ref.lod.prism.describe_prism`, m.
    triangle
        (3, 3) corners, m.
    normal, u
        (3,) unit normal, and a direction of any length.

    Returns
    -------
    float
        1/m; at least the true maximum on the side of the normal, rounding included.
    """
    support = proven_support(prism, triangle, u)
    if support <= 0.0:
        return np.inf
    length, along = np.sqrt(dot(u, u)), dot(u, normal)
    width = length + along
    if along < 0.0:
        # length + along cancels; (length^2 - along^2) is the square of the cross product
        x, y, z = (
            u[1] * normal[2] - u[2] * normal[1],
            u[2] * normal[0] - u[0] * normal[2],
            u[0] * normal[1] - u[1] * normal[0],
        )
        error = _ROUNDING * length
        width = ((abs(x) + error) ** 2 + (abs(y) + error) ** 2 + (abs(z) + error) ** 2) / (length - along)
    return float(width * (1.0 + _ROUNDING) / (2.0 * support))


@kernel
def side_maximum(prism: Vector, triangle: Vector, normal: Vector) -> float:
    """Bound of the largest n.r / |r|^2 over D on the side of the normal; 0 where D has no point there.

    The prism must not touch the triangle (the result is infinite then, after a slow search). Coordinates
    should be relative to a point near by, because the rounding allowance grows with them.
    """
    centre, nearest = np.empty(3), np.empty(3)
    inverse = _best_vertex(prism, triangle, normal, nearest)
    if inverse == np.inf:
        return 0.0
    bound = np.inf
    for _ in range(_ROUNDS):
        for k in range(3):
            centre[k] = 0.5 * inverse * normal[k]
        if holds_difference(prism, triangle, normal, centre):
            inverse *= 0.5  # the centre itself is in D, and its value is half of the diameter
            continue
        nearest_difference(prism, triangle, centre, nearest)
        height = dot(normal, nearest)
        if height > 0.0:
            inverse = min(inverse, dot(nearest, nearest) / height)
        for k in range(3):
            centre[k] = nearest[k] - centre[k]
        bound = min(bound, proven_bound(prism, triangle, normal, centre))
        if bound * inverse <= 1.0 + TOLERANCE:
            break
    return bound


@kernel
def _plain_bounds(prism: Vector, triangle: Vector, normal: Vector) -> tuple[float, float]:
    """Greatest height over the plane (triangle[0] at the origin) by the square of the distance, on both
    sides."""
    origin, u = np.zeros(3), np.empty(3)
    over, under = extents(prism, origin, normal)
    slack = _ROUNDING * np.sum(np.abs(prism[LOWER]) + np.abs(prism[UPPER]))
    nearest_difference(prism, triangle, origin, u)
    support = proven_support(prism, triangle, u)
    if support <= 0.0:
        return np.inf, np.inf
    scale = dot(u, u) * (1.0 + _ROUNDING) / (support * support)
    return max(over + slack, 0.0) * scale, max(under + slack, 0.0) * scale


@kernel
def prism_maximum(prism: Vector, triangle: Vector) -> float:
    """Upper bound of :func:`region_maximum`, from the (19, 3) array of a prism."""
    origin = triangle[0].copy()
    near, local = moved_prism(prism, origin), triangle - origin
    normal = np.empty(3)
    unit_normal(local, normal)
    if dot(normal, normal) == 0.0:
        return 0.0
    if holds_difference(near, local, normal, np.zeros(3)):
        return np.inf
    above, below = _plain_bounds(near, local, normal)
    if below > above:
        normal = -normal
        above, below = below, above
    best = min(above, side_maximum(near, local, normal))
    if below <= best:
        return float(best)
    return float(max(best, min(below, side_maximum(near, local, -normal))))


@kernel
def region_maximum(corners: Vector, triangle: Vector) -> float:
    """Upper bound of the largest |n.r| / |r|^2 over a prism and a triangle.

    Parameters
    ----------
    corners
        (8, 3) float64 corners of a prism over a trapezoid, m; corner i is on the upper side of axis k where
        bit k of i is set. Of any other eight corners the bound holds for their convex hull, but may be far.
    triangle
        (3, 3) float64 corners, m, in the frame of the prism.

    Returns
    -------
    float
        1/m. Never below the maximum, and above it by a relative 1e-9 where rounding allows (1e-6 is what
        callers may rely on for prisms and triangles on the grid). Infinite on contact, 0 for a degenerate
        triangle.

    Examples
    --------
    >>> t = np.array([[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0]])
    >>> box = np.array([[float((i >> k) & 1) for k in range(3)] for i in range(8)]) + [0.0, 0.0, 2.0]
    >>> round(region_maximum(box, t), 6)
    0.5
    """
    return float(prism_maximum(describe_prism(corners, 1.0), triangle))


def _check_prism(corners: NDArray[np.float64]) -> None:
    """Refuse corners that are not those of a prism over a trapezoid: ValueError."""
    slants = 0
    for k in range(3):
        # bit k of the number of a corner is axis 2 - k of this array; first its side of axis k
        sides = np.moveaxis(corners[:, k].reshape(2, 2, 2), 2 - k, 0)
        widths = sides[1] - sides[0]
        if not (np.all(widths >= 0.0) and np.any(widths > 0.0)):
            raise ValueError(
                f"corners on the upper side of axis {k} less those on the lower side are"
                f" {widths.ravel().tolist()} m; allowed: none negative, one at least positive"
            )
        slants += sum(bool(np.any(np.diff(sides, axis=other) != 0.0)) for other in (1, 2))
    if slants > 1:
        raise ValueError(
            f"coordinates of the corners change along {slants} foreign axes; allowed: 1, a prism over a"
            " trapezoid, or 0, a box"
        )


def largest_level(corners: NDArray[np.float64], triangle: NDArray[np.float64]) -> float:
    """Checked form of :func:`region_maximum` for single calls.

    Raises
    ------
    ValueError
        Wrong shapes, not finite, or corners that are not those of a prism over a trapezoid.
    """
    shapes = (np.shape(corners), np.shape(triangle))
    if shapes != ((8, 3), (3, 3)):
        raise ValueError(f"shapes are {shapes}; allowed: (8, 3), (3, 3)")
    cell, face = (np.ascontiguousarray(value, dtype=np.float64) for value in (corners, triangle))
    if not (np.all(np.isfinite(cell)) and np.all(np.isfinite(face))):
        raise ValueError("prism or triangle is not finite; allowed: finite metres")
    _check_prism(cell)
    return float(region_maximum(cell, face))
