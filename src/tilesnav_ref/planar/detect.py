"""Planar features of a point cloud."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.planar.extents import rectangles
from tilesnav_ref.planar.grid import make_grid
from tilesnav_ref.planar.model import NO_PLANE, PlanarFeatures
from tilesnav_ref.planar.moments import moments_of
from tilesnav_ref.planar.rounds import AGAIN, Rounds
from tilesnav_ref.planar.scale import NEIGHBOURS, Scale, scale_of
from tilesnav_ref.planar.settings import PlaneSettings
from tilesnav_ref.planar.thinning import CROWDED, crowding, representatives
from tilesnav_ref.processors import thread_count

Progress = Callable[[str, int, int], None]

NOTHING_FLAT = 0.2
"""Noise, in radii, from which on no neighbourhood is flat: points spread evenly in space have 0.3, those with
normals that deviate by 0.05 radians 0.1."""
STEPS = 4 + len(AGAIN)


def detect_planes(
    points: NDArray[np.float64], settings: PlaneSettings | None = None, progress: Progress | None = None
) -> PlanarFeatures:
    """Find connected planar patches.

    Parameters
    ----------
    points : (N, 3) float64
        Metres, finite; any frame.
    settings : PlaneSettings
    progress : callable
        Called with "planes", steps done and steps in all.

    Returns
    -------
    PlanarFeatures
        In the frame of the points.

    Raises
    ------
    ValueError
        When the points have another shape or are not finite.

    Notes
    -----
    1. Radius and noise are measured. 2. Each point takes the flattest neighbourhood that it lies on, or the
    best of random samples of three neighbours. 3. Features grow from the flattest points over neighbours
    that are near the plane and have its normal; the plane follows. 4. Parts of one plane are joined. 5. Each
    point goes to the plane nearby that explains it best. 6. Points left over go through 2 to 5 again, with
    greater radii. 7. Least squares planes in float64.
    """
    settings = settings or PlaneSettings()
    _check(points)
    show = progress or (lambda *_: None)
    show("planes", 0, STEPS)
    labels = np.full(len(points), NO_PLANE, np.int32)
    scale = Scale(settings.radius, settings.inlier_distance / 4.0, 0.0)
    if len(points) >= max(settings.min_points, NEIGHBOURS):
        middle = points.mean(axis=0)
        with ThreadPoolExecutor(thread_count(settings.threads)) as pool:
            labels, scale = _labels(points - middle, settings, pool, show)
    features = _measured(points, labels, scale)
    show("planes", STEPS, STEPS)
    return features


def _check(points: NDArray[np.float64]) -> None:
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"points: found the shape {points.shape}; allowed: (N, 3)")
    if len(points) >= 1 << 31:
        raise ValueError(f"points: found {len(points)}; allowed: fewer than 2**31")
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        at = int(np.argmin(finite))
        raise ValueError(f"point {at}: found {points[at].tolist()}; allowed: finite coordinates")


def _labels(
    points: NDArray[np.float64], settings: PlaneSettings, pool: ThreadPoolExecutor, show: Progress
) -> tuple[NDArray[np.int32], Scale]:
    scale = scale_of(points, settings, pool)
    if scale.noise > NOTHING_FLAT * scale.radius:
        return np.full(len(points), NO_PLANE, np.int32), scale
    grid = make_grid(points, scale.radius)
    place = None
    if crowding(grid) > CROWDED:
        chosen, place = representatives(points, scale.radius)
        grid = make_grid(points[chosen], scale.radius)
    show("planes", 1, STEPS)
    rounds = Rounds(grid, scale, settings, pool)
    rounds.first()
    for number, rule in enumerate(AGAIN):
        show("planes", 2 + number, STEPS)
        rounds.again(rule)
    rounds.settle()
    show("planes", STEPS - 1, STEPS)
    labels = np.empty(len(grid.points), np.int32)
    labels[grid.order] = rounds.labels
    if place is not None:
        labels = _given(points, labels[place], 4.0 * scale.noise)
    return labels, scale


def _given(points: NDArray[np.float64], labels: NDArray[np.int32], distance: float) -> NDArray[np.int32]:
    """Labels of representatives given to all their points that are near the plane."""
    moments = moments_of(points, labels, int(labels.max(initial=-1)) + 1)
    normals, offsets, _ = moments.planes()
    has = np.flatnonzero(labels >= 0)
    away = np.einsum("ni,ni->n", points[has], normals[labels[has]]) + offsets[labels[has]]
    near = labels.copy()
    near[has[np.abs(away) > distance]] = NO_PLANE
    return near


def _measured(points: NDArray[np.float64], labels: NDArray[np.int32], scale: Scale) -> PlanarFeatures:
    """Planes through the points of each label, greatest first."""
    counts = np.bincount(labels[labels >= 0])
    rank = np.empty(len(counts), np.int32)
    rank[np.argsort(-counts, kind="stable")] = np.arange(len(counts))
    labels = np.where(labels >= 0, rank[labels] if len(rank) else NO_PLANE, NO_PLANE).astype(np.int32)
    moments = moments_of(points, labels, len(counts))
    normals, offsets, rms = moments.planes()
    return PlanarFeatures(
        normals=normals,
        offsets=offsets,
        centroids=moments.means,
        covariances=moments.covariances(),
        rms=rms,
        counts=moments.counts,
        extents=rectangles(points, labels, normals, moments.means),
        labels=labels,
        inlier_distance=4.0 * scale.noise,
        normal_deviation=scale.spread,
    )
