"""How far local normals are from the normals of their features, in the two directions within the plane.

References
----------
The distribution is what a region growing stops by: at four of its standard deviations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tilesnav_ref.planar.model import PlanarFeatures

NEIGHBOURS = 32
"""Points of the same feature, itself counted, whose plane is the local one."""
ROUND = 0.1
"""Least ratio of the middle to the greatest spread (squares) of neighbours that have a plane; those on one
ring of a scanner have none."""
POINTS_SEARCHED = 400_000
"""Of features with more points in all, evenly chosen ones are looked at."""
POINTS_SHOWN = 40_000
"""Points whose local normal is taken, evenly chosen."""
LEVEL = 1e-3
"""Sine of the slope below which a plane has no direction that is level alone; x is taken then."""


@dataclass(frozen=True)
class Deviations:
    """Local normals against those of their features.

    Attributes
    ----------
    across : (M,) float64
        Component of the local unit normal along the level direction of its plane; for small angles the angle
        in radians.
    upwards : (M,) float64
        The same along the direction of steepest ascent of its plane.
    features : int
        Features that the points are of.
    """

    across: NDArray[np.float64]
    upwards: NDArray[np.float64]
    features: int

    @property
    def spread(self) -> tuple[float, float]:
        """Standard deviations of both, without what is farther than five robust ones from the median."""
        return _spread(self.across), _spread(self.upwards)


def normal_deviations(points: NDArray[np.float64], features: PlanarFeatures) -> Deviations:
    """Fit a plane to the neighbours of points of features, of the same feature, and compare the normals.

    Parameters
    ----------
    points : (N, 3) float64
        Metres; those that the features were found in.
    features : PlanarFeatures
    """
    counts = np.bincount(features.labels[features.labels >= 0], minlength=len(features))
    chosen = np.flatnonzero(counts >= NEIGHBOURS)
    # Evenly over the sizes, which features are ordered by; the ground alone would fill the picture.
    chosen = chosen[:: max(1, -(-int(counts[chosen].sum()) // POINTS_SEARCHED))]
    ours = np.flatnonzero(np.isin(features.labels, chosen))
    if not len(ours):
        return Deviations(np.zeros(0), np.zeros(0), 0)
    label = features.labels[ours]
    places = points[ours] - points[ours].mean(axis=0)
    # Features lie apart along a fourth axis by more than the cloud is long: neighbours are of one feature.
    apart = label[:, None] * (2.0 * float(np.ptp(places, axis=0).sum()) + 1.0)
    shown = np.arange(0, len(ours), max(1, len(ours) // POINTS_SHOWN))
    tree = cKDTree(np.concatenate((places, apart), axis=1))
    _, near = tree.query(np.concatenate((places[shown], apart[shown]), axis=1), k=NEIGHBOURS)
    away = places[near] - places[near].mean(axis=1, keepdims=True)
    sizes, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", away, away))
    wide = sizes[:, 1] >= ROUND * sizes[:, 2]
    local, normal = axes[wide, :, 0], features.normals[label[shown[wide]]]
    local *= np.where(np.einsum("ij,ij->i", local, normal) < 0.0, -1.0, 1.0)[:, None]
    level, steep = in_plane(normal)
    across, upwards = np.einsum("ij,ij->i", local, level), np.einsum("ij,ij->i", local, steep)
    return Deviations(across, upwards, len(np.unique(label[shown[wide]])))


def in_plane(normals: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(K, 3) level unit vectors and (K, 3) those of steepest ascent, in planes with unit normals (K, 3)."""
    level = np.cross((0.0, 0.0, 1.0), normals)
    length = np.linalg.norm(level, axis=1, keepdims=True)
    flat = length[:, 0] < LEVEL
    along_x = np.array((1.0, 0.0, 0.0)) - normals[:, :1] * normals
    level = np.where(flat[:, None], along_x, level)
    level /= np.linalg.norm(level, axis=1, keepdims=True)
    return level, np.cross(normals, level)


def _spread(values: NDArray[np.float64]) -> float:
    """Standard deviation of the middle of a distribution whose tails are corners and outliers."""
    if not len(values):
        return 0.0
    middle = float(np.median(values))
    robust = 1.4826 * float(np.median(np.abs(values - middle)))  # of a normal distribution's magnitudes
    kept = np.abs(values - middle) <= 5.0 * robust
    return float(values[kept].std())
