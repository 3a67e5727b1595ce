"""The first corner of a face, and the order of faces in space.

References
----------
G. M. Morton, A computer oriented geodetic data base, 1966 (interleaved bits keep neighbours near each other).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel, plain_inner_kernel, plain_kernel
from tilesnav_ref.packet.geometry_mesh import LIMIT

CURVE_BITS = 21
"""Bits of each coordinate on the curve; the lowest three of the 24 on the grid are left out."""


@plain_kernel
def less(corners: Any, face: Any, turn: Any, other: Any) -> Any:
    """Whether one rotation of a face, by `turn` corners, is less than another one."""
    for k in range(9):
        corner, axis = k // 3, k % 3
        one = corners[face, (corner + turn) % 3, axis]
        two = corners[face, (corner + other) % 3, axis]
        if one != two:
            return one < two
    return False


@plain_kernel
def turn_faces(corners: Any) -> Any:
    """Turn each of (F, 3, 3) faces, in place, so that it starts with the least of its rotations."""
    for i in range(len(corners)):
        best = 0
        for turn in (1, 2):
            if less(corners, i, turn, best):
                best = turn
        if best == 0:
            continue
        for axis in range(3):
            a, b, c = corners[i, 0, axis], corners[i, 1, axis], corners[i, 2, axis]
            corners[i, 0, axis] = b if best == 1 else c
            corners[i, 1, axis] = c if best == 1 else a
            corners[i, 2, axis] = a if best == 1 else b


@plain_kernel
def find_turned(corners: Any, turned: Any) -> Any:
    """Fill (F,) bool: whether each of (F, 3, 3) faces starts with the least of its rotations."""
    for i in range(len(corners)):
        turned[i] = not (less(corners, i, 1, 0) or less(corners, i, 2, 0))


@plain_kernel
def first_beyond(corners: Any) -> Any:
    """Return the first of (F, 3, 3) faces with a coordinate that is beyond the grid, or F."""
    for i in range(len(corners)):
        for k in range(9):
            value = corners[i, k // 3, k % 3]
            if value <= -LIMIT or value >= LIMIT:
                return i
    return len(corners)


@plain_inner_kernel
def spread(x: Any) -> Any:
    """21 bits, each three places from the next."""
    x = (x | x << 32) & 0x1F00000000FFFF
    x = (x | x << 16) & 0x1F0000FF0000FF
    x = (x | x << 8) & 0x100F00F00F00F00F
    x = (x | x << 4) & 0x10C30C30C30C30C3
    return (x | x << 2) & 0x1249249249249249


@plain_kernel
def curve_places(corners: Any, places: Any) -> Any:
    """Place on the curve, (F,) int64, of the middle of each of (F, 3, 3) faces."""
    for i in range(len(corners)):
        place = np.int64(0)
        for axis in range(3):
            total = (
                np.int64(corners[i, 0, axis]) + np.int64(corners[i, 1, axis]) + np.int64(corners[i, 2, axis])
            )
            place |= spread((total // 3 + LIMIT) >> 3) << axis
        places[i] = place


@plain_kernel
def comes_before(places: Any, corners: Any, i: Any, j: Any) -> Any:
    """Whether a face comes before another one: by place, then by corners where there are any."""
    if places[i] != places[j]:
        return places[i] < places[j]
    if len(corners):
        for k in range(9):
            one, two = corners[i, k // 3, k % 3], corners[j, k // 3, k % 3]
            if one != two:
                return one < two
    return False


@kernel
def put_in_order(places: Any, corners: Any, order: Any) -> Any:
    """Fill (F,) int64 with the order of faces by place, then by (F, 3, 3) corners, then as they are given.

    A merge sort (D. E. Knuth, The Art of Computer Programming 3, 1973, 5.2.4) of the runs that are there:
    faces mostly come in order.
    """
    count = len(order)
    spare = np.empty(count, np.int64)
    ends = np.empty(count + 1, np.int64)
    runs = 0
    ends[0] = 0
    for i in range(count):
        order[i] = i
        if i + 1 == count or comes_before(places, corners, i + 1, i):
            runs += 1
            ends[runs] = i + 1
    while runs > 1:
        merged = 0
        for r in range(0, runs, 2):
            low, high = ends[r], ends[min(r + 1, runs)]
            end = ends[min(r + 2, runs)]
            merge_runs(places, corners, (order, spare), (low, high, end))
            merged += 1
            ends[merged] = end
        order[:] = spare
        runs = merged


@plain_kernel
def merge_runs(places: Any, corners: Any, orders: Any, bounds: Any) -> Any:
    """Merge two runs of an order that lie behind each other into another array."""
    order, spare = orders
    i, middle, end = bounds
    j = middle
    for k in range(i, end):
        take = i < middle and (j == end or not comes_before(places, corners, order[j], order[i]))
        if take:
            spare[k] = order[i]
            i += 1
        else:
            spare[k] = order[j]
            j += 1


def canonical(corners: NDArray[Any]) -> NDArray[Any]:
    """Return (F, 3, 3) corners, each face turned so that it starts with the least of its rotations."""
    turned = np.array(corners)
    turn_faces(turned)
    return turned


def places_of(corners: NDArray[Any]) -> NDArray[np.int64]:
    """(F,) places of faces on the curve that contents are ordered by."""
    places = np.zeros(len(corners), np.int64)
    curve_places(corners, places)
    return places


def order_of(corners: NDArray[Any], places: NDArray[np.int64]) -> NDArray[np.int64]:
    """(F,) order of faces on the curve; at one place by their corners."""
    order = np.zeros(len(places), np.int64)
    put_in_order(places, corners, order)
    return order
