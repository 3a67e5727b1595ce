"""Coverage of a mission, as a whole and by heights above the ground; see coverage.py for what is measured."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.buckets import FaceBuckets
from tilesnav_ref.cells.coverage import flood_from_points, locate_points, reachable_points
from tilesnav_ref.cells.domain import GridSizes
from tilesnav_ref.cells.driving import GroundMission
from tilesnav_ref.cells.flood import BLOCKED, CLEAR, REACHED, VoxelFlood, clear_voxels, spread
from tilesnav_ref.cells.mission import Mission
from tilesnav_ref.cells.model import HeightBand
from tilesnav_ref.cells.selection import free_seeds, line_seeds, open_sky
from tilesnav_ref.cells.settings import CellSettings
from tilesnav_ref.cells.unmeasured import unknown_voxels

HEIGHTS = (0.0, 5.0, 10.0, 20.0, 40.0, math.inf)
"""Borders of the bands, m: street level, first floors, eaves, roofs, and what is above them."""

_SAMPLES = 32
"""Most rounds of random points for a coverage: below one thirtieth of the domain, fewer points are used."""

Space = Mission | GroundMission
Context = tuple[CellSettings, GridSizes, float]


def measure_coverage(
    prisms: NDArray[np.int64],
    where: tuple[FaceBuckets, VoxelFlood],
    domain: NDArray[np.int64],
    mission: Space,
    context: Context,
) -> tuple[float, tuple[HeightBand, ...]]:
    """Share of the points a mission asks for that lie in a prism (C, 11), of those free and reachable.

    Parameters
    ----------
    prisms
        Cells.
    where
        Faces, and the voxels of the domain that are reached.
    domain
        (2, 3) grid.
    mission, context
        As for :func:`flood_space`.

    Returns
    -------
    coverage, bands
        0 to 1, 0 without a point; and the counts of every band that has points.
    """
    settings, sizes, step = context
    buckets, flood = where
    points = _draw_points(_asked(domain, settings, sizes), settings, mission)
    points = points[reachable_points(buckets, flood, points, (sizes.clearance, settings.threads))]
    covered = locate_points(prisms, points) >= 0
    heights = mission.heights(points) * step
    bands = []
    for lower, upper in pairwise(HEIGHTS):
        # what is below the lowest ground of its column (by the rounding of columns) counts as street level
        within = (heights >= lower if lower > 0.0 else np.ones(len(points), np.bool_)) & (heights < upper)
        if np.any(within):
            bands.append(HeightBand(lower, upper, int(within.sum()), int((within & covered).sum())))
    return (float(np.mean(covered)) if len(points) else 0.0), tuple(bands)


def _asked(domain: NDArray[np.int64], settings: CellSettings, sizes: GridSizes) -> NDArray[np.int64]:
    """The part (2, 3) of the domain whose coverage is asked for: all of it, or one sector."""
    if settings.sector is None:
        return domain
    asked, lower = domain.copy(), np.array(settings.sector) * sizes.sector
    asked[0, :2] = np.maximum(domain[0, :2], lower)
    asked[1, :2] = np.minimum(domain[1, :2], lower + sizes.sector)
    return asked


def flood_space(
    buckets: FaceBuckets,
    domains: tuple[NDArray[np.int64], NDArray[np.int64]],
    mission: Space,
    context: Context,
) -> VoxelFlood:
    """Voxels of the first domain (2, 3) that are reached from the sky, the seeds or the line of a corridor;
    all of them with interiors. Seeds are points of the second."""
    settings, sizes, _ = context
    domain, whole = domains
    flood = clear_voxels(buckets, domain, sizes.min_size // 4, sizes.clearance, settings.threads)
    states = flood.states
    states[unknown_voxels(flood, buckets.unknown)] = BLOCKED
    if settings.keep_interiors:
        states[states == CLEAR] = REACHED
    elif settings.seeds != "sky":
        flood_from_points(flood, buckets, free_seeds(buckets, whole, context), sizes.clearance)
    elif settings.mission == "corridor" and isinstance(mission, Mission):
        flood_from_points(flood, buckets, line_seeds(mission, buckets, sizes.clearance), sizes.clearance)
    else:
        tops = np.argwhere(states[:, :, -1] == CLEAR)
        starts = np.column_stack((tops, np.full(len(tops), states.shape[2] - 1)))
        columns = np.stack(
            (flood.origin + starts * flood.size, flood.origin + (starts + 1) * flood.size), axis=1
        )
        spread(states, starts[open_sky(columns, buckets, sizes.clearance)])
    return flood


def _draw_points(domain: NDArray[np.int64], settings: CellSettings, mission: Space) -> NDArray[np.int64]:
    """Random points (P, 3) of the domain that a mission asks for; about coverage_points, fewer where they are
    rare."""
    rng = np.random.default_rng(settings.coverage_seed)
    drawn, total = [], 0
    for _ in range(_SAMPLES):
        points = rng.integers(domain[0], domain[1], size=(settings.coverage_points, 3), endpoint=True)
        drawn.append(points[mission.holds(points)])
        total += len(drawn[-1])
        if total >= settings.coverage_points:
            break
    return np.concatenate(drawn)[: settings.coverage_points]
