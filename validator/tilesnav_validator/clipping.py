"""Clipping many convex polygons by half-spaces at once (Sutherland and Hodgman 1974)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def clip(corners: FloatArray, count: IntArray, planes: FloatArray) -> tuple[FloatArray, IntArray]:
    """Clip each polygon by one half-space.

    Parameters
    ----------
    corners : ndarray of float64, shape (k, q, 3)
        Corners in order; those from ``count`` on are not looked at.
    count : ndarray of int64, shape (k,)
        Number of corners; 0 for what has been clipped away.
    planes : ndarray of float64, shape (k, 4)
        What remains has ``n.x + d <= 0``.

    Returns
    -------
    corners : ndarray of float64, shape (k, q + 1, 3)
    count : ndarray of int64, shape (k,)

    Notes
    -----
    A convex polygon gains at most one corner. Segments and points, given as polygons with repeated corners,
    are clipped alike.
    """
    k, q = corners.shape[:2]
    index = np.arange(q)
    valid = index < count[:, None]
    following = np.where(index + 1 < count[:, None], index + 1, 0)
    height = np.einsum("kqi,ki->kq", corners, planes[:, :3]) + planes[:, 3:]
    next_height = np.take_along_axis(height, following, axis=1)
    next_corner = np.take_along_axis(corners, following[..., None], axis=1)
    inside, next_inside = height <= 0, next_height <= 0
    crosses = valid & (inside != next_inside)
    span = np.where(crosses, height - next_height, 1.0)
    crossing = corners + (next_corner - corners) * (np.where(crosses, height, 0.0) / span)[..., None]
    keep = np.stack([valid & inside, crosses], axis=2).reshape(k, 2 * q)
    candidates = np.stack([corners, crossing], axis=2).reshape(k, 2 * q, 3)
    order = np.argsort(~keep, axis=1, kind="stable")[:, : q + 1]
    return np.take_along_axis(candidates, order[..., None], axis=1), np.minimum(keep.sum(axis=1), q + 1)


def meets(triangles: FloatArray, planes: FloatArray) -> NDArray[np.bool_]:
    """Which triangles have a point in the intersection of their half-spaces.

    Parameters
    ----------
    triangles : ndarray of float64, shape (k, 3, 3)
    planes : ndarray of float64, shape (k, p, 4)

    Returns
    -------
    ndarray of bool, shape (k,)
    """
    alive = np.arange(len(triangles))
    corners, count = triangles, np.full(len(triangles), 3, dtype=np.int64)
    for index in range(planes.shape[1]):
        corners, count = clip(corners, count, planes[alive, index])
        left = count > 0
        alive, corners, count = alive[left], corners[left], count[left]
    result = np.zeros(len(triangles), dtype=bool)
    result[alive] = True
    return result
