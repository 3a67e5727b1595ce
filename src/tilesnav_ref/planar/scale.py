"""Size of neighbourhoods and noise, from the cloud itself."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tilesnav_ref.planar.grid import make_grid
from tilesnav_ref.planar.local import fitted
from tilesnav_ref.planar.settings import PlaneSettings

NEIGHBOURS = 16
"""Points within the radius, for half of the points. Fewer make noisy normals, more hide narrow planes."""
SLABS = 4
SLAB_POINTS = 50_000
"""Points are looked at in slices across x, which hold the cloud in its full density."""
SPREAD = 0.05
"""Greatest standard deviation of normals, radians: what the source paper found on its cloud (0.05)."""
WIDER = 1.4
STEPS = 5
"""The radius is widened at most five times: by 5.4."""
LEAST_NOISE = 1.0 / 200
"""Least noise, in radii: points without any would leave no room for rounding."""
FLAT = 1.5
"""A neighbourhood is flat up to this many times the noise: 15 points on a plane are so in 99 of 100."""


class Scale(NamedTuple):
    """What lengths of the settings come to, metres and radians."""

    radius: float
    noise: float
    """Standard deviation of the distance of points from their plane."""
    spread: float
    """Standard deviation of local normals, median over flat neighbourhoods."""


def scale_of(points: NDArray[np.float64], settings: PlaneSettings, pool: ThreadPoolExecutor) -> Scale:
    """Measure a cloud as far as the settings do not say.

    Parameters
    ----------
    points : (N, 3) float64
        Metres, N at least `NEIGHBOURS`.
    settings : PlaneSettings
    pool : ThreadPoolExecutor
    """
    sample = _slabs(points)
    radius = settings.radius or _spacing(sample, settings.seed)
    for _ in range(STEPS):
        planes = fitted(make_grid(sample, radius), radius, pool)
        known = np.isfinite(planes.rms)
        rms, spread = planes.rms[known].astype(np.float64), planes.spread[known].astype(np.float64)
        noise = settings.inlier_distance / 4.0 or max(_mode(rms), LEAST_NOISE * radius)
        flat = rms <= FLAT * noise
        typical = float(np.median(spread[flat])) if flat.any() else 0.0
        if settings.radius or typical <= SPREAD:
            break
        radius *= WIDER
    return Scale(radius, noise, typical)


def _slabs(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """All points, or those of slices across x, evenly between the points."""
    if len(points) <= 2 * SLABS * SLAB_POINTS:
        return points
    x = points[:, 0]
    starts = np.linspace(0, len(points) - SLAB_POINTS - 1, 2 * SLABS + 1)[1::2].astype(np.int64)
    ends = starts + SLAB_POINTS
    places = np.partition(x, np.concatenate((starts, ends)))
    return np.concatenate(
        [points[(x >= places[start]) & (x < places[end])] for start, end in zip(starts, ends, strict=True)]
    )


def _spacing(points: NDArray[np.float64], seed: int) -> float:
    """Median distance of the sixteenth neighbour, metres; greater than 0."""
    tree = cKDTree(points, balanced_tree=False, compact_nodes=False)
    asked = np.random.default_rng(seed).choice(len(points), min(4000, len(points)), replace=False)
    away = tree.query(points[np.sort(asked)], k=NEIGHBOURS + 1)[0][:, -1]
    size = float(np.ptp(points, axis=0).max()) or 1.0
    return max(float(np.median(away)), 1e-6 * size)  # more than half of the points in one place


def _mode(values: NDArray[np.float64]) -> float:
    """Most frequent value, by the half-sample mode.

    The median would lie among trees where most of a cloud is trees; the mode stays with what is flat.

    References
    ----------
    T. Robertson, J. D. Cryer, "An iterative procedure for estimating the mode", JASA 69, 1974.
    """
    ordered = np.sort(values)
    while len(ordered) > 64:  # fewer points jump about
        half = (len(ordered) + 1) // 2
        widths = ordered[half - 1 :] - ordered[: len(ordered) - half + 1]
        start = int(np.argmin(widths))
        ordered = ordered[start : start + half]
    return float(np.mean(ordered)) if len(ordered) else 0.0
