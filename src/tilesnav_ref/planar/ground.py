"""Points on the ground, from their classes or as the lowest surface.

References
----------
K. Zhang et al., "A progressive morphological filter for removing nonground measurements from airborne LIDAR
data", IEEE Transactions on Geoscience and Remote Sensing 41(4), 2003; here with one opening, since what is
wrongly left out stays a gap and nothing worse.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

GROUND = 2
"""Class of the ground (ASPRS LAS)."""
CELL = 2.0
"""Edge of the raster, metres. Cells without points are as high as the highest one, and so no ground."""
WINDOW = 15
"""Cells: what is narrower than 30 m and stands higher than its surroundings is no ground. The flat middle of
a wider roof counts as ground, which does no harm: what is made of it lies on its points as well. With 62 m
the slopes of a third of the ground were lost."""
ABOVE = 0.5
"""Greatest height above the lowest surface, metres: kerbs and slopes within a cell, but no roof."""
CELLS_LIMIT = 1 << 24
"""Most cells of the raster; their edge is doubled to stay below."""


def ground_points(points: NDArray[np.float64], classes: NDArray[np.uint8] | None) -> NDArray[np.bool_]:
    """Which points are on the ground.

    Parameters
    ----------
    points : (N, 3) float64
        Metres, z up.
    classes : (N,) uint8 | None
        ASPRS classes; what they say counts where any point is of class 2.

    Returns
    -------
    (N,) bool
    """
    if classes is not None:
        classified = classes == GROUND
        if classified.any():
            return np.asarray(classified)
    if not len(points):
        return np.zeros(0, np.bool_)
    low, size = points.min(axis=0)[:2], CELL
    extent = np.ptp(points[:, :2], axis=0)
    while np.prod(extent // size + 1) > CELLS_LIMIT:
        size *= 2
    column, row = np.floor((points[:, :2] - low) / size).astype(np.int64).T
    lowest = np.full((column.max() + 1, row.max() + 1), np.inf)
    np.minimum.at(lowest, (column, row), points[:, 2])
    # an opening is the highest of the lowest: cells without points must not be the lowest of any window
    lowest[np.isinf(lowest)] = lowest[np.isfinite(lowest)].max()
    surface = ndimage.grey_opening(lowest, WINDOW)
    return np.asarray(points[:, 2] - surface[column, row] < ABOVE)
