"""Which free prisms become cells, of which kind, and in which order."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.buckets import FaceBuckets, boxes_with_faces
from tilesnav_ref.cells.coverage import locate_points
from tilesnav_ref.cells.domain import GridSizes
from tilesnav_ref.cells.meeting import prisms_with_faces
from tilesnav_ref.cells.mission import Mission, touches_top
from tilesnav_ref.cells.model import KIND_AERIAL, KIND_GROUND
from tilesnav_ref.cells.prisms import H0, H1, L0, L1, U0, U1, W0, W1, U, V, W, prism_bounds, prism_corners
from tilesnav_ref.cells.settings import CellError, CellSettings


def open_sky(boxes: NDArray[np.int64], buckets: FaceBuckets, clearance: int) -> NDArray[np.bool_]:
    """Which boxes (B, 2, 3) see no face in the column above them, inflated sideways by the clearance; (B,)
    bool."""
    columns = np.stack((boxes[:, 0] - clearance, boxes[:, 1] + clearance), axis=1)
    columns[:, 0, 2] = boxes[:, 1, 2]
    top = int(buckets.corners[:, :, 2].max()) + 1 if len(buckets.corners) else 0
    columns[:, 1, 2] = np.maximum(columns[:, 0, 2] + 1, top)
    return ~boxes_with_faces(buckets, columns)


def seed_points(settings: CellSettings, domain: NDArray[np.int64], step: float) -> NDArray[np.int64]:
    """Seeds of the settings, (S, 3) int64 on the grid.

    Raises
    ------
    CellError
        There is none, or one is not a point of the domain.
    """
    if len(settings.seeds) == 0:
        raise CellError("seeds is empty; allowed: 'sky' or one or more points")
    points = []
    for seed in settings.seeds:
        if len(seed) != 3 or not all(math.isfinite(float(value)) for value in seed):
            raise CellError(f"seed {seed}; allowed: three finite numbers, m")
        low, high = (domain * step).tolist()
        if not all(low[k] <= float(seed[k]) <= high[k] for k in range(3)):
            raise CellError(f"seed {seed} m is outside the domain; allowed: {low} to {high} m")
        points.append([round(float(value) / step) for value in seed])
    return np.clip(np.array(points, dtype=np.int64), domain[0], domain[1])


def free_seeds(
    buckets: FaceBuckets, domain: NDArray[np.int64], context: tuple[CellSettings, GridSizes, float]
) -> NDArray[np.int64]:
    """Seeds of the settings (S, 3), which no face is near to.

    Raises
    ------
    CellError
        There is none, one is not in the domain, or a face is near to one.
    """
    settings, sizes, step = context
    points = seed_points(settings, domain, step)
    reach = max(sizes.clearance, 1)
    near_face = boxes_with_faces(buckets, np.stack((points - reach, points + reach), axis=1))
    if np.any(near_face):
        seed = settings.seeds[int(np.argmax(near_face))]
        raise CellError(f"seed {seed} m: a face is within {reach * step} m of it; allowed: a free point")
    return points


def _seed_cells(
    prisms: NDArray[np.int64], points: NDArray[np.int64], context: tuple[CellSettings, GridSizes, float]
) -> NDArray[np.int64]:
    settings, sizes, step = context
    holders = locate_points(prisms, points)
    if np.any(holders < 0):
        seed = settings.seeds[int(np.argmax(holders < 0))]
        raise CellError(
            f"seed {seed} m is free, but no cell holds it; allowed: a point of a cell, or a min_size below "
            f"{sizes.min_size * step} m"
        )
    return holders


def line_seeds(mission: Mission, buckets: FaceBuckets, clearance: int) -> NDArray[np.int64]:
    """Points (P, 3) of the line of a corridor from which its space is reached: those that it was given by,
    and those between them that see no face above."""
    given, between = mission.line_points()
    if len(between) == 0:
        return given
    dots = np.stack((between - 1, between + 1), axis=1)
    return np.concatenate((given, between[open_sky(dots, buckets, clearance)]))


def _near_seeds(
    points: NDArray[np.int64], domain: NDArray[np.int64], settings: CellSettings
) -> NDArray[np.int64]:
    """Seeds (S, 3); for a sector alone, those of them in the part of the domain that is divided."""
    if settings.sector is None:
        return points
    return points[np.all((points >= domain[0]) & (points <= domain[1]), axis=1)]


def start_cells(
    prisms: NDArray[np.int64],
    mission: Mission,
    space: tuple[NDArray[np.int64], NDArray[np.int64]],
    buckets: FaceBuckets,
    context: tuple[CellSettings, GridSizes, float],
) -> NDArray[np.bool_]:
    """Prisms (C, 11) that are kept by themselves: all, those open to the sky, or those that hold a seed.

    ``space`` is the roots (R, 2, 3) and the whole domain (2, 3). A cell is open to the sky when its upper
    side is the upper end of the roots and no face is above it.

    Returns
    -------
    ndarray
        (C,) bool.

    Raises
    ------
    CellError
        No cell is open to the sky or holds a point of the corridor's line, or a seed is near a face, in no
        cell, or outside the domain.
    """
    settings, sizes, step = context
    roots, whole = space
    if settings.keep_interiors:
        return np.ones(len(prisms), np.bool_)
    starts = np.zeros(len(prisms), np.bool_)
    domain = np.stack((roots[:, 0].min(axis=0), roots[:, 1].max(axis=0)))
    if settings.seeds != "sky":
        seeds = _near_seeds(free_seeds(buckets, whole, context), domain, settings)
        starts[_seed_cells(prisms, seeds, context)] = True
    elif settings.mission == "corridor":
        holders = locate_points(prisms, line_seeds(mission, buckets, sizes.clearance))
        starts[holders[holders >= 0]] = True
        if not np.any(starts):
            raise CellError(
                f"no free space: no cell of {len(prisms)} holds a point of the corridor that is given or "
                "open to the sky; allowed: a line through free space, seeds, or keep_interiors"
            )
    else:
        bounds = prism_bounds(prisms)
        flat = np.all(prism_corners(prisms)[:, 4:, 2] == bounds[:, 1:, 2], axis=1)
        tops = np.flatnonzero(flat & touches_top(bounds, roots))
        starts[tops[open_sky(bounds[tops], buckets, sizes.clearance)]] = True
        if not np.any(starts):
            raise CellError(
                f"no free space: none of {len(prisms)} free cells touches the open sky at z = "
                f"{float(domain[1, 2]) * step} m; allowed: a higher altitude_max, seeds, or keep_interiors"
            )
    return starts


def _below(prisms: NDArray[np.int64], height: int) -> NDArray[np.int64]:
    """What lies straight below the lower side of each cell down to a height; (C, 11)."""
    below = prisms.copy()
    flat, slanted, run = prisms[:, W] == 2, prisms[:, V] == 2, prisms[:, U] == 2
    below[flat, W0], below[flat, W1] = prisms[flat, W0] - height, prisms[flat, W0]
    below[run, U0], below[run, U1] = prisms[run, U0] - height, prisms[run, U0]
    below[run, L1], below[run, H1] = prisms[run, L0], prisms[run, H0]
    for low, high in ((L0, H0), (L1, H1)):
        below[slanted, low], below[slanted, high] = prisms[slanted, low] - height, prisms[slanted, low]
    return below


def cell_kinds(
    prisms: NDArray[np.int64], buckets: FaceBuckets, ground_height: int, ground_slope: float
) -> NDArray[np.uint8]:
    """Kind of every cell.

    Parameters
    ----------
    prisms
        (C, 11) cells, grid.
    buckets
        Faces; their box must reach ground_height below the cells.
    ground_height
        Grid steps.
    ground_slope
        Rise over run.

    Returns
    -------
    ndarray
        (C,) uint8. KIND_GROUND when a face that is no steeper than ``ground_slope`` meets the interior of
        what lies straight below the cell's lower side, down to ``ground_height``; else KIND_AERIAL.

    Notes
    -----
    A mesh does not tell terrain from floors and flat roofs: cells on those are of kind ground too. What a
    ground vehicle reaches from the street follows from the portals between ground cells.
    """
    if len(prisms) == 0 or ground_height == 0 or len(buckets.corners) == 0:
        return np.full(len(prisms), KIND_AERIAL, np.uint8)
    edges = (buckets.corners[:, 1:] - buckets.corners[:, :1]).astype(np.float64)
    normals = np.cross(edges[:, 0], edges[:, 1])
    carries = np.hypot(normals[:, 0], normals[:, 1]) <= ground_slope * np.abs(normals[:, 2])
    on_ground = prisms_with_faces(buckets, _below(prisms, ground_height), 0, buckets.of_scene(carries))
    return np.where(on_ground, KIND_GROUND, KIND_AERIAL).astype(np.uint8)


def spatial_order(boxes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Order of boxes (B, 2, 3) along a Morton curve through their centres; (B,) int64.

    References
    ----------
    G. M. Morton, "A computer oriented geodetic data base and a new technique in file sequencing", IBM, 1966.
    """
    if len(boxes) == 0:
        return np.zeros(0, np.int64)
    # doubled centres fit 25 bits; 21 bits an axis fit one 64-bit code, so the lowest 4 only break ties
    centres = boxes[:, 0] + boxes[:, 1]
    centres = centres - centres.min(axis=0)
    code = np.zeros(len(boxes), np.uint64)
    for bit in range(21):
        for axis in range(3):
            value = (centres[:, axis] >> (bit + 4)) & 1
            code |= value.astype(np.uint64) << np.uint64(3 * bit + axis)
    return np.lexsort((centres[:, 2], centres[:, 1], centres[:, 0], code))
