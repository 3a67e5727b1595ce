"""Fewer points where a cloud is much denser than elsewhere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.planar.grid import Grid, make_grid

CROWDED = 60.0
"""Points in the cube of a point, on average, above which a cloud is thinned. Half of the points have 16
neighbours in the radius and 5 in a cube; near a scanner on the ground it may be thousands, and the time
grows with their square."""
FINE = 5.0
"""A representative stands for a cube with this part of the radius as its edge: about 80 are left within the
radius of a point on a plane."""


def crowding(grid: Grid) -> float:
    """Mean number of points in the cube of a point."""
    counts = np.diff(grid.cubes).astype(np.float64)
    return float((counts**2).sum() / counts.sum())


def representatives(
    points: NDArray[np.float64], radius: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """One point of each fine cube, and the representative of every point.

    Returns
    -------
    (M,) int64 numbers of points and (N,) int64 places in them.
    """
    fine = make_grid(points, radius / FINE)
    chosen = fine.order[fine.cubes[:-1]]
    place = np.empty(len(points), np.int64)
    place[fine.order] = np.repeat(np.arange(len(chosen)), np.diff(fine.cubes))
    return chosen, place
