"""Places at which a tile may be cut: where faces begin and end, and the middles.

References
----------
I. Wald, V. Havran, "On building fast kd-trees for ray tracing, and on doing that in O(N log N)", 2006: cuts
at the bounds of clipped faces; binning leaves the heaviest of each bin.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel

SPLITS = 18
"""Most cuts that are compared: the middles, and five of each axis."""
_BINS = 24
"""Places nearer to each other than a bin are taken for one."""


@kernel
def _weigh(
    tile: NDArray[np.int64],
    polygons: tuple[NDArray[np.float64], NDArray[np.int64]],
    span: tuple[int, int],
    clearance: int,
    bins: tuple[NDArray[np.float64], NDArray[np.int64]],
) -> None:
    """For every axis and bin, the weight of faces that begin or end there, and the place of the heaviest."""
    vertices, counts = polygons
    weights, places = bins
    weights[:] = 0.0
    heaviest = np.zeros((3, _BINS))
    low, high = np.empty(3), np.empty(3)
    for s in range(span[0], span[1]):
        for k in range(3):
            low[k], high[k] = np.inf, -np.inf
            for a in range(counts[s]):
                low[k], high[k] = min(low[k], vertices[s, a, k]), max(high[k], vertices[s, a, k])
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            weight = (high[i] - low[i]) + (high[j] - low[j])
            for side in range(2):
                place = int(np.floor(low[k])) - clearance if side == 0 else int(np.ceil(high[k])) + clearance
                if not tile[0, k] < place < tile[1, k]:
                    continue
                b = (place - tile[0, k]) * _BINS // (tile[1, k] - tile[0, k])
                weights[k, b] += weight
                if weight > heaviest[k, b]:
                    heaviest[k, b], places[k, b] = weight, place


@kernel
def propose_splits(
    tile: NDArray[np.int64],
    polygons: tuple[NDArray[np.float64], NDArray[np.int64]],
    span: tuple[int, int],
    limits: tuple[int, int, int],
    splits: NDArray[np.int64],
) -> int:
    """Write axes and places of cuts to splits (SPLITS, 2); returns how many.

    Parameters
    ----------
    tile
        (2, 3) grid.
    polygons, span
        Faces cut to the inflated tile.
    limits
        Least edge of a cell, clearance, and most cuts beside that in the middle of the longest edge.
    """
    least, clearance, most = limits
    count, longest = 0, np.argmax(tile[1] - tile[0])
    for turn in range(3):
        k = (longest + turn) % 3
        if tile[1, k] - tile[0, k] >= 2 * least and (turn == 0 or most > 2):
            splits[count, 0], splits[count, 1] = k, (tile[0, k] + tile[1, k]) >> 1
            count += 1
    weights, places = np.empty((3, _BINS)), np.empty((3, _BINS), np.int64)
    _weigh(tile, polygons, span, clearance, (weights, places))
    while count < min(SPLITS, most + 1):
        at = np.argmax(weights)
        k, b = at // _BINS, at % _BINS
        if weights[k, b] <= 0.0:
            break
        weights[k, b] = 0.0
        if max(places[k, b] - tile[0, k], tile[1, k] - places[k, b]) >= least:
            splits[count, 0], splits[count, 1] = k, places[k, b]
            count += 1
    return count
