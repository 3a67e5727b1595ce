"""Segments of trial from a cell part to a face part: random ones, and the extreme ones.

What is seen through a small opening is seen from the rim: the last that a building covers of a tower is its
top, seen from the top of the cell. So the segments that join the corners of a cell part to the corners of a
face part, each moved inwards as little as the coordinates allow, find what random ones hardly ever find.
"""

from __future__ import annotations

import numpy as np

from tilesnav_ref.kernels import kernel
from tilesnav_ref.visibility.geometry import UNLIMITED
from tilesnav_ref.visibility.prisms import clamp_inside, inner_range, slant
from tilesnav_ref.visibility.sight import sees

RANDOM_MODULUS = 2**31 - 1


@kernel
def next_random(state, bound):  # type: ignore[no-untyped-def]
    """Next integer in [0, bound), bound below 2**31 (the minimal standard of Park and Miller).

    Points of trial need no better generator, and its products fit int64 without wrapping.

    References
    ----------
    S. K. Park, K. W. Miller, P. K. Stockmeyer, Response, Communications of the ACM 36 (1993).
    """
    state[0] = state[0] * 48271 % RANDOM_MODULUS
    return state[0] % bound


@kernel
def inner_point(state, prism):  # type: ignore[no-untyped-def]
    """A random point with integer coordinates strictly inside a prism of at least 2 units a side."""
    u, v = slant(prism)
    found = np.empty(3)
    for k in range(3):
        if k != v:
            found[k] = prism[0, k] + 1 + next_random(state, np.int64(prism[7, k] - prism[0, k]) - 1)
    if v >= 0:
        least, greatest = inner_range(prism, (u, v), np.int64(found[u]))
        found[v] = least + next_random(state, greatest - least + 1)
    return (found[0], found[1], found[2])


@kernel
def trailing_zeros(part):  # type: ignore[no-untyped-def]
    """How often all coordinates of a triangle can be halved exactly, at most 16."""
    bits = np.int64(1) << 16
    for k in range(3):
        for j in range(3):
            bits |= np.int64(part[k, j])
    count = 0
    while (bits >> count) & 1 == 0:
        count += 1
    return count


@kernel
def weighted_point(part, weights, whole):  # type: ignore[no-untyped-def]
    """Point of a triangle with integer weights of sum `whole`, a power of two that divides the corners."""
    one, two, three = weights
    return (
        (one * part[0, 0] + two * part[1, 0] + three * part[2, 0]) / whole,
        (one * part[0, 1] + two * part[1, 1] + three * part[2, 1]) / whole,
        (one * part[0, 2] + two * part[1, 2] + three * part[2, 2]) / whole,
    )


@kernel
def inner_point_of_face(state, part):  # type: ignore[no-untyped-def]
    """A random point in the relative interior of a triangle whose coordinates are multiples of 4; exact."""
    whole = np.int64(1) << trailing_zeros(part)
    one = 1 + next_random(state, whole - 2)
    two = 1 + next_random(state, whole - one - 1)
    return weighted_point(part, (one, two, whole - one - two), whole)


@kernel
def nearest_inner_point(part, u, v):  # type: ignore[no-untyped-def]
    """A point in the relative interior of a triangle near that of barycentric weights u, v of corners 1, 2.

    Its weights are multiples of a power of two, so that it has integer coordinates and is exactly on the
    triangle, whose coordinates are multiples of 4.
    """
    whole = np.int64(1) << trailing_zeros(part)
    one = min(max(np.int64(np.round(u * whole)), 1), whole - 2)
    two = min(max(np.int64(np.round(v * whole)), 1), whole - one - 1)
    return weighted_point(part, (whole - one - two, one, two), whole)


@kernel
def within_reach(geometry, prism, t):  # type: ignore[no-untyped-def]
    """The part of a box in the cube about t that holds the range; all of it where that is too thin, or where
    the prism is no box."""
    if geometry.near >= UNLIMITED or slant(prism)[1] >= 0:
        return prism
    found = prism.copy()
    for k in range(3):
        low, high = max(prism[0, k], t[k] - geometry.near), min(prism[7, k], t[k] + geometry.near)
        if high - low < 2.0:
            return prism
        for i in range(8):
            found[i, k] = high if (i >> k) & 1 else low
    return found


@kernel
def _nearest_sees(geometry, prism, t, face):  # type: ignore[no-untyped-def]
    """Whether an inner point of a prism that is near to t sees the face, where there is a range."""
    return geometry.near < UNLIMITED and sees(geometry, clamp_inside(prism, t), t, face)


@kernel
def extremes_see(geometry, prism, part, face):  # type: ignore[no-untyped-def]
    """Whether a segment from near a corner of a prism to near a corner of a part of a face sees it."""
    whole = np.int64(1) << trailing_zeros(part)
    for k in range(3):
        one, two = whole - 2 if k == 0 else 1, whole - 2 if k == 1 else 1
        t = weighted_point(part, (one, two, whole - one - two), whole)
        if _nearest_sees(geometry, prism, t, face):
            return True
        for i in range(8):
            c = clamp_inside(prism, (prism[i, 0], prism[i, 1], prism[i, 2]))
            if sees(geometry, c, t, face):
                return True
    return False


@kernel
def trial(geometry, state, prism, part):  # type: ignore[no-untyped-def]
    """A random segment (c, t) of a pair (cell part, face part); one within the range if possible."""
    if geometry.near >= UNLIMITED:
        return inner_point(state, prism), inner_point_of_face(state, part)
    t = inner_point_of_face(state, part)
    return inner_point(state, within_reach(geometry, prism, t)), t


@kernel
def search(geometry, state, pair, what):  # type: ignore[no-untyped-def]
    """Whether one of some segments of a pair (cell part, face part) sees the face; what: (face, number)."""
    prism, part = pair
    face, number = what
    if number > 0 and extremes_see(geometry, prism, part, face):
        return True
    for _ in range(number):
        c, t = trial(geometry, state, prism, part)
        if sees(geometry, c, t, face):
            return True
    return False
