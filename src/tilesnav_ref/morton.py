"""The curve along which faces are ordered.

References
----------
G. M. Morton, A computer oriented geodetic data base, 1966 (interleaved bits keep neighbours near each other).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

COORDINATE_LIMIT = 1 << 23
"""Grid coordinates are less than this in magnitude."""


def morton(points: NDArray[np.int64]) -> NDArray[np.uint64]:
    """Interleave 21 bits of each coordinate; the lowest three of the 24 bits on the grid are left out.

    Parameters
    ----------
    points : (N, 3) int64
        Grid coordinates of magnitude below 2**23.

    Returns
    -------
    (N,) uint64
    """
    code = np.zeros(len(points), np.uint64)
    shifted = ((points + COORDINATE_LIMIT) >> 3).astype(np.uint64)
    for k in range(3):
        x = shifted[:, k]
        for shift, mask in (
            (32, 0x1F00000000FFFF),
            (16, 0x1F0000FF0000FF),
            (8, 0x100F00F00F00F00F),
            (4, 0x10C30C30C30C30C3),
            (2, 0x1249249249249249),
        ):
            x = (x | (x << np.uint64(shift))) & np.uint64(mask)
        code |= x << np.uint64(k)
    return code
