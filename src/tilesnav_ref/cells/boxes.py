"""Recursive decomposition of free space into axis-aligned boxes.

Notes
-----
A box is kept when its inflation by the clearance has an interior that meets no face. Otherwise it is cut in
two, near its faces or in the middle, and parts with an edge below the smallest size are dropped. Only the
faces that meet the inflated box go down to its parts, so that the lists shrink.

References
----------
H. Samet, "The quadtree and related hierarchical data structures", ACM Computing Surveys 16(2), 1984
(halving); where else to cut: see cuts.py.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.cuts import COMPARED, choose_cut
from tilesnav_ref.cells.overlap import meets_box
from tilesnav_ref.kernels import kernel

_DEPTH = 512
"""Room for pending boxes, one a level. Cuts halve a box or part it near a face; only max_size hundreds of
times min_size could need so many levels, and the kernel then stops with an error."""


@kernel
def _enlarged(array: NDArray[np.int64], needed: int) -> NDArray[np.int64]:
    """The array, copied to twice its length or to the needed one."""
    room = np.empty(max(needed, 2 * len(array)), np.int64)
    room[: len(array)] = array
    return room


@kernel
def _select_meeting(
    corners: NDArray[np.int64],
    pool: NDArray[np.int64],
    span: tuple[int, int],
    box: NDArray[np.int64],
    bounds: NDArray[np.int64],
    ranges: NDArray[np.int64],
) -> int:
    """Faces of pool[span] that meet the open box, written behind the span; returns their end.

    ``bounds`` (2, 3) receives the bounds of these faces, clipped to the box; the first of ``ranges``
    (R, 2, 3) those of each.
    """
    end = span[1]
    normal = np.empty(3, np.int64)
    bounds[0, :] = box[1]
    bounds[1, :] = box[0]
    for s in range(span[0], span[1]):
        triangle = corners[pool[s]]
        if not meets_box(triangle, box[0], box[1], normal):
            continue
        kept = end - span[1]
        for k in range(3):
            low = max(min(triangle[0, k], triangle[1, k], triangle[2, k]), box[0, k])
            high = min(max(triangle[0, k], triangle[1, k], triangle[2, k]), box[1, k])
            bounds[0, k], bounds[1, k] = min(bounds[0, k], low), max(bounds[1, k], high)
            if kept < len(ranges):
                ranges[kept, 0, k], ranges[kept, 1, k] = low, high
        pool[end] = pool[s]
        end += 1
    return end


@kernel
def _push_parts(
    stack: NDArray[np.int64], spans: NDArray[np.int64], top: int, cut: tuple[int, int], span: tuple[int, int]
) -> int:
    """Replace the box at the top of the stack by its two parts; returns the new top."""
    axis, place = cut
    stack[top + 1] = stack[top]
    stack[top, 1, axis] = place
    stack[top + 1, 0, axis] = place
    for t in range(top, top + 2):
        spans[t, 0], spans[t, 1] = span
    return top + 2


@kernel
def divide_root(
    corners: NDArray[np.int64],
    candidates: NDArray[np.int64],
    root: NDArray[np.int64],
    sizes: tuple[int, int],
    found: NDArray[np.int64],
) -> tuple[int, NDArray[np.int64]]:
    """Divide one box.

    Parameters
    ----------
    corners
        (F, 3, 3) grid coordinates of the faces.
    candidates
        (C,) faces that can meet the inflated root.
    root
        (2, 3) lower and upper corner, grid.
    sizes
        Smallest edge of a cell and clearance, grid steps.
    found
        (R, 2, 3) room for results.

    Returns
    -------
    count, found
        Number of free boxes, and the room, enlarged where needed. Count -1: the boxes nest too deeply.
    """
    min_size, clearance = sizes
    pool = np.empty(4 * len(candidates) + 16, np.int64)
    pool[: len(candidates)] = candidates
    stack, spans = np.empty((_DEPTH, 2, 3), np.int64), np.empty((_DEPTH, 2), np.int64)
    stack[0], spans[0, 0], spans[0, 1] = root, 0, len(candidates)
    box, bounds = np.empty((2, 3), np.int64), np.empty((2, 3), np.int64)
    ranges = np.empty((COMPARED, 2, 3), np.int64)
    count, top = 0, 1
    while top > 0:
        top -= 1
        if np.min(stack[top, 1] - stack[top, 0]) < min_size:
            continue  # what a free slab left over
        start, end = spans[top]
        if 2 * end - start > len(pool):
            pool = _enlarged(pool, 2 * end - start)
        box[0], box[1] = stack[top, 0] - clearance, stack[top, 1] + clearance
        new_end = _select_meeting(corners, pool, (start, end), box, bounds, ranges)
        if new_end == end:
            if count == len(found):
                room = np.empty((2 * count + 1, 2, 3), np.int64)
                room[:count] = found
                found = room
            found[count] = stack[top]
            count += 1
            continue
        few = new_end - end if new_end - end <= COMPARED else 0
        cut = choose_cut(stack[top], ranges[:few], bounds, sizes)
        if cut[0] >= 0:
            if top + 2 > _DEPTH:
                return -1, found
            top = _push_parts(stack, spans, top, cut, (end, new_end))
    return count, found
