"""From a scene to navigation cells and their portals: the stages in order."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.buckets import FaceBuckets, make_buckets
from tilesnav_ref.cells.domain import GridSizes, grid_sizes, make_domain, make_roots, scene_ground
from tilesnav_ref.cells.driving import GroundMission
from tilesnav_ref.cells.flood import VoxelFlood
from tilesnav_ref.cells.heights import Space, flood_space, measure_coverage
from tilesnav_ref.cells.joining import join_prisms
from tilesnav_ref.cells.meeting import REACH
from tilesnav_ref.cells.merge import merge_boxes
from tilesnav_ref.cells.mission import Mission
from tilesnav_ref.cells.model import KIND_GROUND, CellComplex
from tilesnav_ref.cells.portals import find_contacts, open_contacts, portal_table
from tilesnav_ref.cells.prisms import prism_bounds, prism_corners, prisms_of_boxes
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
from tilesnav_ref.cells.subdivision import Progress, free_boxes, free_prisms
from tilesnav_ref.cells.terrain import Ground
from tilesnav_ref.cells.unmeasured import in_unknown
from tilesnav_ref.scene.model import Scene

Context = tuple[CellSettings, GridSizes, float]
_LOG = logging.getLogger(__name__)


def faces_around(scene: Scene, domain: NDArray[np.int64], sizes: GridSizes) -> FaceBuckets:
    """Faces that any later question can ask for: those near the domain, below it and above it up to the
    sky."""
    corners = scene.corners()
    margin = REACH * sizes.clearance + sizes.min_size + 3
    box = np.stack((domain[0] - margin, domain[1] + margin))
    box[0, 2] = min(box[0, 2], domain[0, 2] - sizes.ground_height - margin)
    box[1, 2] = max(box[1, 2], int(corners[:, :, 2].max()) + margin)
    near = _near(corners, box)
    if scene.unknown is None:
        return make_buckets(near, box, 4 * sizes.min_size)
    border = _near(scene.unknown.border(), box)
    buckets = make_buckets(np.concatenate((near, border)), box, 4 * sizes.min_size)
    return replace(buckets, unknown=scene.unknown, real=len(near))


def _near(corners: NDArray[np.int64], box: NDArray[np.int64]) -> NDArray[np.int64]:
    """The triangles (F, 3, 3) whose bounds meet a box (2, 3)."""
    near = np.all((corners.max(axis=1) >= box[0]) & (corners.min(axis=1) <= box[1]), axis=1)
    return np.ascontiguousarray(corners[near])


def _free_cells(
    buckets: FaceBuckets,
    roots: NDArray[np.int64],
    flood: VoxelFlood,
    context: Context,
    progress: Progress | None,
) -> NDArray[np.int64]:
    """Prisms (P, 11) of the free space by the method of the settings, joined where it joins."""
    settings, sizes, _ = context
    if settings.mission == "ground":  # tiles on slopes are small, and each of them is a part of the way
        settings = replace(settings, cell_price=0.0)
    if settings.method == "prisms":
        prisms = free_prisms(buckets, roots, flood, (sizes, settings), progress)
        prisms = prisms[~in_unknown(prism_corners(prisms), buckets.unknown)]
        prisms = join_prisms(prisms, sizes.max_size, sizes.clearance, buckets)
    else:
        boxes = free_boxes(buckets, roots, sizes, settings, progress)
        boxes = boxes[~in_unknown(boxes, buckets.unknown)]
        if settings.method == "boxes":
            boxes = merge_boxes(boxes, sizes.max_size, buckets if sizes.clearance == 0 else None)
        prisms = prisms_of_boxes(boxes)
    return prisms


def _mission(scene: Scene, settings: CellSettings, sizes: GridSizes, ground: Ground) -> Space:
    if settings.mission == "ground":
        return GroundMission(scene, settings, sizes, ground)
    return Mission(settings, sizes, scene.step, ground)


def _mission_cells(
    buckets: FaceBuckets,
    space: tuple[NDArray[np.int64], NDArray[np.int64], VoxelFlood],
    mission: Space,
    context: Context,
    progress: Progress | None,
) -> NDArray[np.int64]:
    """Prisms (P, 11) of a mission, joined within each sector; with sectors, progress counts their roots.

    ``space`` is the roots, the whole domain, and the voxels that are reached in the domain of all roots. A
    sector has voxels of its own, so that its cells do not depend on what is far away.
    """
    settings, sizes, step = context
    roots, whole, flood = space
    done = 0

    def divide(part: NDArray[np.int64], domain: NDArray[np.int64]) -> NDArray[np.int64]:
        nonlocal done
        if sizes.sector == 0:
            return _free_cells(buckets, part, flood, context, progress)
        near = flood_space(buckets, (domain, whole), mission, context)
        prisms = _free_cells(buckets, part, near, context, None)
        done += len(part)
        if progress is not None:
            progress(done, len(roots))
        return prisms

    prisms = sector_by_sector(roots, sizes.sector, settings.sector, divide)
    if len(prisms) == 0:
        domain = np.stack((roots[:, 0].min(axis=0), roots[:, 1].max(axis=0)))
        start = "a point of the corridor" if settings.mission == "corridor" else "the sky"
        raise CellError(
            f"no free space: no cell of {sizes.min_size * step} m with a clearance of "
            f"{sizes.clearance * step} m fits into the domain {(domain * step).tolist()} m and is connected "
            f"to {start if settings.seeds == 'sky' else 'the seeds'}"
        )
    return prisms[mission.keep(prism_bounds(prisms))] if isinstance(mission, Mission) else prisms


def _kinds(prisms: NDArray[np.int64], buckets: FaceBuckets, context: Context) -> NDArray[np.uint8]:
    settings, sizes, _ = context
    if settings.mission == "ground":
        return np.full(len(prisms), KIND_GROUND, np.uint8)
    return cell_kinds(prisms, buckets, sizes.ground_height, settings.ground_slope)


def decompose(
    scene: Scene, settings: CellSettings | None = None, progress: Progress | None = None
) -> CellComplex:
    """Divide the free space of a scene into cells with six planes and find their portals.

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
        meets no face, interiors are disjoint, and every polygon of more than a square grid step in which flat
        sides of two cells touch and that no face meets is a portal. The same input gives the same cells,
        whatever the number of threads.

    Raises
    ------
    CellError
        Empty scene, region outside of it, no free space, nothing connected to the seeds, a seed near a face
        or outside the domain, or more cells than ``max_cells``.

    Notes
    -----
    Cells are of kind ground by the rule of :func:`tilesnav_ref.cells.selection.cell_kinds`; the coverage is
    that of :mod:`tilesnav_ref.cells.coverage`.
    """
    settings = settings or CellSettings()
    if scene.unknown is not None and not scene.unknown.open_above:
        settings = replace(settings, keep_interiors=True)  # free because it was measured, not for its sky
    sizes = grid_sizes(settings, scene.step)
    context = (settings, sizes, scene.step)
    ground = scene_ground(scene, settings)
    mission = _mission(scene, settings, sizes, ground)
    whole = make_domain(scene, settings, sizes, ground)
    buckets = faces_around(scene, whole, sizes)
    roots = make_roots(whole, sizes, settings.max_cells)
    roots = mission.roots(roots_around(roots, sizes.sector, settings.sector, scene.step))
    domain = np.stack((roots[:, 0].min(axis=0), roots[:, 1].max(axis=0)))
    flood = flood_space(buckets, (domain, whole), mission, context)
    prisms = _mission_cells(buckets, (roots, whole, flood), mission, context, progress)
    contacts = open_contacts(find_contacts(prisms), buckets if sizes.clearance == 0 else None)
    places = sector_places(prism_bounds(prisms)[:, 0], sizes.sector)
    if isinstance(mission, GroundMission):
        cells = (prism_corners(prisms), prisms)
        kept, contacts = mission.choose(cells, contacts, buckets, places, scene.step)
    else:
        starts = start_cells(prisms, mission, (roots, whole), buckets, context)
        kept = connected_within(contacts.pairs, starts, places)
    chosen = np.flatnonzero(kept & only_sector(places, settings.sector))
    if len(chosen) == 0:
        raise CellError(f"no free space: no cell is in sector {settings.sector}; allowed: another sector")
    order, sector_offsets = sector_order(prism_bounds(prisms[chosen]), sizes.sector, spatial_order)
    contacts, prisms = contacts.renumbered(chosen[order], len(prisms)), prisms[chosen[order]]
    offsets, targets, polygons = portal_table(contacts, len(prisms))
    polygon_offsets, polygon_vertices = contacts.polygons()
    coverage, bands = measure_coverage(prisms, (buckets, flood), domain, mission, context)
    _LOG.info("%d cells, %d portals, coverage %.4f", len(prisms), len(targets), coverage)
    bounds = prism_bounds(prisms)
    return CellComplex(
        lower=np.ascontiguousarray(bounds[:, 0]),
        upper=np.ascontiguousarray(bounds[:, 1]),
        kinds=_kinds(prisms, buckets, context),
        portal_offsets=offsets,
        portal_targets=targets,
        portal_polygons=polygons,
        clearance=sizes.clearance,
        coverage=coverage,
        polygon_offsets=polygon_offsets,
        polygon_vertices=polygon_vertices,
        corners=prism_corners(prisms),
        sector_offsets=sector_offsets,
        bands=bands,
    )
