"""Where faces are on the curve that contents are ordered by, and the one form of their corners.

References
----------
G. M. Morton, A computer oriented geodetic data base, 1966.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import inner_kernel, kernel

LIMIT = 1 << 23
"""Coordinates are less than this in magnitude."""


@inner_kernel
def spread(number: int) -> int:
    """Put two zero bits between the lowest 21 bits of a number."""
    number &= 0x1FFFFF
    number = (number | number << 32) & 0x1F00000000FFFF
    number = (number | number << 16) & 0x1F0000FF0000FF
    number = (number | number << 8) & 0x100F00F00F00F00F
    number = (number | number << 4) & 0x10C30C30C30C30C3
    return (number | number << 2) & 0x1249249249249249


@kernel
def place_faces(corners: NDArray[np.int64], keys: NDArray[np.int64]) -> None:
    """Find the places of faces on the curve: those of a third of the sum of their corners, rounded down.

    Parameters
    ----------
    corners : (F, 3, 3) int64
        Grid coordinates of magnitude below 2**23.
    keys : (F,) int64
        Filled; the same as `tilesnav_ref.morton.morton` gives.
    """
    for i in range(len(corners)):
        key = 0
        for axis in range(3):
            middle = (corners[i, 0, axis] + corners[i, 1, axis] + corners[i, 2, axis]) // 3
            key |= spread((middle + LIMIT) >> 3) << axis
        keys[i] = key


@inner_kernel
def is_less(corners: NDArray[np.int64], i: int, a: int, b: int) -> bool:
    """Whether the rotation of a face that begins with corner a is less than that which begins with b."""
    for k in range(3):
        p, q = (a + k) % 3, (b + k) % 3
        for axis in range(3):
            if corners[i, p, axis] != corners[i, q, axis]:
                return bool(corners[i, p, axis] < corners[i, q, axis])
    return False


@kernel
def turn_faces(corners: NDArray[np.int64]) -> None:
    """Turn faces in place until the nine numbers of each are the least of its three rotations.

    Parameters
    ----------
    corners : (F, 3, 3) int64
    """
    for i in range(len(corners)):
        first = 0
        for other in range(1, 3):
            if is_less(corners, i, other, first):
                first = other
        for _ in range(first):
            for axis in range(3):
                least = corners[i, 0, axis]
                corners[i, 0, axis] = corners[i, 1, axis]
                corners[i, 1, axis] = corners[i, 2, axis]
                corners[i, 2, axis] = least
