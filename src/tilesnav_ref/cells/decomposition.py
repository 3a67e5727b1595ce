"""From a scene to navigation cells and their portals: the stages in order."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.boxes import divide_root
from tilesnav_ref.cells.buckets import FaceBuckets, gather, make_buckets
from tilesnav_ref.cells.domain import GridSizes, grid_sizes, make_domain, make_roots, scene_ground
from tilesnav_ref.cells.driving import GroundMission
from tilesnav_ref.cells.heights import measure_coverage
from tilesnav_ref.cells.merge import merge_boxes
from tilesnav_ref.cells.mission import Mission
from tilesnav_ref.cells.model import KIND_GROUND, CellComplex, box_corners
from tilesnav_ref.cells.portals import find_contacts, open_contacts, portal_table, rectangle_polygons
from tilesnav_ref.cells.sectors import (
    connected_within,
    only_sector,
    roots_around,
    sector_by_sector,
    sector_order,
    sector_places,
)
from tilesnav_ref.cells.selection import cell_kinds, spatial_order, start_cells
from tilesnav_ref.cells.settings import CellError, CellSettings
from tilesnav_ref.cells.terrain import Ground
from tilesnav_ref.kernels import kernel
from tilesnav_ref.processors import thread_count
from tilesnav_ref.scene.model import Scene

_LOG = logging.getLogger(__name__)
_ROOTS_A_TASK = 64
Progress = Callable[[int, int], None]


@kernel
def _divide_roots(
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


def _free_boxes(
    buckets: FaceBuckets,
    roots: NDArray[np.int64],
    sizes: GridSizes,
    settings: CellSettings,
    progress: Progress | None,
) -> NDArray[np.int64]:
    """All free boxes of the roots; the order depends on the roots alone, not on the threads."""
    frame, lists = (buckets.origin, buckets.size, buckets.shape), (buckets.offsets, buckets.faces)
    parts = [roots[start : start + _ROOTS_A_TASK] for start in range(0, len(roots), _ROOTS_A_TASK)]
    boxes: list[NDArray[np.int64]] = []
    total = 0

    def divide(part: NDArray[np.int64]) -> NDArray[np.int64]:
        count, found = _divide_roots(buckets.corners, frame, lists, part, (sizes.min_size, sizes.clearance))
        if count < 0:
            raise CellError(
                f"boxes nest too deeply between max_size and min_size, {sizes.max_size} and {sizes.min_size} "
                "grid steps; allowed: a smaller ratio"
            )
        return np.asarray(found[:count])

    with ThreadPoolExecutor(thread_count(settings.threads)) as pool:
        for done, found in enumerate(pool.map(divide, parts), start=1):
            boxes.append(found)
            total += len(found)
            if total > settings.max_cells:
                pool.shutdown(cancel_futures=True)
                raise CellError(
                    f"too many cells: more than {total} free boxes; allowed: max_cells = {settings.max_cells}"
                )
            if progress is not None:
                progress(done, len(parts))
    return np.concatenate(boxes)


def _buckets_around(scene: Scene, domain: NDArray[np.int64], sizes: GridSizes) -> FaceBuckets:
    """Faces that any later question can ask for: those near the domain, below it and above it up to the
    sky."""
    corners = scene.corners()
    margin = sizes.clearance + sizes.min_size + 1
    box = np.stack((domain[0] - margin, domain[1] + margin))
    box[0, 2] = min(box[0, 2], domain[0, 2] - sizes.ground_height - margin)
    box[1, 2] = max(box[1, 2], int(corners[:, :, 2].max()) + margin)
    near = np.all((corners.max(axis=1) >= box[0]) & (corners.min(axis=1) <= box[1]), axis=1)
    return make_buckets(np.ascontiguousarray(corners[near]), box, 4 * sizes.min_size)


def _mission(
    scene: Scene, settings: CellSettings, sizes: GridSizes, ground: Ground
) -> Mission | GroundMission:
    if settings.mission == "ground":
        return GroundMission(scene, settings, sizes, ground)
    return Mission(settings, sizes, scene.step, ground)


def _mission_cells(
    buckets: FaceBuckets,
    roots: NDArray[np.int64],
    mission: Mission | GroundMission,
    context: tuple[CellSettings, GridSizes, float],
    progress: Progress | None,
) -> NDArray[np.int64]:
    """Free boxes of a mission, merged within each sector; with sectors, progress counts their roots."""
    settings, sizes, step = context
    walls = buckets if sizes.clearance == 0 else None
    done = 0

    def divide(part: NDArray[np.int64]) -> NDArray[np.int64]:
        nonlocal done
        boxes = _free_boxes(buckets, part, sizes, settings, progress if sizes.sector == 0 else None)
        if settings.method == "boxes":
            boxes = merge_boxes(boxes, sizes.max_size, walls)
        done += len(part)
        if progress is not None and sizes.sector:
            progress(done, len(roots))
        return boxes

    boxes = sector_by_sector(roots, sizes.sector, divide)
    if len(boxes) == 0:
        domain = np.stack((roots[:, 0].min(axis=0), roots[:, 1].max(axis=0)))
        raise CellError(
            f"no free space: no box of {sizes.min_size * step} m with a clearance of "
            f"{sizes.clearance * step} m fits into the domain {(domain * step).tolist()} m"
        )
    return boxes[mission.keep(boxes)] if isinstance(mission, Mission) else boxes


def _kinds(
    boxes: NDArray[np.int64], buckets: FaceBuckets, settings: CellSettings, sizes: GridSizes
) -> NDArray[np.uint8]:
    if settings.mission == "ground":
        return np.full(len(boxes), KIND_GROUND, np.uint8)
    return cell_kinds(boxes, buckets, sizes.ground_height, settings.ground_slope)


def decompose(
    scene: Scene, settings: CellSettings | None = None, progress: Progress | None = None
) -> CellComplex:
    """Divide the free space of a scene into box cells and find their portals.

    Parameters
    ----------
    scene
        Faces on the grid, nav frame, z up.
    settings
        Sizes, domain, selection; None: the defaults.
    progress
        Called with the number of finished and of all tasks of the decomposition, which is most of the work.

    Returns
    -------
    CellComplex
        Cells in Morton order of their centres. Every cell inflated by ``clearance`` has an interior that
        meets no face, interiors are disjoint, and every rectangle of positive area in which two cells touch
        and that no face meets is a portal. The same input gives the same cells, whatever the number of
        threads.

    Raises
    ------
    CellError
        Empty scene, region outside of it, no free space, nothing connected to the seeds, a seed near a face
        or outside the domain, or more boxes than ``max_cells``.

    Notes
    -----
    Cells are of kind ground by the rule of :func:`tilesnav_ref.cells.selection.cell_kinds`; the coverage is
    that of :mod:`tilesnav_ref.cells.coverage`.
    """
    settings = settings or CellSettings()
    sizes = grid_sizes(settings, scene.step)
    ground = scene_ground(scene, settings)
    mission = _mission(scene, settings, sizes, ground)
    domain = make_domain(scene, settings, sizes, ground)
    buckets = _buckets_around(scene, domain, sizes)
    roots = make_roots(domain, sizes, settings.max_cells)
    roots = mission.roots(roots_around(roots, sizes.sector, settings.sector, scene.step))
    domain = np.stack((roots[:, 0].min(axis=0), roots[:, 1].max(axis=0)))
    boxes = _mission_cells(buckets, roots, mission, (settings, sizes, scene.step), progress)
    walls = buckets if sizes.clearance == 0 else None
    contacts = open_contacts(find_contacts(boxes), walls)
    places = sector_places(boxes[:, 0], sizes.sector)
    if isinstance(mission, GroundMission):
        cells = (box_corners(boxes[:, 0], boxes[:, 1]), boxes)
        kept, contacts = mission.choose(cells, contacts, buckets, places, scene.step)
    else:
        starts = start_cells(boxes, mission, roots, buckets, (settings, sizes, scene.step))
        kept = connected_within(contacts.pairs, starts, places)
    chosen = np.flatnonzero(kept & only_sector(places, settings.sector))
    if len(chosen) == 0:
        raise CellError(f"no free space: no cell is in sector {settings.sector}; allowed: another sector")
    order, sector_offsets = sector_order(boxes[chosen], sizes.sector, spatial_order)
    contacts = contacts.renumbered(chosen[order], len(boxes))
    boxes = boxes[chosen[order]]
    offsets, targets, polygons = portal_table(contacts, len(boxes))
    coverage, bands = measure_coverage(boxes, buckets, domain, mission, (settings, sizes, scene.step))
    _LOG.info("%d cells, %d portals, coverage %.4f", len(boxes), len(targets), coverage)
    return CellComplex(
        lower=np.ascontiguousarray(boxes[:, 0]),
        upper=np.ascontiguousarray(boxes[:, 1]),
        kinds=_kinds(boxes, buckets, settings, sizes),
        portal_offsets=offsets,
        portal_targets=targets,
        portal_polygons=polygons,
        polygons=rectangle_polygons(contacts),
        clearance=sizes.clearance,
        coverage=coverage,
        sector_offsets=sector_offsets,
        bands=bands,
    )
