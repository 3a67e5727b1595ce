"""Distances of points and triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def to_triangles(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """Distances of points from a triangle, row by row.

    Parameters
    ----------
    points : ndarray of float64, shape (n, k, 3)
    triangles : ndarray of float64, shape (n, 3, 3)
        May be without area.

    Returns
    -------
    ndarray of float64, shape (n, k)

    Notes
    -----
    The nearest point is the foot of the perpendicular where that is in the triangle, and else on a side; so
    the least of the distances from the sides, and from the foot where it counts, is the distance.
    """
    a, b, c = (triangles[:, None, i] for i in range(3))
    least = np.minimum(_to_segments(points, a, b), _to_segments(points, b, c))
    least = np.minimum(least, _to_segments(points, c, a))
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=2)
    inside = np.broadcast_to(size > 0, least.shape)
    for start, end in ((a, b), (b, c), (c, a)):
        inside = inside & ((np.cross(end - start, points - start) * normal).sum(axis=2) >= 0)
    height = np.abs(((points - a) * normal).sum(axis=2)) / np.where(size > 0, size, 1)
    return np.where(inside, np.minimum(height, least), least)


def _to_segments(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    along = end - start
    square = (along * along).sum(axis=2)
    share = ((points - start) * along).sum(axis=2) / np.where(square > 0, square, 1)
    nearest = start + np.clip(share, 0, 1)[..., None] * along
    return np.asarray(np.linalg.norm(points - nearest, axis=2))
