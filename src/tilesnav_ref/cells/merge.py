"""Greedy merging of boxes whose union is a box.

Notes
-----
One pass joins runs of boxes along one axis: boxes with the same cross-section, each beginning where the one
before ends, until the largest size is reached. Passes over the three axes repeat until nothing changes.

With a clearance the union of two clear boxes is clear, because their inflations overlap. Without one a thin
wall can lie in the common side, so that the side is tested.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.buckets import FaceBuckets
from tilesnav_ref.cells.walls import blocked_rectangles
from tilesnav_ref.kernels import kernel


def _sides(boxes: NDArray[np.int64], axis: int) -> NDArray[np.int64]:
    """(B, 2, 3) the upper side of every box along an axis, as a flat box."""
    sides = boxes.copy()
    sides[:, 0, axis] = boxes[:, 1, axis]
    return sides


@kernel
def _join_runs(boxes: NDArray[np.int64], open_side: NDArray[np.bool_], axis: int, max_size: int) -> int:
    """Join neighbours in the sorted array in place; returns the number of boxes that are left."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    last = 0
    for b in range(1, len(boxes)):
        same = open_side[b - 1] and boxes[last, 1, axis] == boxes[b, 0, axis]
        for k in (i, j):
            same = same and boxes[last, 0, k] == boxes[b, 0, k] and boxes[last, 1, k] == boxes[b, 1, k]
        if same and boxes[b, 1, axis] - boxes[last, 0, axis] <= max_size:
            boxes[last, 1, axis] = boxes[b, 1, axis]
        else:
            last += 1
            boxes[last] = boxes[b]
    return last + 1


def _merge_axis(
    boxes: NDArray[np.int64], axis: int, max_size: int, buckets: FaceBuckets | None
) -> NDArray[np.int64]:
    i, j = (axis + 1) % 3, (axis + 2) % 3
    order = np.lexsort((boxes[:, 0, axis], boxes[:, 1, j], boxes[:, 0, j], boxes[:, 1, i], boxes[:, 0, i]))
    boxes = boxes[order]
    open_side = np.ones(len(boxes), np.bool_)
    if buckets is not None:
        open_side = ~blocked_rectangles(buckets, _sides(boxes, axis), np.full(len(boxes), axis, np.int64))
    return boxes[: _join_runs(boxes, open_side, axis, max_size)]


def merge_boxes(boxes: NDArray[np.int64], max_size: int, walls: FaceBuckets | None) -> NDArray[np.int64]:
    """Join boxes to larger ones.

    Parameters
    ----------
    boxes
        (B, 2, 3) grid coordinates, disjoint interiors.
    max_size
        Largest edge, grid steps.
    walls
        Faces that may lie between two boxes; None where a clearance rules that out.

    Returns
    -------
    ndarray
        (B', 2, 3) int64; the same point set, B' <= B.
    """
    count = -1
    while len(boxes) != count:
        count = len(boxes)
        for axis in (2, 0, 1):
            boxes = _merge_axis(boxes, axis, max_size, walls)
    return boxes
