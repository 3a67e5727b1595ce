"""The smallest rectangle around the points of each feature."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from tilesnav_ref.planar.model import Rectangles


def rectangles(
    points: NDArray[np.float64],
    labels: NDArray[np.int32],
    normals: NDArray[np.float64],
    origin: NDArray[np.float64],
) -> Rectangles:
    """Rectangles of least area in the planes of the features.

    Parameters
    ----------
    points : (N, 3) float64
        Metres.
    labels : (N,) int32
        From 0 to K - 1, or negative.
    normals, origin : (K, 3) float64
        A unit normal and a point on the plane of each feature.

    References
    ----------
    H. Freeman, R. Shapira, "Determining the minimum-area encasing rectangle", CACM 18, 1975: one side lies on
    a side of the convex hull.
    """
    order = np.argsort(labels, kind="stable")
    ends = np.searchsorted(labels[order], np.arange(len(normals) + 1))
    found = [
        _rectangle(points[order[a:b]] - middle, normal)
        for a, b, middle, normal in zip(ends[:-1], ends[1:], origin, normals, strict=True)
    ]
    centres = np.array([one[0] for one in found]).reshape(-1, 3) + origin
    axes = np.array([one[1] for one in found]).reshape(-1, 2, 3)
    return Rectangles(centres, axes, np.array([one[2] for one in found]).reshape(-1, 2))


def _rectangle(
    points: NDArray[np.float64], normal: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Centre, axes and half sizes, for points about a point on the plane."""
    u = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    flat = points @ np.stack((u, v), axis=1)
    hull = flat[_hull(flat)]
    sides = np.roll(hull, -1, axis=0) - hull
    lengths = np.hypot(*sides.T)
    cos, sin = (sides[lengths > 0] / lengths[lengths > 0, None]).T if lengths.any() else np.eye(2)[:, :1]
    along, across = (
        np.outer(cos, hull[:, 0]) + np.outer(sin, hull[:, 1]),
        (np.outer(cos, hull[:, 1]) - np.outer(sin, hull[:, 0])),
    )
    sizes = np.stack((np.ptp(along, axis=1), np.ptp(across, axis=1)), axis=1)
    best = int(np.argmin(sizes.prod(axis=1)))
    middle = [(part[best].min() + part[best].max()) / 2 for part in (along, across)]
    first, second = cos[best] * u + sin[best] * v, cos[best] * v - sin[best] * u
    centre = middle[0] * first + middle[1] * second
    if sizes[best, 0] < sizes[best, 1]:
        first, second = second, -first
    return centre, np.stack((first, second)), np.sort(sizes[best] / 2)[::-1]


def _hull(flat: NDArray[np.float64]) -> NDArray[np.int64]:
    """Corners of the convex hull; the two ends where the points are on a line."""
    try:
        return np.asarray(ConvexHull(flat).vertices, np.int64)
    except QhullError:
        along = flat @ (flat[np.argmax(np.hypot(*(flat - flat[0]).T))] - flat[0])
        return np.array((np.argmin(along), np.argmax(along)))
