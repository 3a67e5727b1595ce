"""The six planes of a cell, as the nav file stores them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.model import CellComplex

_ROUNDING = 2.0**-50
"""Relative error of a sum of two products and of its negation: three roundings of 2**-53 each, and the rest
for comfort. 2**-50 of 2**13 m, the largest coordinate at a step of 2**-10 m, is 2**-37 m."""


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
        (N, 6, 4) float64, nav frame, metres, in the order -x, +x, -y, +y, -z, +z.

    Notes
    -----
    Planes normal to an axis are exact: a grid coordinate has fewer than 24 bits and the step is a power of
    two. The normal of a slanted side is rounded; its d is then moved inwards so far that every corner of the
    side on the grid has n.x + d >= 0 in exact arithmetic. So the cell that the planes bound lies in the cell
    on the grid: what is proven for that one holds, and neighbours stay disjoint.
    """
    result = np.zeros((cells.count, 6, 4))
    for axis in range(3):
        for upper in range(2):
            numbers = [corner for corner in range(8) if corner >> axis & 1 == upper]
            side = cells.corners[:, numbers]
            outward = 2.0 * upper - 1.0
            result[:, 2 * axis + upper, axis] = outward
            result[:, 2 * axis + upper, 3] = -outward * side[:, 0, axis] * step
            slanted = np.flatnonzero(np.any(side[:, :, axis] != side[:, :1, axis], axis=1))
            result[slanted, 2 * axis + upper] = _slanted(side[slanted], axis, outward, step)
    return result + 0.0  # turns -0.0 into 0.0, so that equal planes have equal bytes


def _slanted(side: NDArray[np.int64], axis: int, outward: float, step: float) -> NDArray[np.float64]:
    """Planes (S, 4) of slanted sides (S, 4, 3), whose corners stand for (-, -), (+, -), (-, +), (+, +) on the
    two other axes."""
    result, rows = np.zeros((len(side), 4)), np.arange(len(side))
    others = [k for k in range(3) if k != axis]
    # along which of the two other axes the side slants: corners 0 and 1 differ along the first alone
    along_first = side[:, 0, axis] != side[:, 1, axis]
    u = np.where(along_first, others[0], others[1])
    last = side[rows, np.where(along_first, 1, 2)]
    run = (last[rows, u] - side[rows, 0, u]).astype(np.float64)
    slant = (last[:, axis] - side[:, 0, axis]).astype(np.float64)
    length = np.sqrt(run * run + slant * slant)
    result[rows, u], result[:, axis] = -outward * slant / length, outward * run / length
    terms = side.astype(np.float64) * step * result[:, None, :3]
    least = terms.sum(axis=2).min(axis=1)
    result[:, 3] = -least + np.abs(terms).sum(axis=2).max(axis=1) * _ROUNDING
    return result
