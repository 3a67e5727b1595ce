"""Where a box with faces in it is cut.

Notes
-----
The widest slab at one side of the box that the faces leave free is cut off first. Without one, and with few
faces, the planes at the clearance from the bounds of each face compete: cutting there leaves a part that is
free of that face. The cost of a plane is the sum over both parts of volume times faces, as in the surface
area heuristic with volumes for areas. Many faces, or no better plane: the middle of the longest axis.

References
----------
I. Wald, V. Havran, "On building fast kd-trees for ray tracing, and on doing that in O(N log N)", 2006.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel

COMPARED = 32
"""Most faces whose planes compete; comparing them takes the square of their number."""


@kernel
def _free_slab(
    box: NDArray[np.int64], bounds: NDArray[np.int64], min_size: int, clearance: int
) -> tuple[int, int]:
    axis, place, best = -1, 0, 0.0
    for k in range(3):
        extent = box[1, k] - box[0, k]
        low_cut, high_cut = bounds[0, k] - clearance, bounds[1, k] + clearance
        if min(low_cut, box[1, k]) - box[0, k] >= min_size and (low_cut - box[0, k]) / extent > best:
            axis, place, best = k, low_cut, (low_cut - box[0, k]) / extent
        if box[1, k] - max(high_cut, box[0, k]) >= min_size and (box[1, k] - high_cut) / extent > best:
            axis, place, best = k, high_cut, (box[1, k] - high_cut) / extent
    return axis, place


@kernel
def _cost(
    box: NDArray[np.int64], ranges: NDArray[np.int64], k: int, place: int, sizes: tuple[int, int]
) -> float:
    """Volume times faces of both parts, as a share of the box; parts too thin for a cell count as full."""
    min_size, clearance = sizes
    left, right = 0, 0
    for f in range(len(ranges)):
        left += ranges[f, 0, k] < place + clearance
        right += ranges[f, 1, k] > place - clearance
    extent = box[1, k] - box[0, k]
    if place - box[0, k] < min_size:
        left = len(ranges)
    if box[1, k] - place < min_size:
        right = len(ranges)
    return float(((place - box[0, k]) * left + (box[1, k] - place) * right) / extent)


@kernel
def choose_cut(
    box: NDArray[np.int64], ranges: NDArray[np.int64], bounds: NDArray[np.int64], sizes: tuple[int, int]
) -> tuple[int, int]:
    """Axis and place of the cut; axis -1 when no part could hold a cell.

    Parameters
    ----------
    box
        (2, 3) grid.
    ranges
        (F, 2, 3) bounds of the faces that meet the inflated box, clipped to it; empty where there are many.
    bounds
        (2, 3) bounds of all of them.
    sizes
        Smallest edge and clearance, grid steps.
    """
    min_size, clearance = sizes
    axis, place = _free_slab(box, bounds, min_size, clearance)
    if axis >= 0:
        return axis, place
    longest = 0
    for k in range(1, 3):
        if box[1, k] - box[0, k] > box[1, longest] - box[0, longest]:
            longest = k
    best = np.inf
    if box[1, longest] - box[0, longest] >= 2 * min_size:
        axis, place = longest, (box[0, longest] + box[1, longest]) >> 1
        best = _cost(box, ranges, axis, place, sizes) if len(ranges) else 0.0
    for k in range(3):
        for f in range(2 * len(ranges)):
            side = f & 1
            plane = ranges[f >> 1, side, k] + (clearance if side == 1 else -clearance)
            if plane - box[0, k] < min_size and box[1, k] - plane < min_size:
                continue
            if not box[0, k] < plane < box[1, k]:
                continue
            cost = _cost(box, ranges, k, plane, sizes)
            if cost < best:
                axis, place, best = k, plane, cost
    return axis, place
