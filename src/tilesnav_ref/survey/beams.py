"""What a survey from known positions leaves unknown: everything that no beam has crossed.

References
----------
J. Amanatides, A. Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics 1987; H. Moravec,
A. Elfes, "High resolution maps from wide angle sonar", ICRA 1985 (free, occupied and unknown space).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.scene.unknown import UnknownSpace

CROSSINGS = 2
"""Beams that must have crossed a part of space: a single return may be a reflection."""
PARTS = 4
"""Parts of a block along each axis, all of which must have been crossed. Were the block judged as a whole,
two beams through its near half would free what is behind a wall in it that no beam met there."""
PARTS_LIMIT = 1 << 28
"""Most parts of blocks; the edge is doubled to stay below. 256 MiB."""
HELD = 255
"""In place of a count: a return lies in this part."""


@kernel
def cross_blocks(start: NDArray[np.float64], end: NDArray[np.float64], counts: NDArray[np.uint8]) -> None:
    """Count a beam in every part of space that it crosses before the one where it ends, and mark that one.

    Parameters
    ----------
    start, end
        (3,) scanner and return, in edges of a part from the lower corner of all.
    counts
        (nx, ny, nz) beams that crossed each part, at most `CROSSINGS`, or `HELD`; written to.
    """
    place, last, step = np.empty(3, np.int64), np.empty(3, np.int64), np.empty(3, np.int64)
    following, pace, inside = np.empty(3), np.empty(3), True
    for k in range(3):
        place[k], last[k] = int(np.floor(start[k])), int(np.floor(end[k]))
        run = end[k] - start[k]
        step[k] = 1 if run > 0 else -1
        pace[k] = abs(1.0 / run) if run != 0 else np.inf
        border = place[k] + 1 if run > 0 else place[k]
        following[k] = (border - start[k]) / run if run != 0 else np.inf
        inside = inside and 0 <= last[k] < counts.shape[k]
    left = abs(last[0] - place[0]) + abs(last[1] - place[1]) + abs(last[2] - place[2])
    while left > 0:
        within = True
        for k in range(3):
            within = within and 0 <= place[k] < counts.shape[k]
        if within and counts[place[0], place[1], place[2]] < CROSSINGS:
            counts[place[0], place[1], place[2]] += 1
        axis = 0
        for k in range(1, 3):
            nearer = place[axis] == last[axis] or following[k] < following[axis]
            if place[k] != last[k] and nearer:
                axis = k
        place[axis] += step[axis]
        following[axis] += pace[axis]
        left -= 1
    if inside:
        counts[last[0], last[1], last[2]] = HELD


@kernel
def cross_all(starts: NDArray[np.float64], ends: NDArray[np.float64], counts: NDArray[np.uint8]) -> None:
    """`cross_blocks` for beams from (N, 3) to (N, 3)."""
    for b in range(len(starts)):
        cross_blocks(starts[b], ends[b], counts)


def unknown_beside_beams(
    origins: NDArray[np.int64], returns: NDArray[np.int64], bounds: NDArray[np.int64], size: int
) -> UnknownSpace:
    """Unknown space of a survey whose beams are known.

    Parameters
    ----------
    origins : (N, 3) int64
        Where the scanner was for each return, on the grid of the scene.
    returns : (N, 3) int64
        All returns.
    bounds : (2, 3) int64
        Box of the scene; the blocks cover it and all origins.
    size : int
        Edge of a block, grid steps; doubled where there would be too many.

    Returns
    -------
    UnknownSpace
        Not open above. A block is known to be free when `CROSSINGS` beams have crossed each of its parts and
        none has ended in it: what is in no plane, such as leaves, is a return all the same.
    """
    low = np.minimum(np.minimum(returns.min(axis=0), origins.min(axis=0)), bounds[0])
    high = np.maximum(np.maximum(returns.max(axis=0), origins.max(axis=0)), bounds[1])
    extent = high - low + 1
    while np.prod(-(-extent // size), dtype=np.float64) * PARTS**3 > PARTS_LIMIT:
        size *= 2
    shape = tuple(int(n) for n in -(-extent // size))
    counts = np.zeros([n * PARTS for n in shape], np.uint8)
    cross_all((origins - low) / (size / PARTS), (returns - low) / (size / PARTS), counts)
    parts = (counts != CROSSINGS).reshape([n for count in shape for n in (count, PARTS)])
    cuts = [low[k] + np.arange(shape[k] + 1) * size for k in range(3)]
    return UnknownSpace((cuts[0], cuts[1], cuts[2]), parts.any(axis=(1, 3, 5)), open_above=False)
