"""Triangles cut to boxes as polygons in floating point: what guesses of good cuts start from.

References
----------
I. E. Sutherland, G. W. Hodgman, "Reentrant polygon clipping", Communications of the ACM 17(1), 1974.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel

VERTICES = 9
"""Most vertices of a triangle that six planes cut."""
TOUCH = 1e-6
"""Grid steps by which a polygon may reach over a plane and still only touches it: cut vertices are off by
2**-28 steps, and no harm comes from a wrong guess."""


@kernel
def cut_polygon(
    polygon: NDArray[np.float64],
    count: int,
    plane: tuple[int, float, float],
    result: NDArray[np.float64],
) -> int:
    """Write the part of a convex polygon on the side of sign * x[axis] <= sign * place; returns its vertices.

    ``plane`` is axis, place and sign. A part that only touches the plane counts as none.
    """
    axis, place, sign = plane
    inside = False
    for a in range(count):
        inside = inside or sign * (place - polygon[a, axis]) > TOUCH
    if not inside:
        return 0
    kept = 0
    for a in range(count):
        b = a + 1 if a + 1 < count else 0
        one, two = sign * (place - polygon[a, axis]), sign * (place - polygon[b, axis])
        if one >= 0.0:
            result[kept] = polygon[a]
            kept += 1
        if (one > 0.0 > two) or (one < 0.0 < two):
            share = one / (one - two)
            for k in range(3):
                result[kept, k] = polygon[a, k] + share * (polygon[b, k] - polygon[a, k])
            result[kept, axis] = place
            kept += 1
        if kept >= VERTICES:
            break
    return kept


@kernel
def cut_to_box(
    polygons: tuple[NDArray[np.float64], NDArray[np.int64]],
    span: tuple[int, int],
    box: NDArray[np.float64],
    room: NDArray[np.float64],
) -> int:
    """Write the parts of polygons span[0]:span[1] in a box (2, 3) behind them; returns the new end.

    Parameters
    ----------
    polygons
        (P, 9, 3) vertices and (P,) their numbers, with room for twice the span.
    room
        (2, 10, 3), written to.
    """
    vertices, counts = polygons
    end = span[1]
    for s in range(span[0], span[1]):
        count, turn = counts[s], 0
        room[0, :VERTICES] = vertices[s]
        for k in range(3):
            for side in range(2):
                place, sign, cuts = box[side, k], 2.0 * side - 1.0, False
                for a in range(count):
                    cuts = cuts or sign * (place - room[turn, a, k]) <= TOUCH
                if cuts:
                    count = cut_polygon(room[turn], count, (k, place, sign), room[1 - turn])
                    turn = 1 - turn
        if count > 0:
            vertices[end], counts[end] = room[turn, :VERTICES], count
            end += 1
    return end
