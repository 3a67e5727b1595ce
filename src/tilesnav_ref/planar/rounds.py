"""Rounds of growing, joining and assigning."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.planar.assignment import Choice, Limits, assign_cubes
from tilesnav_ref.planar.grid import Grid, cube_of_point, make_grid
from tilesnav_ref.planar.growth import Cloud, Rules, grow_all
from tilesnav_ref.planar.local import FLAT_SIGMAS, Noise, local_planes, over_cubes
from tilesnav_ref.planar.merging import TOUCHING, merged, pairs_of, touching_cubes
from tilesnav_ref.planar.model import NO_PLANE
from tilesnav_ref.planar.moments import moments_of
from tilesnav_ref.planar.normals import LocalPlanes
from tilesnav_ref.planar.scale import Scale
from tilesnav_ref.planar.settings import FEWEST_POINTS, PlaneSettings
from tilesnav_ref.planar.solidity import loose_cubes, solid

GROWN_SIGMAS = 1.6
"""Greatest rms of a grown feature. Points spread evenly over the distance of inliers, as in foliage, have
2.3; those of a plane 1, and a little more where edges of neighbours join."""
WIDEST = np.radians(30.0)
"""Greatest angle at which a normal still speaks for a plane, whatever its deviation."""
ANY = np.pi / 2
LEAST_SPREAD = 1e-3
"""Least standard deviation of a local normal, radians. Points without noise, as sampled from a model, have
none, and angles are measured by it; float32 normals are exact to a ten thousandth of it."""
FRAGMENT = 40
"""Features with fewer than 40 times the fewest points are joined across gaps of two radii as well."""


class Again(NamedTuple):
    """A round with the points that are left."""

    factor: float
    """Radius, in that of the first round: what is narrow or sparse has its neighbours farther away."""
    widest: float
    """Greatest angle of a normal that may join, radians; with `ANY` all may."""
    release: int
    """Features with fewer than this many times the fewest points are taken apart before: alone, with what
    is around them known, their points show their plane better."""


AGAIN = (Again(1.5, WIDEST, 4), Again(2.0, ANY, 10))
"""Along a strip as narrow as the radius, local planes of the first round are those of its neighbours; the
second finds its parts. The third joins what lies between them by the distance alone, which does no harm where
all that is greater has been taken."""


class Rounds:
    """Features of a grid of points while they are being found.

    Attributes
    ----------
    labels : (N,) int32
        In the order of the grid.
    """

    def __init__(self, grid: Grid, scale: Scale, settings: PlaneSettings, pool: ThreadPoolExecutor) -> None:
        self._grid = grid
        self._scale = scale
        self._settings = settings
        self._pool = pool
        self._count = 0
        self._planes: LocalPlanes
        self.labels = np.full(len(grid.points), NO_PLANE, np.int32)

    def first(self) -> None:
        """Grow from all points."""
        self._planes = self._local(self._grid, self._scale.radius)
        self.labels = self._grow(self._grid, self._planes, self._scale.radius, WIDEST)
        self._join()
        self._assign()

    def again(self, rule: Again) -> None:
        """Grow from what is left, and from what was taken by small features."""
        self._drop(rule.release * self._settings.min_points)
        left = np.flatnonzero(self.labels < 0)
        if len(left) < FEWEST_POINTS:
            return
        radius = rule.factor * self._scale.radius
        grid = make_grid(self._grid.points[left], radius)
        planes = self._local(grid, radius)
        back = left[grid.order]
        self.labels[back] = self._grow(grid, planes, radius, rule.widest)
        for mine, new in zip(self._planes, planes, strict=True):
            mine[back] = new
        self._join()
        self._join_fragments()
        self._assign()

    def settle(self) -> None:
        """Join, leave out what is no surface, and assign."""
        self._join()
        self._drop_loose()
        self._assign()
        self._drop(self._settings.min_points)

    def _local(self, grid: Grid, radius: float) -> LocalPlanes:
        planes = local_planes(grid, Noise(radius, self._scale.noise, self._settings.seed), self._pool)
        np.maximum(planes.spread, np.float32(LEAST_SPREAD), out=planes.spread)
        return planes

    def _grow(self, grid: Grid, planes: LocalPlanes, radius: float, widest: float) -> NDArray[np.int32]:
        noise = self._scale.noise
        size = len(grid.points)
        labels = np.full(size, NO_PLANE, np.int32)
        angles = np.minimum(self._settings.normal_sigmas * planes.spread, widest)
        if widest >= ANY:
            angles.fill(ANY)
        cosines = np.cos(angles).astype(np.float32)
        cloud = Cloud(grid.points, cube_of_point(grid), grid.runs, *planes[:3], cosines, labels)
        # two thirds: a feature may gain the points on its edges later
        rules = Rules(radius, 4.0 * noise, GROWN_SIGMAS * noise, self._settings.min_points * 2 // 3)
        queue = np.empty(size, np.int32)
        self._count = int(grow_all(cloud, rules, _seeds(planes.rms, noise), queue, self._count))
        labels[labels < 0] = NO_PLANE
        return labels

    def _join(self) -> None:
        """Join features that touch within the radius."""
        self._joined(self._pairs(self._grid, self.labels, self._scale.radius))

    def _join_fragments(self) -> None:
        """Join small features across gaps of two radii: points are few along a narrow plane."""
        if not self._count:
            return
        counts = np.bincount(self.labels[self.labels >= 0], minlength=self._count)
        small = (self.labels >= 0) & (counts < FRAGMENT * self._settings.min_points)[self.labels]
        members = np.flatnonzero(small)
        if len(members):
            radius = 2.0 * self._scale.radius
            grid = make_grid(self._grid.points[members], radius)
            self._joined(self._pairs(grid, self.labels[members[grid.order]], radius))

    def _pairs(self, grid: Grid, labels: NDArray[np.int32], radius: float) -> NDArray[np.int64]:
        found = np.empty((len(labels), TOUCHING), np.int32)
        over_cubes(self._pool, grid, touching_cubes, radius, (labels, found))
        return pairs_of(labels, found)

    def _joined(self, pairs: NDArray[np.int64]) -> None:
        if not len(pairs):
            return
        moments = moments_of(self._grid.points, self.labels, self._count)
        self._renumber(merged(moments, pairs, FLAT_SIGMAS * self._scale.noise))

    def _assign(self) -> None:
        """Give each point to the plane that explains it best, and drop features that are left too small."""
        out = np.empty_like(self.labels)
        noise = self._scale.noise
        limits = Limits(self._scale.radius, 4.0 * noise, noise, FLAT_SIGMAS * noise)
        choice = self._choice(out)
        over_cubes(self._pool, self._grid, assign_cubes, limits, choice)
        self.labels = out
        self._drop(self._settings.min_points * 2 // 3)

    def _drop_loose(self) -> None:
        """Leave out features with loose points on both sides."""
        choice = self._choice(self.labels)
        found = np.zeros((len(self.labels), 3), np.uint16)
        limits = (self._scale.radius, 4.0 * self._scale.noise)
        over_cubes(self._pool, self._grid, loose_cubes, limits, (choice, found))
        keep = solid(self.labels, found, self._count)
        self._renumber(np.where(keep, np.cumsum(keep) - 1, NO_PLANE).astype(np.int32))

    def _choice(self, out: NDArray[np.int32]) -> Choice:
        normals, offsets, _ = moments_of(self._grid.points, self.labels, self._count).planes()
        local = self._planes
        return Choice(normals, offsets, local.normals, local.rms, local.spread, self.labels, out)

    def _drop(self, fewest: int) -> None:
        counts = np.bincount(self.labels[self.labels >= 0], minlength=self._count)
        keep = counts >= fewest
        self._renumber(np.where(keep, np.cumsum(keep) - 1, NO_PLANE).astype(np.int32))

    def _renumber(self, new: NDArray[np.int32]) -> None:
        """Give features new numbers; negative ones go."""
        self._count = int(new.max(initial=-1)) + 1
        lookup = np.append(new, np.int32(NO_PLANE))  # the last one is for points without a feature
        self.labels = lookup[self.labels]


def _seeds(rms: NDArray[np.float32], noise: float) -> NDArray[np.int32]:
    """Points in the order of their flatness, in 250 steps; those without a plane last."""
    steps = np.minimum(rms / np.float32(noise) * 50.0, 255.0).astype(np.uint8)
    return np.argsort(steps, kind="stable").astype(np.int32)
