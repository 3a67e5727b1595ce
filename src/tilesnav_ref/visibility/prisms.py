"""Prisms over trapezoids, boxes among them: cells, regions of proofs, and their parts.

Notes
-----
A prism is an array (8, 3) of integer-valued corners in fine units. Corner i is on the upper side of axis k
where bit k of i is set. There are axes u, v and w such that the coordinates u and w of a corner depend on
nothing but its side of that axis, and v on its sides of u and of v: the two sides across v may slant along u.
The prism is the open set between its six sides. Widths are at least two units everywhere, so that there is
an integer point inside for every integer u and w inside.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.visibility.exact import orientation

LEAST_CUT = 4.0
"""Units; a side of this length is cut into halves of two at least."""


def check_prisms(prisms: NDArray[np.int64]) -> None:
    """Raise ValueError where one of some arrays (N, 8, 3) of corners is no prism as above."""
    slants = np.zeros(len(prisms), np.int64)
    for axis in range(3):
        low = prisms[:, [i for i in range(8) if not i >> axis & 1]]
        high = prisms[:, [i for i in range(8) if i >> axis & 1]]
        flat = np.asarray((low[:, :, axis] >= high[:, :, axis]).any(axis=1))
        _refuse(flat, f"without a width along {'xyz'[axis]}")
        for other in range(3):
            if other != axis:
                slants += np.any(low[:, :, other] != high[:, :, other], axis=1)
    _refuse(slants > 1, "that slant in more than one way")


def _refuse(wrong: NDArray[np.bool_], what: str) -> None:
    if wrong.any():
        found = f"cell {int(np.argmax(wrong))} and {int(wrong.sum()) - 1} others {what}"
        raise ValueError(f"cells: found {found}; allowed: boxes and prisms over trapezoids")


def bounds_of(prisms: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 2, 3) boxes around prisms (N, 8, 3)."""
    return np.stack([prisms.min(axis=1), prisms.max(axis=1)], axis=1)


@kernel
def box_prism(box):  # type: ignore[no-untyped-def]
    """(8, 3) corners of a box (2, 3)."""
    corners = np.empty((8, 3))
    for i in range(8):
        for k in range(3):
            corners[i, k] = box[(i >> k) & 1, k]
    return corners


@kernel
def box_around(prism):  # type: ignore[no-untyped-def]
    """(2, 3) bounds of a prism."""
    box = np.empty((2, 3))
    for k in range(3):
        box[0, k], box[1, k] = prism[:, k].min(), prism[:, k].max()
    return box


@kernel
def slant(prism):  # type: ignore[no-untyped-def]
    """Axes (u, v) of a prism with slanted sides; (-1, -1) of a box."""
    for v in range(3):
        for u in range(3):
            low, high = 0, 1 << v
            if prism[low, v] != prism[low | 1 << u, v] and u != v:
                return u, v
            if prism[high, v] != prism[high | 1 << u, v] and u != v:
                return u, v
    return -1, -1


@kernel
def inner_range(prism, axes, at):  # type: ignore[no-untyped-def]
    """Least and greatest integers v strictly inside at integers u = `at` (one or an array); axes (u, v).

    Products are below 2**60, so the quotients are exact integers.
    """
    u, v = axes
    start, width = np.int64(prism[0, u]), np.int64(prism[7, u]) - np.int64(prism[0, u])
    a, b = np.int64(prism[0, v]), np.int64(prism[1 << u, v])
    c, d = np.int64(prism[1 << v, v]), np.int64(prism[1 << v | 1 << u, v])
    least = a + (b - a) * (at - start) // width + 1
    greatest = c - (c - d) * (at - start) // width - 1
    return least, greatest


@kernel
def holds(prism, point):  # type: ignore[no-untyped-def]
    """Whether an integer point is strictly inside."""
    u, v = slant(prism)
    for k in range(3):
        if k != v and (point[k] <= prism[0, k] or point[k] >= prism[7, k]):
            return False
    if v < 0:
        return True
    least, greatest = inner_range(prism, (u, v), np.int64(point[u]))
    return least <= point[v] <= greatest


@kernel
def clamp_inside(prism, point):  # type: ignore[no-untyped-def]
    """The integer point strictly inside a box that is nearest to an integer point; of a prism one that is
    near."""
    u, v = slant(prism)
    found = np.empty(3)
    for k in range(3):
        found[k] = min(max(point[k], prism[0, k] + 1.0), prism[7, k] - 1.0)
    if v >= 0:
        least, greatest = inner_range(prism, (u, v), np.int64(found[u]))
        found[v] = min(max(point[v], float(least)), float(greatest))
    return (found[0], found[1], found[2])


@kernel
def halve(prism, axis, below, above):  # type: ignore[no-untyped-def]
    """Cut a prism across an axis into prisms that are written to `below` and `above`; whether it could be.

    The cut runs through the middles of the four edges along the axis, rounded down along it. Where such an
    edge slants, rounding would leave the slanted side, so the middle has to be an integer point (spec,
    "Certificates").
    """
    below[:], above[:] = prism, prism
    bit = 1 << axis
    for i in range(8):
        if i & bit:
            continue
        j = i | bit
        if prism[j, axis] - prism[i, axis] < LEAST_CUT:
            return False
        slants = odd = False
        for k in range(3):
            slants = slants or (k != axis and prism[i, k] != prism[j, k])
            differs = k == axis or prism[i, k] != prism[j, k]
            odd = odd or (differs and np.int64(prism[i, k] + prism[j, k]) & 1 == 1)
            below[j, k] = above[i, k] = np.floor((prism[i, k] + prism[j, k]) / 2)
        if slants and odd:
            return False
    return True


@kernel
def edge_length(prism, axis):  # type: ignore[no-untyped-def]
    """Greatest extent along an axis of the edges that lead along it."""
    longest = 0.0
    for i in range(8):
        if not i >> axis & 1:
            longest = max(longest, prism[i | 1 << axis, axis] - prism[i, axis])
    return longest


@kernel
def plane_side(p, q, r, prism):  # type: ignore[no-untyped-def]
    """Side of the plane p, q, r on which a prism lies, exact; 0 where the plane cuts it."""
    least, most = 1, -1
    for i in range(8):
        side = orientation(p, q, r, (prism[i, 0], prism[i, 1], prism[i, 2]))
        least, most = min(least, side), max(most, side)
        if least < 0 and most > 0:
            return 0
    return most if least >= 0 else least


@kernel
def beyond_slants(prism, triangle):  # type: ignore[no-untyped-def]
    """Whether a triangle (3, 3) lies outside of a slanted side, or in it; exact, as in `inner_range`."""
    u, v = slant(prism)
    if v < 0:
        return False
    start, width = np.int64(prism[0, u]), np.int64(prism[7, u]) - np.int64(prism[0, u])
    for side in range(2):
        first = np.int64(prism[side << v, v])
        rise = np.int64(prism[side << v | 1 << u, v]) - first
        most = 0
        for i in range(3):
            height = (np.int64(triangle[i, v]) - first) * width - rise * (np.int64(triangle[i, u]) - start)
            most = max(most, int(height if side == 0 else -height))
        if most == 0:
            return True
    return False
