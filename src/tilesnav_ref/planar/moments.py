"""Counts, means and covariances of the points of each feature, and the planes through them.

References
----------
T. F. Chan, G. H. Golub, R. J. LeVeque, "Algorithms for computing the sample variance", 1983 (two passes; the
sums of parts).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel


class Moments(NamedTuple):
    """Of K sets of points."""

    counts: NDArray[np.int64]
    means: NDArray[np.float64]
    """(K, 3) metres."""
    scatters: NDArray[np.float64]
    """(K, 3, 3) sums of products about the mean, square metres."""

    def covariances(self) -> NDArray[np.float64]:
        """(K, 3, 3) float64, divided by the counts."""
        return np.asarray(self.scatters / np.maximum(self.counts, 1)[:, None, None])

    def planes(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return least squares planes: normals (K, 3), offsets (K,), rms (K,) metres."""
        squares, axes = np.linalg.eigh(self.covariances())
        normals = upward(axes[:, :, 0])
        offsets = -np.einsum("ki,ki->k", normals, self.means)
        return normals, offsets, np.sqrt(np.maximum(squares[:, 0], 0.0))

    def joined(self, a: NDArray[np.int64], b: NDArray[np.int64]) -> Moments:
        """Moments of the unions of sets a[i] and b[i]."""
        counts = self.counts[a] + self.counts[b]
        share = (self.counts[b] / counts)[:, None]
        apart = self.means[b] - self.means[a]
        weight = (self.counts[a] * share[:, 0])[:, None, None]
        between = weight * apart[:, :, None] * apart[:, None, :]
        return Moments(counts, self.means[a] + share * apart, self.scatters[a] + self.scatters[b] + between)


def upward(normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Turn unit normals so that the last of z, y, x that is not zero is positive."""
    tiny = 1e-9  # an upright wall's z is rounding alone
    x, y, z = normals.T
    deciding = np.where(np.abs(z) > tiny, z, np.where(np.abs(y) > tiny, y, x))
    return np.asarray(np.where(deciding[:, None] < 0, -normals, normals))


def moments_of(points: NDArray[np.float64], labels: NDArray[np.int32], features: int) -> Moments:
    """Moments of the points that carry each label below `features`; negative labels are left out."""
    counts = np.zeros(features, np.int64)
    means, scatters = np.zeros((features, 3)), np.zeros((features, 3, 3))
    sum_moments(points, labels, counts, means, scatters)
    return Moments(counts, means, scatters)


@kernel
def sum_moments(
    points: NDArray[np.float64],
    labels: NDArray[np.int32],
    counts: NDArray[np.int64],
    means: NDArray[np.float64],
    scatters: NDArray[np.float64],
) -> None:
    """Write counts, means and sums of products about the means; the arrays are zero before."""
    for at in range(len(labels)):
        label = labels[at]
        if label >= 0:
            counts[label] += 1
            for i in range(3):
                means[label, i] += points[at, i]
    for label in range(len(counts)):
        for i in range(3):
            means[label, i] /= max(1, counts[label])
    for at in range(len(labels)):
        label = labels[at]
        if label >= 0:
            x = points[at, 0] - means[label, 0]
            y = points[at, 1] - means[label, 1]
            z = points[at, 2] - means[label, 2]
            scatters[label, 0, 0] += x * x
            scatters[label, 0, 1] += x * y
            scatters[label, 0, 2] += x * z
            scatters[label, 1, 1] += y * y
            scatters[label, 1, 2] += y * z
            scatters[label, 2, 2] += z * z
    for label in range(len(counts)):
        scatters[label, 1, 0] = scatters[label, 0, 1]
        scatters[label, 2, 0] = scatters[label, 0, 2]
        scatters[label, 2, 1] = scatters[label, 1, 2]
