"""The first corner of a face, and the order of faces in space.

References
----------
G. M. Morton, A computer oriented geodetic data base, 1966 (interleaved bits keep neighbours near each other).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.packet.geometry_mesh import LIMIT

CURVE_BITS = 21
"""Bits of each coordinate on the curve; the lowest three of the 24 on the grid are left out."""


@kernel
def turn_faces(corners: Any) -> Any:
    """Turn each of (F, 3, 3) faces, in place, so that it starts with the least of its rotations."""
    flat = np.zeros(9, corners.dtype)
    for i in range(len(corners)):
        for k in range(9):
            flat[k] = corners[i, k // 3, k % 3]
        best = 0
        for turn in (3, 6):
            for k in range(9):
                one, other = flat[(k + turn) % 9], flat[(k + best) % 9]
                if one != other:
                    if one < other:
                        best = turn
                    break
        for k in range(9):
            corners[i, k // 3, k % 3] = flat[(k + best) % 9]


@kernel
def curve_places(corners: Any, places: Any) -> Any:
    """Place on the curve, (F,) int64, of the middle of each of (F, 3, 3) faces."""
    for i in range(len(corners)):
        place = np.int64(0)
        for axis in range(3):
            total = (
                np.int64(corners[i, 0, axis]) + np.int64(corners[i, 1, axis]) + np.int64(corners[i, 2, axis])
            )
            value = (total // 3 + LIMIT) >> 3
            for bit in range(CURVE_BITS):
                place |= ((value >> bit) & 1) << (3 * bit + axis)
        places[i] = place


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


def order_of(corners: NDArray[Any], places: NDArray[np.int64]) -> NDArray[np.intp]:
    """(F,) order of faces on the curve; at one place by their corners."""
    order = np.argsort(places, kind="stable")
    if np.any(np.diff(places[order]) == 0):
        order = np.lexsort((*corners.reshape(-1, 9).T[::-1], places))
    return order
