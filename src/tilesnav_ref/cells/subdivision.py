"""Roots of the domain divided into free cells by threads."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.boxes import divide_root
from tilesnav_ref.cells.buckets import FaceBuckets, gather
from tilesnav_ref.cells.domain import GridSizes
from tilesnav_ref.cells.flood import REACHED, VoxelFlood
from tilesnav_ref.cells.greedy import NODES, divide_tile
from tilesnav_ref.cells.meeting import REACH
from tilesnav_ref.cells.prisms import WIDTH, move
from tilesnav_ref.cells.settings import CellError, CellSettings
from tilesnav_ref.cells.slices import MOST
from tilesnav_ref.kernels import kernel
from tilesnav_ref.processors import thread_count

_BOX_ROOTS = 64
_PRISM_ROOTS = 8
"""Roots in one task: about a tenth of a second of work."""
Progress = Callable[[int, int], None]
Divide = Callable[[NDArray[np.int64]], NDArray[np.int64]]


@kernel
def _boxes_of_roots(
    corners: NDArray[np.int64],
    frame: tuple[NDArray[np.int64], int, NDArray[np.int64]],
    lists: tuple[NDArray[np.int64], NDArray[np.int64]],
    roots: NDArray[np.int64],
    sizes: tuple[int, int],
) -> tuple[int, NDArray[np.int64]]:
    """Free boxes of some roots (R, 2, 3); count -1 where they nest too deeply."""
    marks, room = np.full(len(corners), -1, np.int64), np.empty(len(corners), np.int64)
    all_found, total = np.empty((256, 2, 3), np.int64), 0
    found, box = np.empty((64, 2, 3), np.int64), np.empty((2, 3), np.int64)
    for r in range(len(roots)):
        box[0], box[1] = roots[r, 0] - sizes[1], roots[r, 1] + sizes[1]
        near = gather(frame, lists, box, (marks, r), room)
        count, found = divide_root(corners, room[:near], roots[r], sizes, found)
        if count < 0:
            return -1, all_found
        if total + count > len(all_found):
            larger = np.empty((2 * (total + count), 2, 3), np.int64)
            larger[:total] = all_found[:total]
            all_found = larger
        all_found[total : total + count] = found[:count]
        total += count
    return total, all_found


@kernel
def _prisms_of_roots(
    corners: NDArray[np.int64],
    frame: tuple[NDArray[np.int64], int, NDArray[np.int64]],
    lists: tuple[NDArray[np.int64], NDArray[np.int64]],
    voxels: tuple[NDArray[np.int64], int, NDArray[np.uint8], int],
    work: tuple[NDArray[np.int64], tuple[int, int, int, float]],
) -> NDArray[np.int64]:
    """Free prisms of some roots (R, 2, 3); ``work`` = roots, sizes of `divide_tile`."""
    roots, sizes = work
    reach = REACH * sizes[2] + 3  # faces that an inflated prism can meet, not only the inflated root
    marks, room = np.full(len(corners), -1, np.int64), np.empty(len(corners), np.int64)
    found, total = np.empty((256, WIDTH), np.int64), 0
    rows, box = np.empty((NODES * MOST, WIDTH), np.int64), np.empty((2, 3), np.int64)
    for r in range(len(roots)):
        box[0], box[1] = roots[r, 0] - reach, roots[r, 1] + reach
        near = gather(frame, lists, box, (marks, r), room)
        local = corners[room[:near]] - roots[r, 0]
        here = voxels[0] - roots[r, 0], voxels[1], voxels[2], voxels[3]
        count = divide_tile(local, roots[r, 1] - roots[r, 0], here, sizes, rows)
        if total + count > len(found):
            larger = np.empty((2 * (total + count), WIDTH), np.int64)
            larger[:total] = found[:total]
            found = larger
        for c in range(count):
            move(rows[c], roots[r, 0], found[total + c])
        total += count
    return found[:total]


def _run(
    divide: Divide,
    parts: list[NDArray[np.int64]],
    settings: CellSettings,
    progress: Progress | None,
) -> NDArray[np.int64]:
    """Results of all parts in their order; the order depends on the roots alone, not on the threads."""
    results: list[NDArray[np.int64]] = []
    total = 0
    with ThreadPoolExecutor(thread_count(settings.threads)) as pool:
        for done, found in enumerate(pool.map(divide, parts), start=1):
            results.append(found)
            total += len(found)
            if total > settings.max_cells:
                pool.shutdown(cancel_futures=True)
                raise CellError(
                    f"too many cells: more than {total} free ones; allowed: max_cells = {settings.max_cells}"
                )
            if progress is not None:
                progress(done, len(parts))
    return np.concatenate(results)


def _parts(roots: NDArray[np.int64], size: int) -> list[NDArray[np.int64]]:
    return [roots[start : start + size] for start in range(0, len(roots), size)]


def free_boxes(
    buckets: FaceBuckets,
    roots: NDArray[np.int64],
    sizes: GridSizes,
    settings: CellSettings,
    progress: Progress | None,
) -> NDArray[np.int64]:
    """All free boxes of the roots (R, 2, 3) by recursive division; (B, 2, 3).

    Raises
    ------
    CellError
        They nest too deeply, or there are more than ``max_cells``.
    """
    frame, lists = (buckets.origin, buckets.size, buckets.shape), (buckets.offsets, buckets.faces)

    def divide(part: NDArray[np.int64]) -> NDArray[np.int64]:
        count, found = _boxes_of_roots(buckets.corners, frame, lists, part, (sizes.min_size, sizes.clearance))
        if count < 0:
            raise CellError(
                f"boxes nest too deeply between max_size and min_size, {sizes.max_size} and {sizes.min_size} "
                "grid steps; allowed: a smaller ratio"
            )
        return np.asarray(found[:count])

    return _run(divide, _parts(roots, _BOX_ROOTS), settings, progress)


def free_prisms(
    buckets: FaceBuckets,
    roots: NDArray[np.int64],
    flood: VoxelFlood,
    context: tuple[GridSizes, CellSettings],
    progress: Progress | None,
) -> NDArray[np.int64]:
    """Prisms (P, 11) that the greedy decomposition finds worth keeping where the flood has reached.

    Raises
    ------
    CellError
        There are more than ``max_cells``.
    """
    sizes, settings = context
    frame, lists = (buckets.origin, buckets.size, buckets.shape), (buckets.offsets, buckets.faces)
    voxels = (flood.origin, flood.size, flood.states, REACHED)
    price = settings.cell_price * float(sizes.min_size) ** 3
    lengths = (sizes.min_size, sizes.end_width, sizes.clearance, price)

    def divide(part: NDArray[np.int64]) -> NDArray[np.int64]:
        return np.asarray(_prisms_of_roots(buckets.corners, frame, lists, voxels, (part, lengths)))

    return _run(divide, _parts(roots, _PRISM_ROOTS), settings, progress)
