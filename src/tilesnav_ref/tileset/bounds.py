"""Bounding volumes that really bound, as boxes of 3D Tiles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def box_volume(lower: NDArray[np.int64], upper: NDArray[np.int64], step: float) -> list[float]:
    """Centre and half-axes of the box around grid coordinates.

    Parameters
    ----------
    lower, upper : (3,) int64
        Least and greatest grid coordinates, nav frame.
    step : float
        Metres; a power of two.

    Returns
    -------
    list of 12 float
        Centre, then the half-axes along x, y and z, metres, nav frame.

    Notes
    -----
    Sums of two grid coordinates have at most 25 bits, so centre and half-axes are exact in float64 and the
    box is tight. A flat side gets a half-axis of one step: a box of no volume has no orientation that
    viewers could use.
    """
    centre = (lower + upper) * (step / 2)
    half = np.maximum(upper - lower, 2) * (step / 2)
    axes = np.diag(half)
    return [float(v) for v in (*centre, *axes.ravel())]


def diagonal(lower: NDArray[np.int64], upper: NDArray[np.int64], step: float) -> float:
    """Length of the diagonal of a box of grid coordinates, in metres."""
    return float(np.linalg.norm((upper - lower) * step))
