"""Regions of certificates and their parts: boxes, and prisms over trapezoids.

A prism is a row of eight numbers: its lower corner, its upper corner, p and q. Its run axis u and its slanted
axis v follow from its shape. At the lower u the coordinate v runs between the bounds of the corners, at the
upper u between p and q, and in between linearly. A box is the prism with the same bounds at both ends.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int64]

AXES = ((0, 1), (0, 1), (1, 2), (2, 0), (0, 2), (1, 0), (2, 1))
"""Axes u and v of each shape. For a box any two will do."""

SLANTED_AXIS = np.array([v for _, v in AXES])

CORNERS = np.array([[(corner >> axis) & 1 for axis in range(3)] for corner in range(8)], dtype=bool)
"""On which side of each axis a corner is."""


def box_corners(low: IntArray, high: IntArray) -> IntArray:
    """Corners of boxes, shape (k, 8, 3)."""
    return np.where(CORNERS, high[:, None], low[:, None])


def filled(region: list[int], shape: int) -> tuple[int, ...]:
    """A row of a file as a prism: the p and the q of a box, which are 0 there, become its bounds."""
    if shape == 0:
        _, v = AXES[shape]
        region = [*region[:6], region[v], region[v + 3]]
    return tuple(region)


def corners(rows: IntArray, shapes: IntArray) -> IntArray:
    """Corners of prisms, shape (k, 8, 3); corner i is on the upper side of axis j where bit j of i is set.

    Parameters
    ----------
    rows : ndarray of int64, shape (k, 8)
        The p and the q of boxes are not looked at.
    shapes : ndarray of int64, shape (k,)
    """
    result = box_corners(rows[:, :3], rows[:, 3:6])
    for shape in np.unique(shapes[shapes > 0]):
        chosen = np.flatnonzero(shapes == shape)
        u, v = AXES[shape]
        for side in (0, 1):
            at = np.flatnonzero(CORNERS[:, u] & (CORNERS[:, v] == side))
            result[chosen[:, None], at, v] = rows[chosen, 6 + side][:, None]
    return result
