"""Local planes at all points of a grid, on several threads."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from tilesnav_ref.planar.grid import Grid, slices_of
from tilesnav_ref.planar.normals import LocalPlanes, fit_cubes, sharpen_cubes
from tilesnav_ref.planar.sampling import sample_cubes

SLICES = 64
"""Parts of a grid that threads take one by one."""
NEAR_SIGMAS = 2.5
"""A point lies on a local plane within this many standard deviations (98.8 % of its points do); the distance
of inliers is wider, since there the plane is known well."""
FLAT_SIGMAS = 1.4
"""A plane of about 16 points is flat up to this rms: 99 % of those of true planes are."""


class Noise(NamedTuple):
    """What local planes are judged by."""

    radius: float
    """Metres."""
    sigma: float
    """Standard deviation of distances from a plane, metres."""
    seed: int


def over_cubes(
    pool: ThreadPoolExecutor, grid: Grid, kernel: Callable[..., None], fixed: Any, out: Any
) -> None:
    """Run a kernel on all cubes of a grid; it writes each point's results from what is fixed, so the number
    of threads does not matter."""
    work = [
        pool.submit(kernel, grid.points, grid.cubes, grid.runs, fixed, span, out)
        for span in slices_of(grid, SLICES)
    ]
    for part in work:
        part.result()


def fitted(grid: Grid, radius: float, pool: ThreadPoolExecutor) -> LocalPlanes:
    """Least squares planes of the neighbourhoods of all points."""
    planes = _empty(len(grid.points))
    over_cubes(pool, grid, fit_cubes, radius, planes)
    return planes


def local_planes(grid: Grid, noise: Noise, pool: ThreadPoolExecutor) -> LocalPlanes:
    """Planes that the points lie on: the flattest neighbourhood nearby or, where none is flat, the best of
    random samples."""
    rough = fitted(grid, noise.radius, pool)
    planes = _empty(len(grid.points))
    near = NEAR_SIGMAS * noise.sigma
    over_cubes(pool, grid, sharpen_cubes, (noise.radius, near), (rough, planes))
    fixed = (noise.radius, near, FLAT_SIGMAS * noise.sigma, noise.seed)
    over_cubes(pool, grid, sample_cubes, fixed, planes)
    return planes


def _empty(count: int) -> LocalPlanes:
    return LocalPlanes(np.zeros((count, 3), np.float32), *np.zeros((3, count), np.float32))
