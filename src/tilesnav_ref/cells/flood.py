"""A voxel flood of free space, independent of the cells: what "reachable" means in the coverage.

Notes
-----
A voxel is clear when its inflation has an interior that meets no face (exact). Clear voxels that share a
side are connected. The voxels are found by halving blocks of them, with the faces that meet a block passed
down.

References
----------
H. Samet, "The quadtree and related hierarchical data structures", ACM Computing Surveys 16(2), 1984.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.buckets import FaceBuckets, gather
from tilesnav_ref.cells.overlap import meets_box
from tilesnav_ref.kernels import kernel
from tilesnav_ref.processors import thread_count

VOXEL_LIMIT = 1 << 26
"""Most voxels of a flood; the resolution is made coarser to stay below. 64 MiB."""
BLOCK = 16
"""Edge in voxels of the blocks that are halved; a power of two."""
_DEPTH = 64
"""Pending blocks: at most one for each halving of a block along three axes, and one more."""
BLOCKED, CLEAR, REACHED = 0, 1, 2


@dataclass(frozen=True)
class VoxelFlood:
    """State of every voxel of a box."""

    origin: NDArray[np.int64]
    """(3,) grid."""
    size: int
    """Edge, grid steps."""
    states: NDArray[np.uint8]
    """(nx, ny, nz) BLOCKED, CLEAR or REACHED."""


@kernel
def _meeting(
    corners: NDArray[np.int64], pool: NDArray[np.int64], start: int, end: int, box: NDArray[np.int64]
) -> int:
    normal = np.empty(3, np.int64)
    new_end = end
    for s in range(start, end):
        if meets_box(corners[pool[s]], box[0], box[1], normal):
            pool[new_end] = pool[s]
            new_end += 1
    return new_end


@kernel
def _mark_block(
    corners: NDArray[np.int64],
    candidates: NDArray[np.int64],
    block: NDArray[np.int64],
    frame: tuple[NDArray[np.int64], int, int],
    states: NDArray[np.uint8],
) -> None:
    """Set the clear voxels of a block (2, 3) of voxel numbers; frame = origin, voxel size, inflation."""
    origin, size, inflation = frame
    pool = np.empty((_DEPTH + 1) * (len(candidates) + 1), np.int64)
    pool[: len(candidates)] = candidates
    stack, spans = np.empty((_DEPTH, 2, 3), np.int64), np.empty((_DEPTH, 2), np.int64)
    stack[0], spans[0, 0], spans[0, 1] = block, 0, len(candidates)
    box, top = np.empty((2, 3), np.int64), 1
    while top > 0:
        top -= 1
        low, high = stack[top, 0].copy(), stack[top, 1].copy()
        start, end = spans[top]
        box[0], box[1] = origin + low * size - inflation, origin + high * size + inflation
        new_end = _meeting(corners, pool, start, end, box)
        if new_end == end:
            states[low[0] : high[0], low[1] : high[1], low[2] : high[2]] = CLEAR
            continue
        axis = np.argmax(high - low)
        if high[axis] - low[axis] == 1:
            continue
        stack[top, 0], stack[top, 1], stack[top + 1, 0], stack[top + 1, 1] = low, high, low, high
        stack[top, 1, axis] = stack[top + 1, 0, axis] = (low[axis] + high[axis]) >> 1
        spans[top, 0], spans[top, 1], spans[top + 1, 0], spans[top + 1, 1] = end, new_end, end, new_end
        top += 2


@kernel
def _mark_slab(
    corners: NDArray[np.int64],
    frame: tuple[NDArray[np.int64], int, NDArray[np.int64]],
    lists: tuple[NDArray[np.int64], NDArray[np.int64]],
    voxels: tuple[NDArray[np.int64], int, int],
    states: NDArray[np.uint8],
    first: int,
) -> None:
    """Set the clear voxels of one layer of blocks, which begins at voxel ``first`` along x."""
    origin, size, inflation = voxels
    marks, room = np.full(len(corners), -1, np.int64), np.empty(len(corners), np.int64)
    block, box, value = np.empty((2, 3), np.int64), np.empty((2, 3), np.int64), 0
    block[0, 0], block[1, 0] = first, min(first + BLOCK, states.shape[0])
    for j in range(0, states.shape[1], BLOCK):
        for k in range(0, states.shape[2], BLOCK):
            block[0, 1], block[0, 2] = j, k
            block[1, 1] = min(j + BLOCK, states.shape[1])
            block[1, 2] = min(k + BLOCK, states.shape[2])
            box[0], box[1] = origin + block[0] * size - inflation, origin + block[1] * size + inflation
            count = gather(frame, lists, box, (marks, value), room)
            _mark_block(corners, room[:count], block, voxels, states)
            value += 1


@kernel
def _push_runs(
    column: NDArray[np.uint8],
    place: tuple[int, int],
    run: tuple[int, int],
    stack: NDArray[np.int32],
    top: int,
) -> int:
    """Push the first voxel of every clear run beside a run [start, end) in a column; returns the new top."""
    before = BLOCKED
    for k in range(run[0], run[1]):
        if column[k] == CLEAR and before != CLEAR:
            stack[top, 0], stack[top, 1], stack[top, 2] = place[0], place[1], k
            top += 1
        before = column[k]
    return top


@kernel
def spread(states: NDArray[np.uint8], starts: NDArray[np.int64]) -> None:
    """Turn CLEAR into REACHED for all voxels connected to the starts (S, 3), which must be CLEAR.

    Whole vertical runs are turned at once (A. R. Smith, "Tint fill", SIGGRAPH 1979), which keeps the list of
    what is pending short.
    """
    nx, ny, nz = states.shape
    stack = np.empty((len(starts) + 4 * nz + 1024, 3), np.int32)
    stack[: len(starts)] = starts
    top = len(starts)
    while top > 0:
        top -= 1
        i, j, start = stack[top]
        if states[i, j, start] != CLEAR:
            continue
        end = start
        while start > 0 and states[i, j, start - 1] == CLEAR:
            start -= 1
        while end < nz and states[i, j, end] == CLEAR:
            end += 1
        states[i, j, start:end] = REACHED
        if top + 4 * nz > len(stack):
            room = np.empty((2 * len(stack), 3), np.int32)
            room[:top] = stack[:top]
            stack = room
        if i > 0:
            top = _push_runs(states[i - 1, j], (i - 1, j), (start, end), stack, top)
        if i + 1 < nx:
            top = _push_runs(states[i + 1, j], (i + 1, j), (start, end), stack, top)
        if j > 0:
            top = _push_runs(states[i, j - 1], (i, j - 1), (start, end), stack, top)
        if j + 1 < ny:
            top = _push_runs(states[i, j + 1], (i, j + 1), (start, end), stack, top)


def clear_voxels(
    buckets: FaceBuckets, domain: NDArray[np.int64], size: int, clearance: int, threads: int = 1
) -> VoxelFlood:
    """Voxels of a domain (2, 3) and which of them are clear.

    Parameters
    ----------
    buckets
        Faces; their box must hold the inflated domain.
    domain
        (2, 3) grid; voxels that do not fit into it at its upper sides are left out.
    size
        Wanted edge, grid steps; a tenth is added until there are at most VOXEL_LIMIT voxels.
    clearance
        Grid steps; at least one is used, so that a wall between two voxels separates them.
    threads
        0: one for each usable processor.
    """
    size = max(size, 1)
    while np.prod((domain[1] - domain[0]) // size, dtype=np.float64) > VOXEL_LIMIT:
        size += max(size // 10, 1)
    shape = np.maximum((domain[1] - domain[0]) // size, 1)
    states = np.zeros(tuple(int(n) for n in shape), np.uint8)
    frame = (buckets.origin, buckets.size, buckets.shape)
    lists = (buckets.offsets, buckets.faces)
    voxels = domain[0], size, max(clearance, 1)
    with ThreadPoolExecutor(thread_count(threads)) as pool:
        layers = range(0, states.shape[0], BLOCK)
        list(pool.map(lambda i: _mark_slab(buckets.corners, frame, lists, voxels, states, i), layers))
    return VoxelFlood(domain[0], size, states)
