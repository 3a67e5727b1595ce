"""The six planes of a box cell, as the nav file stores them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.model import CellComplex


def planes(cells: CellComplex, step: float) -> NDArray[np.float64]:
    """Planes (nx, ny, nz, d) with outward unit normals; inside is n.x + d <= 0.

    Parameters
    ----------
    cells
        N cells on the grid.
    step
        Grid step, m; a power of two.

    Returns
    -------
    ndarray
        (N, 6, 4) float64, nav frame, metres, in the order -x, +x, -y, +y, -z, +z. Exact: a grid coordinate
        has fewer than 24 bits and the step is a power of two.
    """
    result = np.zeros((cells.count, 6, 4))
    for axis in range(3):
        result[:, 2 * axis, axis] = -1.0
        result[:, 2 * axis, 3] = cells.lower[:, axis] * step
        result[:, 2 * axis + 1, axis] = 1.0
        result[:, 2 * axis + 1, 3] = -cells.upper[:, axis] * step
    return result + 0.0  # turns -0.0 into 0.0, so that equal planes have equal bytes
