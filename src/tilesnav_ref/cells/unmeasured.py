"""Cells and voxels in unknown space.

Notes
-----
The border of unknown space is among the faces that cells must not meet, so the interior of a cell is on one
side of it as a whole, and one point of it tells which.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.flood import VoxelFlood
from tilesnav_ref.scene.unknown import UnknownSpace


def in_unknown(corners: NDArray[np.int64], unknown: UnknownSpace | None) -> NDArray[np.bool_]:
    """Which convex cells (C, N, 3) that no border of unknown space meets are in it; (C,) bool.

    The mean of the corners, which is inside, is taken in N-ths of a grid step.
    """
    if unknown is None or len(corners) == 0:
        return np.zeros(len(corners), np.bool_)
    return unknown.holds(corners.sum(axis=1), corners.shape[1])


def unknown_voxels(flood: VoxelFlood, unknown: UnknownSpace | None) -> NDArray[np.bool_]:
    """(nx, ny, nz) whether the middle of each voxel is in unknown space; those that its border meets are
    blocked by it."""
    if unknown is None:
        return np.zeros((1, 1, 1), np.bool_) & flood.states.astype(np.bool_)
    middles = tuple(
        2 * (flood.origin[k] + np.arange(flood.states.shape[k]) * flood.size) + flood.size for k in range(3)
    )
    return unknown.holds_lattice(middles, 2)
