"""From a scene to navigation cells and their portals: the stages in order."""

from __future__ import annotations

import logging

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.buckets import FaceBuckets, make_buckets
from tilesnav_ref.cells.coverage import flood_from_points, measure_coverage
from tilesnav_ref.cells.domain import GridSizes, grid_sizes, make_domain, make_roots
from tilesnav_ref.cells.flood import CLEAR, REACHED, VoxelFlood, clear_voxels, spread
from tilesnav_ref.cells.joining import join_prisms
from tilesnav_ref.cells.meeting import REACH
from tilesnav_ref.cells.merge import merge_boxes
from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.cells.portals import find_contacts, open_contacts, portal_table
from tilesnav_ref.cells.prisms import prism_bounds, prism_corners, prisms_of_boxes
from tilesnav_ref.cells.selection import cell_kinds, free_seeds, open_sky, select_reachable, spatial_order
from tilesnav_ref.cells.settings import CellError, CellSettings
from tilesnav_ref.cells.subdivision import Progress, free_boxes, free_prisms
from tilesnav_ref.scene.model import Scene

_LOG = logging.getLogger(__name__)


def faces_around(scene: Scene, domain: NDArray[np.int64], sizes: GridSizes) -> FaceBuckets:
    """Faces that any later question can ask for: those near the domain, below it and above it up to the
    sky."""
    corners = scene.corners()
    margin = REACH * sizes.clearance + sizes.min_size + 3
    box = np.stack((domain[0] - margin, domain[1] + margin))
    box[0, 2] = min(box[0, 2], domain[0, 2] - sizes.ground_height - margin)
    box[1, 2] = max(box[1, 2], int(corners[:, :, 2].max()) + margin)
    near = np.all((corners.max(axis=1) >= box[0]) & (corners.min(axis=1) <= box[1]), axis=1)
    return make_buckets(np.ascontiguousarray(corners[near]), box, 4 * sizes.min_size)


def reachable_voxels(
    buckets: FaceBuckets, domain: NDArray[np.int64], context: tuple[CellSettings, GridSizes, float]
) -> VoxelFlood:
    """Voxels of the domain with those reached that the settings ask for."""
    settings, sizes, _ = context
    flood = clear_voxels(buckets, domain, sizes.min_size // 4, sizes.clearance, settings.threads)
    states = flood.states
    if settings.keep_interiors:
        states[states == CLEAR] = REACHED
    elif settings.seeds == "sky":
        tops = np.argwhere(states[:, :, -1] == CLEAR)
        starts = np.column_stack((tops, np.full(len(tops), states.shape[2] - 1)))
        columns = np.stack(
            (flood.origin + starts * flood.size, flood.origin + (starts + 1) * flood.size), axis=1
        )
        spread(states, starts[open_sky(columns, buckets, sizes.clearance)])
    else:
        flood_from_points(flood, buckets, free_seeds(buckets, domain, context), sizes.clearance)
    return flood


def _free_cells(
    buckets: FaceBuckets,
    roots: NDArray[np.int64],
    flood: VoxelFlood,
    context: tuple[CellSettings, GridSizes, float],
    progress: Progress | None,
) -> NDArray[np.int64]:
    """Prisms (P, 11) of the free space by the method of the settings, joined where it joins."""
    settings, sizes, step = context
    if settings.method == "prisms":
        prisms = free_prisms(buckets, roots, flood, (sizes, settings), progress)
        prisms = join_prisms(prisms, sizes.max_size, sizes.clearance, buckets)
    else:
        boxes = free_boxes(buckets, roots, sizes, settings, progress)
        if settings.method == "boxes":
            boxes = merge_boxes(boxes, sizes.max_size, buckets if sizes.clearance == 0 else None)
        prisms = prisms_of_boxes(boxes)
    if len(prisms) == 0:
        reached = np.count_nonzero(flood.states == REACHED) * (flood.size * step) ** 3
        domain = np.stack((roots[:, 0].min(axis=0), roots[:, 1].max(axis=0)))
        raise CellError(
            f"no free space: no cell of {sizes.min_size * step} m with a clearance of "
            f"{sizes.clearance * step} m fits into the domain {(domain * step).tolist()} m, of which about "
            f"{reached:.4g} m3 are connected to {'the sky' if settings.seeds == 'sky' else 'the seeds'}"
        )
    return prisms


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
    sizes = grid_sizes(settings, scene.step)
    domain = make_domain(scene, settings, sizes)
    buckets = faces_around(scene, domain, sizes)
    roots = make_roots(domain, sizes, settings.max_cells)
    domain = np.stack((roots[:, 0].min(axis=0), roots[:, 1].max(axis=0)))
    context = (settings, sizes, scene.step)
    flood = reachable_voxels(buckets, domain, context)
    prisms = _free_cells(buckets, roots, flood, context, progress)
    contacts = open_contacts(find_contacts(prisms), buckets if sizes.clearance == 0 else None)
    chosen = np.flatnonzero(select_reachable(prisms, contacts, buckets, domain, context))
    order = chosen[spatial_order(prism_bounds(prisms[chosen]))]
    contacts, prisms = contacts.renumbered(order, len(prisms)), prisms[order]
    offsets, targets, polygons = portal_table(contacts, len(prisms))
    polygon_offsets, polygon_vertices = contacts.polygons()
    points = np.random.default_rng(settings.coverage_seed).integers(
        domain[0], domain[1], size=(settings.coverage_points, 3), endpoint=True
    )
    coverage = measure_coverage(prisms, buckets, flood, points, (sizes.clearance, settings.threads))
    _LOG.info("%d cells, %d portals, coverage %.4f", len(prisms), len(targets), coverage)
    bounds = prism_bounds(prisms)
    return CellComplex(
        lower=np.ascontiguousarray(bounds[:, 0]),
        upper=np.ascontiguousarray(bounds[:, 1]),
        kinds=cell_kinds(prisms, buckets, sizes.ground_height, settings.ground_slope),
        portal_offsets=offsets,
        portal_targets=targets,
        portal_polygons=polygons,
        clearance=sizes.clearance,
        coverage=coverage,
        polygon_offsets=polygon_offsets,
        polygon_vertices=polygon_vertices,
        corners=prism_corners(prisms),
    )
