"""What planar feature detection gives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NO_PLANE = -1
"""Label of a point that lies in no feature."""


@dataclass(frozen=True)
class Rectangles:
    """Extents of features: the smallest rectangle in the plane of each that holds its inliers.

    Attributes
    ----------
    centres : (K, 3) float64
        Metres, in the frame of the points, on the plane.
    axes : (K, 2, 3) float64
        Unit vectors along the longer and the shorter side; `cross(axes[k, 0], axes[k, 1])` is the normal.
    half_sizes : (K, 2) float64
        Metres, half of the longer and half of the shorter side.
    """

    centres: NDArray[np.float64]
    axes: NDArray[np.float64]
    half_sizes: NDArray[np.float64]

    def corners(self) -> NDArray[np.float64]:
        """(K, 4, 3) float64 corners, counter-clockwise seen from where the normal points to."""
        signs = np.array(((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)))
        steps = (signs * self.half_sizes[:, None, :])[..., None] * self.axes[:, None, :, :]
        return np.asarray(self.centres[:, None, :] + steps.sum(axis=2))


@dataclass(frozen=True)
class PlanarFeatures:
    """Connected planar patches of a point cloud, in order of falling point counts.

    Attributes
    ----------
    normals : (K, 3) float64
        Unit normals in the frame of the points. A cloud does not say which side is free, so the sign is a
        convention: the last of z, y, x that is not zero (above 1e-9) is positive, so roofs look up.
    offsets : (K,) float64
        Metres; ``normals[k] @ x + offsets[k] = 0`` on plane k.
    centroids : (K, 3) float64
        Means of the inliers, metres; on the plane up to rounding.
    covariances : (K, 3, 3) float64
        Covariance of the inliers about their centroid, square metres (division by the count). Its least
        eigenvalue is `rms` squared, with the normal as eigenvector.
    rms : (K,) float64
        Root mean square distance of the inliers from the plane, metres.
    counts : (K,) int64
        Inliers, 3 or more.
    extents : Rectangles
    labels : (N,) int32
        Feature of each point; `NO_PLANE` where there is none.
    inlier_distance : float
        Greatest distance of an inlier from its plane, metres.
    normal_deviation : float
        Standard deviation of the normals at points, as the noise of their neighbourhoods predicts it: the
        median, radians. A point joins a growing feature within four of its own.
    """

    normals: NDArray[np.float64]
    offsets: NDArray[np.float64]
    centroids: NDArray[np.float64]
    covariances: NDArray[np.float64]
    rms: NDArray[np.float64]
    counts: NDArray[np.int64]
    extents: Rectangles
    labels: NDArray[np.int32]
    inlier_distance: float
    normal_deviation: float

    def __len__(self) -> int:
        """Count of features."""
        return len(self.offsets)

    def distances(self, points: NDArray[np.float64], feature: int) -> NDArray[np.float64]:
        """(M,) float64 signed distances of (M, 3) points from a plane, metres."""
        return np.asarray(points @ self.normals[feature] + self.offsets[feature])
