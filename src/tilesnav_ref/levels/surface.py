"""The surface that edges are contracted in: faces, what is at a vertex, and borders."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NONE = -1


class Surface(NamedTuple):
    """Arrays that a contraction changes in place; corner k of face f has the number 3 f + k."""

    points: Floats
    """(V, 3) grid coordinates."""
    faces: Ints
    """(F, 3)."""
    alive: Any
    """(F,) bool."""
    heads: Ints
    """(V,) first corner at a vertex; those of faces that have gone stay in the list."""
    following: Ints
    """(3F,) next corner at the same vertex."""
    samples: Floats
    """(S, 3) points of the fine faces."""
    sample_fine: Ints
    """(S,) fine face that a sample is a point of."""
    sample_heads: Ints
    """(F,) first sample that a face stands for."""
    sample_following: Ints
    """(S,) next sample of the same face."""
    fine: Floats
    """(F, 3, 3) corners of the fine faces."""
    quadrics: Floats
    """(V, 10) sums of squared distances to planes: xx xy xz xd yy yz yd zz zd dd."""


@kernel
def ring(surface: Surface, vertex: int) -> Ints:
    """Faces at a vertex."""
    found = np.empty(32, np.int64)
    count = 0
    corner = surface.heads[vertex]
    while corner != NONE:
        face = corner // 3
        if surface.alive[face]:
            if count == len(found):
                longer = np.empty(2 * count, np.int64)
                longer[:count] = found
                found = longer
            found[count] = face
            count += 1
        corner = surface.following[corner]
    return found[:count]


@kernel
def has_corner(surface: Surface, face: int, vertex: int) -> bool:
    """Whether a vertex is a corner of a face."""
    corners = surface.faces[face]
    return bool(corners[0] == vertex or corners[1] == vertex or corners[2] == vertex)


@kernel
def keeps_border(surface: Surface, around: Ints, start: int, end: int) -> bool:
    """Whether the edge from start to end may be contracted onto end as far as borders go.

    A vertex on one border moves along it only, and one where several borders meet stays. `around` is the ring
    of start.
    """
    borders = 0
    along = False
    for face in around:
        for k in range(3):
            other = surface.faces[face, k]
            if other == start:
                continue
            sharing = 0
            for one in around:
                if has_corner(surface, one, other):
                    sharing += 1
            if sharing == 1:
                borders += 1
                along = along or other == end
    return borders == 0 or (borders == 2 and along)


@kernel
def join(surface: Surface, start: int, end: int) -> None:
    """Hand the corners of a vertex, and its planes, to another one."""
    corner = surface.heads[start]
    last = NONE
    while corner != NONE:
        surface.faces[corner // 3, corner % 3] = end
        last = corner
        corner = surface.following[corner]
    if last != NONE:
        surface.following[last] = surface.heads[end]
        surface.heads[end] = surface.heads[start]
        surface.heads[start] = NONE
    for k in range(10):
        surface.quadrics[end, k] += surface.quadrics[start, k]


@kernel
def cost(surface: Surface, start: int, end: int) -> float:
    """Sum of the squared distances of end to the planes that start stands for; of two equal ones the shorter
    edge comes first."""
    q = surface.quadrics[start]
    x, y, z = surface.points[end]
    total = q[0] * x * x + q[4] * y * y + q[7] * z * z + q[9]
    total += 2.0 * (q[1] * x * y + q[2] * x * z + q[3] * x + q[5] * y * z + q[6] * y + q[8] * z)
    length = 0.0
    for k in range(3):
        length += (surface.points[start, k] - surface.points[end, k]) ** 2
    # Far below any distance that counts: a millionth of the square of a step for an edge of 1000 steps.
    return float(max(total, 0.0) + 1e-12 * length)
