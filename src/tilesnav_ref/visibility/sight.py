"""Exact tests of one segment against the scene: what it meets, and whether it sees its target."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import inner_kernel, kernel
from tilesnav_ref.visibility.exact import orientation
from tilesnav_ref.visibility.geometry import UNLIMITED

MISS = 0
"""The half-open segment [c, t) does not meet the face."""
CROSS = 1
"""The open segment crosses the relative interior of the face; neither end is in its plane."""
TOUCH = 2
"""Anything else: an end in the plane, an edge or a vertex met. Never used as proof of anything."""

STACK = 128
"""Depth of a traversal stack; a median-split hierarchy of 2**31 faces is 31 deep."""

CROSSED_LIMIT = 4096
"""Faces that one segment may meet; those that meet more prove nothing."""

# A slab test in float64 misplaces a plane by some ulps of 2**29, less than 1e-6 of a unit; boxes grown by one
# unit therefore never lose a face that the segment meets.
BOX_MARGIN = 1.0


@inner_kernel
def corner(corners, face, k):  # type: ignore[no-untyped-def]
    """Corner k of a face as a tuple."""
    return (corners[face, k, 0], corners[face, k, 1], corners[face, k, 2])


@inner_kernel
def meet(corners, face, c, t):  # type: ignore[no-untyped-def]
    """How the half-open segment [c, t) meets a face: MISS, CROSS or TOUCH, exact."""
    p, q, r = corner(corners, face, 0), corner(corners, face, 1), corner(corners, face, 2)
    from_c = orientation(p, q, r, c)
    from_t = orientation(p, q, r, t)
    if from_c * from_t > 0:
        return MISS
    if from_c != 0 and from_t == 0:
        return MISS  # the segment meets the plane in t only, and t is not part of it
    one = orientation(c, t, p, q)
    two = orientation(c, t, q, r)
    three = orientation(c, t, r, p)
    low = min(one, two, three)
    high = max(one, two, three)
    if low < 0 and high > 0:
        return MISS
    if from_c != 0 and from_t != 0 and (low > 0 or high < 0):
        return CROSS
    return TOUCH


@inner_kernel
def segment_meets_box(lower, upper, c, inverse):  # type: ignore[no-untyped-def]
    """Whether the segment from c with the given inverse direction can meet a box; never a false no."""
    enter, leave = 0.0, 1.0
    for k in range(3):
        low = lower[k] - BOX_MARGIN
        high = upper[k] + BOX_MARGIN
        if inverse[k] == 0.0:
            if c[k] < low or c[k] > high:
                return False
        else:
            a = (low - c[k]) * inverse[k]
            b = (high - c[k]) * inverse[k]
            enter = max(enter, min(a, b))
            leave = min(leave, max(a, b))
    return enter <= leave


@inner_kernel
def inverse_direction(c, t):  # type: ignore[no-untyped-def]
    """Componentwise 1 / (t - c), 0 where the component is 0."""
    x, y, z = t[0] - c[0], t[1] - c[1], t[2] - c[2]
    return (
        1.0 / x if x != 0.0 else 0.0,
        1.0 / y if y != 0.0 else 0.0,
        1.0 / z if z != 0.0 else 0.0,
    )


@kernel
def blocker(geometry, c, t, target):  # type: ignore[no-untyped-def]
    """Any opaque face other than `target` that [c, t) meets or may meet, or -1 when it surely meets none."""
    stack = np.empty(STACK, np.int32)
    inverse = inverse_direction(c, t)
    stack[0] = 0
    top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if not segment_meets_box(geometry.box_lower[node], geometry.box_upper[node], c, inverse):
            continue
        if geometry.box_child[node] >= 0:
            stack[top] = geometry.box_child[node]
            stack[top + 1] = geometry.box_child[node] + 1
            top += 2
            continue
        for k in range(geometry.box_first[node], geometry.box_first[node] + geometry.box_count[node]):
            face = geometry.face_order[k]
            if face == target or geometry.porous[face]:
                continue
            if meet(geometry.corners, face, c, t) != MISS:
                return face
    return -1


@inner_kernel
def counts(geometry, c, t, face):  # type: ignore[no-untyped-def]
    """Whether a segment is surely within the range and begins before the front of a face that is one-sided.

    Notes
    -----
    Coordinates are integers and differences below 2**30, so squares and their sum are exact in int64.
    """
    if geometry.near < UNLIMITED:
        x, y, z = np.int64(t[0] - c[0]), np.int64(t[1] - c[1]), np.int64(t[2] - c[2])
        if x * x + y * y + z * z > geometry.near * geometry.near:
            return False
    if not geometry.one_sided[face]:
        return True
    corners = geometry.corners
    return orientation(corner(corners, face, 0), corner(corners, face, 1), corner(corners, face, 2), c) > 0


@kernel
def sees(geometry, c, t, target):  # type: ignore[no-untyped-def]
    """Whether a segment surely proves `target` visible from c, if t lies in its relative interior."""
    return counts(geometry, c, t, target) and blocker(geometry, c, t, target) < 0


class Crossed(NamedTuple):
    """What a segment meets; working memory of a thread."""

    counts: NDArray[np.int64]
    """(4,) numbers of nearest, crossed and touched faces, and of those for which there was no room."""
    nearest: NDArray[np.int32]
    """Faces that the segment crosses, from its start on."""
    where: NDArray[np.float64]
    """Their places, 0 to 1."""
    faces: NDArray[np.int32]
    """All faces that it crosses, in no order."""
    touched: NDArray[np.int32]
    """Faces with which it is not in general position."""


def make_crossed(nearest: int) -> Crossed:
    """Room for so many nearest faces."""
    return Crossed(
        np.zeros(4, np.int64),
        np.zeros(nearest, np.int32),
        np.zeros(nearest),
        np.zeros(CROSSED_LIMIT, np.int32),
        np.zeros(CROSSED_LIMIT, np.int32),
    )


@kernel
def find_crossed(geometry, c, t, target, crossed):  # type: ignore[no-untyped-def]
    """Opaque faces but `target` that a segment crosses or touches; returns whether there was room for all."""
    stack = np.empty(STACK, np.int32)
    inverse = inverse_direction(c, t)
    crossed.counts[:] = 0
    stack[0] = 0
    top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if not segment_meets_box(geometry.box_lower[node], geometry.box_upper[node], c, inverse):
            continue
        if geometry.box_child[node] >= 0:
            stack[top] = geometry.box_child[node]
            stack[top + 1] = geometry.box_child[node] + 1
            top += 2
            continue
        for k in range(geometry.box_first[node], geometry.box_first[node] + geometry.box_count[node]):
            face = geometry.face_order[k]
            if face == target or geometry.porous[face]:
                continue
            how = meet(geometry.corners, face, c, t)
            if how == CROSS:
                _note(crossed, crossed.faces, 1, face)
                at = _parameter(geometry.corners, face, c, t)
                crossed.counts[0] = _insert(crossed.nearest, crossed.where, crossed.counts[0], face, at)
            elif how != MISS:
                _note(crossed, crossed.touched, 2, face)
    return crossed.counts[3] == 0


@inner_kernel
def _note(crossed, faces, which, face):  # type: ignore[no-untyped-def]
    if crossed.counts[which] < len(faces):
        faces[crossed.counts[which]] = face
        crossed.counts[which] += 1
    else:
        crossed.counts[3] += 1


@inner_kernel
def _insert(found, where, number, face, at):  # type: ignore[no-untyped-def]
    if number == len(found):
        if at >= where[number - 1]:
            return number
        number -= 1
    place = number
    while place > 0 and where[place - 1] > at:
        where[place] = where[place - 1]
        found[place] = found[place - 1]
        place -= 1
    where[place] = at
    found[place] = face
    return number + 1


@inner_kernel
def _parameter(corners, face, c, t):  # type: ignore[no-untyped-def]
    """Approximate place of a crossing, 0 at c and 1 at t; only an order of trial depends on it."""
    ux = corners[face, 1, 0] - corners[face, 0, 0]
    uy = corners[face, 1, 1] - corners[face, 0, 1]
    uz = corners[face, 1, 2] - corners[face, 0, 2]
    vx = corners[face, 2, 0] - corners[face, 0, 0]
    vy = corners[face, 2, 1] - corners[face, 0, 1]
    vz = corners[face, 2, 2] - corners[face, 0, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    hc = (
        nx * (c[0] - corners[face, 0, 0])
        + ny * (c[1] - corners[face, 0, 1])
        + nz * (c[2] - corners[face, 0, 2])
    )
    ht = (
        nx * (t[0] - corners[face, 0, 0])
        + ny * (t[1] - corners[face, 0, 1])
        + nz * (t[2] - corners[face, 0, 2])
    )
    return hc / (hc - ht) if hc != ht else 0.5
