"""The point of a prism minus a triangle that is nearest to a given point.

Notes
-----
D = C - T is the set of differences p - x of points of a prism C over a trapezoid and a triangle T. The
nearest point of D to c belongs to the nearest pair between C and T moved by c. Of two disjoint convex bodies
the nearest pair lies on a vertex and a face or on two edges, so that all such pairs are looked at: three
vertices of T against C, eight of C against T, and 12 x 3 edges. The nearness is a matter of speed only: what
is concluded from it is proven elsewhere.

Two convex polytopes are disjoint exactly when a plane separates them that is parallel to a side of one of
them, or to an edge of each. C has up to four directions of sides and as many of edges, T one and three.

References
----------
C. Ericson, "Real-Time Collision Detection", 2005, sections 5.1.5 (point and triangle), 5.1.9 (two segments)
and 5.2.1 (separating axes).
"""

from __future__ import annotations

import numpy as np

from tilesnav_ref.kernels import kernel
from tilesnav_ref.lod.prism import (
    EDGES,
    LOWER,
    SIDES,
    UPPER,
    Vector,
    dot,
    extents,
    is_slanted,
    nearest_in_prism,
)


@kernel
def _keep_nearer(r: Vector, centre: Vector, nearest: Vector, square: float) -> float:
    """Replace nearest by r when r is nearer to the centre; returns the smaller square of the distance."""
    d = (r[0] - centre[0]) ** 2 + (r[1] - centre[1]) ** 2 + (r[2] - centre[2]) ** 2
    if d < square:
        nearest[0], nearest[1], nearest[2] = r[0], r[1], r[2]
        return float(d)
    return square


@kernel
def _triangle_weights(a: Vector, b: Vector, c: Vector, weights: Vector) -> None:
    """Barycentric weights of the point of a triangle that is nearest to the origin."""
    ab, ac = b - a, c - a
    d1, d2 = -dot(ab, a), -dot(ac, a)
    d3, d4 = -dot(ab, b), -dot(ac, b)
    d5, d6 = -dot(ab, c), -dot(ac, c)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    v, w = 0.0, 0.0
    if d1 <= 0 and d2 <= 0:
        pass
    elif d3 >= 0 and d4 <= d3:
        v = 1.0
    elif vc <= 0 and d1 >= 0 and d3 <= 0:
        v = d1 / (d1 - d3)
    elif d6 >= 0 and d5 <= d6:
        w = 1.0
    elif vb <= 0 and d2 >= 0 and d6 <= 0:
        w = d2 / (d2 - d6)
    elif va <= 0 and d4 >= d3 and d5 >= d6:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        v = 1.0 - w
    else:
        total = va + vb + vc
        v, w = vb / total, vc / total
    weights[0], weights[1], weights[2] = 1.0 - v - w, v, w


@kernel
def _segment_places(d1: Vector, d2: Vector, r: Vector) -> tuple[float, float]:
    """Parameters s, t in [0, 1] of the nearest points of the segments p + s d1 and q + t d2 with r = p -
    q."""
    a, e, f = dot(d1, d1), dot(d2, d2), dot(d2, r)
    c, b = dot(d1, r), dot(d1, d2)
    denominator = a * e - b * b
    s = min(max((b * f - c * e) / denominator, 0.0), 1.0) if denominator > 0 else 0.0
    t = (b * s + f) / e
    if t < 0.0:
        return min(max(-c / a, 0.0), 1.0), 0.0
    if t > 1.0:
        return min(max((b - c) / a, 0.0), 1.0), 1.0
    return s, t


@kernel
def _over_vertices(prism: Vector, triangle: Vector, centre: Vector, nearest: Vector, square: float) -> float:
    r, point, weights = np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        for k in range(3):
            point[k] = triangle[i, k] + centre[k]
        nearest_in_prism(prism, point, r)
        for k in range(3):
            r[k] -= triangle[i, k]
        square = _keep_nearer(r, centre, nearest, square)
    for i in range(8):
        corner = prism[i]
        moved = triangle + (centre - corner)
        _triangle_weights(moved[0], moved[1], moved[2], weights)
        for k in range(3):
            r[k] = corner[k] - (
                weights[0] * triangle[0, k] + weights[1] * triangle[1, k] + weights[2] * triangle[2, k]
            )
        square = _keep_nearer(r, centre, nearest, square)
    return square


@kernel
def _over_edges(prism: Vector, triangle: Vector, centre: Vector, nearest: Vector, square: float) -> float:
    r = np.empty(3)
    for i in range(3):
        edge = triangle[(i + 1) % 3] - triangle[i]
        for axis in range(3):
            for side in range(4):
                start = (side & 1) << ((axis + 1) % 3) | (side >> 1) << ((axis + 2) % 3)
                along = prism[start | (1 << axis)] - prism[start]
                if dot(along, along) == 0.0:
                    continue  # a trapezoid with a side of no length: both ends are a corner, looked at above
                base = prism[start] - triangle[i]
                s, t = _segment_places(along, edge, base - centre)
                for m in range(3):
                    r[m] = base[m] + s * along[m] - t * edge[m]
                square = _keep_nearer(r, centre, nearest, square)
    return square


@kernel
def nearest_difference(prism: Vector, triangle: Vector, centre: Vector, nearest: Vector) -> float:
    """Find the point of D = prism - triangle that is nearest to a centre outside of D.

    Parameters
    ----------
    prism
        (19, 3) array of :func:`tilesnav_ref.lod.prism.describe_prism`, m.
    triangle
        (3, 3) corners, m, not degenerate.
    centre
        (3,) m.
    nearest
        (3,) receives the point of D.

    Returns
    -------
    float
        Square of the distance, m2.
    """
    square = _over_vertices(prism, triangle, centre, nearest, np.inf)
    return float(_over_edges(prism, triangle, centre, nearest, square))


@kernel
def _apart_along(axis: Vector, prism: Vector, triangle: Vector, centre: Vector, middle: Vector) -> bool:
    """Whether the projections of the prism and of the moved triangle on an axis are disjoint."""
    low, high = np.inf, -np.inf
    for i in range(3):
        value = 0.0
        for k in range(3):
            value += axis[k] * (triangle[i, k] - middle[k] + centre[k])
        low, high = min(low, value), max(high, value)
    over, under = extents(prism, middle, axis)
    return bool(low > over or high < -under)


@kernel
def holds_difference(prism: Vector, triangle: Vector, normal: Vector, centre: Vector) -> bool:
    """Whether centre belongs to D = prism - triangle, up to rounding: no axis separates, of the thirteen of a
    box or the seventeen of a slanted prism."""
    middle = (prism[LOWER] + prism[UPPER]) * 0.5
    directions = 4 if is_slanted(prism) else 3
    for k in range(directions):
        if _apart_along(prism[SIDES + k], prism, triangle, centre, middle):
            return False
    if _apart_along(normal, prism, triangle, centre, middle):
        return False
    axis = np.empty(3)
    for i in range(3):
        edge = triangle[(i + 1) % 3] - triangle[i]
        for k in range(directions):
            along = prism[EDGES + k]
            axis[0] = along[1] * edge[2] - along[2] * edge[1]
            axis[1] = along[2] * edge[0] - along[0] * edge[2]
            axis[2] = along[0] * edge[1] - along[1] * edge[0]
            if _apart_along(axis, prism, triangle, centre, middle):
                return False
    return True
