"""The box that is decomposed, and its division into roots of at most the largest cell size."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.sectors import lattice_cuts
from tilesnav_ref.cells.settings import CellError, CellSettings
from tilesnav_ref.cells.terrain import Ground, find_ground, level_ground
from tilesnav_ref.scene.model import COORDINATE_LIMIT, Scene

AIRSPACE_TOP = 152.4
"""500 ft in metres: below it small unmanned aircraft may fly (14 CFR 107.51 allows 400 ft, the study's
airspace 500 ft)."""


@dataclass(frozen=True)
class GridSizes:
    """Lengths of the settings in grid steps."""

    min_size: int
    max_size: int
    clearance: int
    ground_height: int
    end_width: int
    """Least width of either end of a trapezoid."""
    sector: int = 0
    """Edge of a sector; 0: no sectors."""


END_SHARE = 32
"""A trapezoid may narrow to this part of the smallest edge, 6 cm of 2 m, or to four grid steps: far more than
the square grid step that a facet needs, and thin enough to follow a wall into a corner."""


def altitude_steps(settings: CellSettings, step: float) -> tuple[int, int]:
    """Both ends of the band of altitude in grid steps, rounded inwards: no cell is higher than asked for.

    Without ``altitude_max`` the upper end is `AIRSPACE_TOP`.
    """
    highest = AIRSPACE_TOP if settings.altitude_max is None else settings.altitude_max
    return math.ceil(settings.altitude_min / step), math.floor(highest / step)


def _check_lengths(settings: CellSettings, step: float) -> None:
    """Refuse lengths that have no place on the grid."""
    for name in (
        "min_size",
        "max_size",
        "voxel_size",
        "clearance",
        "ground_height",
        "ground_step",
        "altitude_min",
        "altitude_max",
        "sector_size",
    ):
        value = getattr(settings, name)
        if value is not None and abs(value) / step > COORDINATE_LIMIT - 1:
            raise CellError(
                f"{name} is {value} m; allowed: less than {COORDINATE_LIMIT * step:g} m, 2^23 grid steps"
            )


def grid_sizes(settings: CellSettings, step: float) -> GridSizes:
    """Lengths in grid steps; the clearance is rounded up, so that it is never less than asked for, and the
    height of ground cells down.

    Raises
    ------
    CellError
        The smallest cell is below two grid steps, or a length beyond the grid.
    """
    _check_lengths(settings, step)
    voxel = settings.method == "voxel"
    smallest, largest = (
        (settings.voxel_size, settings.voxel_size) if voxel else (settings.min_size, settings.max_size)
    )
    sizes = GridSizes(
        round(smallest / step),
        round(largest / step),
        math.ceil(settings.clearance / step),
        math.floor(settings.ground_height / step),
        max(round(smallest / step) // END_SHARE, 4),
        0 if settings.sector_size is None else round(settings.sector_size / step),
    )
    if sizes.min_size < 2:
        raise CellError(
            f"a smallest cell of {smallest} m is {sizes.min_size} grid steps; "
            f"allowed: 2 or more, {2 * step} m"
        )
    return sizes


def scene_ground(scene: Scene, settings: CellSettings) -> Ground:
    """The ground that altitudes count from.

    Raises
    ------
    CellError
        The scene is empty, or the region is outside of it.
    """
    corners = scene.corners()
    plan = np.stack(_horizontal_bounds(corners, settings, scene.step))
    if settings.altitude_above == "lowest":
        return level_ground(corners, plan)
    return find_ground(corners, plan, scene.step, scene.terrain)


def _horizontal_bounds(
    corners: NDArray[np.int64], settings: CellSettings, step: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    if len(corners) == 0:
        raise CellError("the scene has no face; allowed: 1 or more")
    low, high = corners.min(axis=(0, 1))[:2], corners.max(axis=(0, 1))[:2]
    if settings.region is None:
        return low, high
    if not all(math.isfinite(value) and abs(value) < COORDINATE_LIMIT * step for value in settings.region):
        raise CellError(
            f"region {settings.region} m; allowed: finite numbers below {COORDINATE_LIMIT * step} m "
            "in magnitude"
        )
    region = np.array([round(value / step) for value in settings.region], dtype=np.int64)
    found = f"region {settings.region} m"
    if np.any(region[2:] <= region[:2]):
        raise CellError(f"{found}: x0 < x1 and y0 < y1 are needed")
    if np.any(region[2:] <= low) or np.any(region[:2] >= high):
        scene_bounds = tuple(float(value) * step for value in np.concatenate((low, high)))
        raise CellError(f"{found} is outside the scene; allowed: a region that meets {scene_bounds} m")
    return region[:2], region[2:]


def _vertical_bounds(highest: int, ground: Ground, settings: CellSettings, step: float) -> tuple[int, int]:
    lowest_ground, highest_ground = int(ground.low.min()), int(ground.low.max())
    altitude_min, altitude_max = altitude_steps(settings, step)
    top = highest_ground + altitude_max
    if settings.altitude_max is None:
        above = round(settings.max_size / step)  # also for voxels, so that methods share one domain
        top = min(top, highest + above)
    if highest_ground + altitude_min >= top:
        raise CellError(
            f"altitude_min is {settings.altitude_min} m and the upper end {(top - highest_ground) * step} m "
            "above the ground; allowed: altitude_min below the upper end"
        )
    return lowest_ground + altitude_min, top


def make_domain(scene: Scene, settings: CellSettings, sizes: GridSizes, ground: Ground) -> NDArray[np.int64]:
    """Lower and upper corner of the box in which cells may lie.

    Returns
    -------
    ndarray
        (2, 3) int64, grid coordinates.

    Raises
    ------
    CellError
        The scene is empty, the region is outside of it, or the box is thinner than a cell or leaves the grid.
    """
    corners = scene.corners()
    low, high = _horizontal_bounds(corners, settings, scene.step)
    inside = np.all((corners[:, :, :2].max(axis=1) >= low) & (corners[:, :, :2].min(axis=1) <= high), axis=1)
    chosen = corners[inside] if np.any(inside) else corners
    bottom, top = _vertical_bounds(int(chosen[:, :, 2].max()), ground, settings, scene.step)
    domain = np.array([[*low, bottom], [*high, top]], dtype=np.int64)
    thin = np.flatnonzero(domain[1] - domain[0] < sizes.min_size)
    if len(thin):
        axis, extent = "xyz"[thin[0]], float((domain[1] - domain[0])[thin[0]]) * scene.step
        raise CellError(
            f"no free space: the domain is {extent} m along {axis}; allowed: at least one cell, "
            f"{sizes.min_size * scene.step} m"
        )
    if np.any(np.abs(domain) >= COORDINATE_LIMIT):
        raise CellError(
            f"the domain {(domain * scene.step).tolist()} m leaves the grid; allowed: below "
            f"{COORDINATE_LIMIT * scene.step} m in magnitude"
        )
    return domain


def _cuts(low: int, high: int, sizes: GridSizes) -> NDArray[np.int64]:
    """Places that divide one axis into pieces of max_size; the last two share what is left."""
    cuts = np.append(np.arange(low, high, sizes.max_size, dtype=np.int64), np.int64(high))
    if len(cuts) > 2 and cuts[-1] - cuts[-2] < sizes.min_size:
        middle = (cuts[-3] + cuts[-1]) >> 1
        if middle - cuts[-3] >= sizes.min_size and cuts[-1] - middle >= sizes.min_size:
            cuts[-2] = middle
        else:
            cuts = cuts[:-1]  # too thin a strip to share, as with voxels: the domain ends before it
    return cuts


def _all_cuts(low: int, high: int, sizes: GridSizes, axis: int) -> NDArray[np.int64]:
    """The cuts of one axis; x and y are cut at the borders of sectors, and then each sector by itself."""
    if sizes.sector == 0 or axis == 2:
        return _cuts(low, high, sizes)
    borders = lattice_cuts(low, high, sizes.sector)
    parts = [_cuts(int(a), int(b), sizes) for a, b in pairwise(borders)]
    return np.unique(np.concatenate((*parts, borders)))


def make_roots(domain: NDArray[np.int64], sizes: GridSizes, limit: int) -> NDArray[np.int64]:
    """Divide the domain into boxes of at most max_size, none across the border of a sector.

    Returns
    -------
    ndarray
        (R, 2, 3) int64 grid coordinates, x outermost.

    Raises
    ------
    CellError
        There are more boxes than the limit.
    """
    axes = [_all_cuts(int(domain[0, k]), int(domain[1, k]), sizes, k) for k in range(3)]
    count = math.prod(len(cuts) - 1 for cuts in axes)
    if count > limit:
        raise CellError(f"too many cells: max_size divides the domain into {count} boxes; allowed: {limit}")
    lower = np.stack(np.meshgrid(*(cuts[:-1] for cuts in axes), indexing="ij"), axis=-1).reshape(-1, 3)
    upper = np.stack(np.meshgrid(*(cuts[1:] for cuts in axes), indexing="ij"), axis=-1).reshape(-1, 3)
    return np.stack((lower, upper), axis=1)
