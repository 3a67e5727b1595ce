"""Creases: the lines where neighbouring planes meet, and which of them borders of outlines belong to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from tilesnav_ref.planar.mesh_settings import MeshSettings
from tilesnav_ref.planar.model import PlanarFeatures
from tilesnav_ref.planar.outline import Outline

FREE = -1
"""Label of a place on a border that is near no crease."""
_CORNER_DETERMINANT = 0.05
"""Three planes whose normals span less volume meet nowhere in particular: 1 cm of noise moves the point by
20 cm or more."""


@dataclass(frozen=True)
class Crease:
    """The line where two planes meet."""

    origin: NDArray[np.float64]
    """(3,) metres."""
    direction: NDArray[np.float64]
    """(3,) unit vector."""

    def places(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N,) places on the line of the feet of points (N, 3), metres from the origin."""
        return np.asarray((points - self.origin) @ self.direction)

    def points(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) points at places (N,)."""
        return np.asarray(self.origin + places[:, None] * self.direction)


class Creases:
    """Creases of all pairs of features that come near each other."""

    def __init__(self, features: PlanarFeatures, outlines: list[Outline], settings: MeshSettings) -> None:
        self._features = features
        self._outlines = outlines
        self.reach = np.array(
            [
                min(settings.reach * outline.spacing + features.inlier_distance, settings.reach_max)
                for outline in outlines
            ]
        )
        """(K,) distance over which the border of each feature is drawn to a crease, metres."""
        self._least_sine = float(np.sin(settings.least_angle))
        self._near = _neighbours(outlines, float(self.reach.max()) if len(outlines) else 0.0)
        self._lines: dict[tuple[int, int], Crease] = {}

    def has_line(self, first: int, second: int) -> bool:
        """Whether two planes are steep enough to each other for a crease."""
        normals = self._features.normals
        return bool(np.linalg.norm(np.cross(normals[first], normals[second])) >= self._least_sine)

    def line(self, first: int, second: int) -> Crease:
        """The crease of two features, the same for either order."""
        pair = (min(first, second), max(first, second))
        if pair not in self._lines:
            self._lines[pair] = self._intersect(*pair)
        return self._lines[pair]

    def corner(self, first: int, second: int, third: int) -> NDArray[np.float64] | None:
        """Point (3,) of three planes; None where they have none that is well defined."""
        chosen = sorted((first, second, third))
        normals = self._features.normals[chosen]
        if abs(np.linalg.det(normals)) < _CORNER_DETERMINANT:
            return None
        # from a point nearby, because offsets of planes are large where coordinates are
        near = self._features.centroids[chosen[0]]
        rest = -(normals @ near + self._features.offsets[chosen])
        return np.asarray(near + np.linalg.solve(normals, rest))

    def label(self, feature: int, border: NDArray[np.float64]) -> NDArray[np.int64]:
        """Neighbour to whose crease each point of a border belongs, or `FREE`.

        Parameters
        ----------
        feature : int
            Whose border it is.
        border : (N, 3) float64
            Points on its plane, metres.

        Returns
        -------
        (N,) int64
            The neighbour whose crease is nearest; within reach, and with the neighbour's outline in reach of
            the foot on the crease.
        """
        labels = np.full(len(border), FREE, np.int64)
        best = np.full(len(border), np.inf)
        for other in self._near[feature]:
            if not self.has_line(feature, other):
                continue
            sine = np.linalg.norm(np.cross(self._features.normals[feature], self._features.normals[other]))
            reach = max(self.reach[feature], self.reach[other])
            distance = np.abs(self._features.distances(border, other)) / sine
            asked = np.flatnonzero((distance <= reach) & (distance < best))
            line = self.line(feature, other)
            feet = self._outlines[other].frame.flat(line.points(line.places(border[asked])))
            met = shapely.distance(shapely.points(feet), self._outlines[other].shape) <= reach
            labels[asked[met]], best[asked[met]] = other, distance[asked[met]]
        return labels

    def _intersect(self, first: int, second: int) -> Crease:
        normals = self._features.normals[[first, second]]
        direction = np.cross(normals[0], normals[1])
        direction /= np.linalg.norm(direction)
        near = self._features.centroids[first]
        rest = -(normals @ near + self._features.offsets[[first, second]])
        origin = near + np.linalg.solve(np.vstack((normals, direction)), np.append(rest, 0.0))
        return Crease(origin, direction)


def _neighbours(outlines: list[Outline], reach: float) -> list[NDArray[np.int64]]:
    """Features that have inliers in the same cube of the reach or in one beside it, for each; ascending."""
    if not outlines:
        return []
    owner = np.repeat(np.arange(len(outlines)), [len(outline.samples) for outline in outlines])
    cubes = np.floor(np.concatenate([outline.samples for outline in outlines]) / reach).astype(np.int64)
    cubes -= cubes.min(axis=0) - 1
    extent = cubes.max(axis=0) + 2
    codes = (cubes[:, 0] * extent[1] + cubes[:, 1]) * extent[2] + cubes[:, 2]
    places = np.unique(np.column_stack((codes, owner)), axis=0)
    pairs = []
    for shift in np.ndindex(3, 3, 3):
        step = ((shift[0] - 1) * extent[1] + shift[1] - 1) * extent[2] + shift[2] - 1
        first = np.searchsorted(places[:, 0], places[:, 0] + step, "left")
        last = np.searchsorted(places[:, 0], places[:, 0] + step, "right")
        counts = last - first
        starts = np.repeat(first - np.cumsum(counts) + counts, counts) + np.arange(counts.sum())
        pairs.append(np.unique(np.column_stack((np.repeat(places[:, 1], counts), places[starts, 1])), axis=0))
    met = np.unique(np.concatenate(pairs), axis=0)
    met = met[met[:, 0] != met[:, 1]]
    borders = np.searchsorted(met[:, 0], np.arange(len(outlines) + 1))
    return [met[borders[k] : borders[k + 1], 1] for k in range(len(outlines))]
