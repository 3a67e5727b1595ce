"""Convex polygons of portals: order, convexity, distance, half-spaces of their edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def turns_once(corners: FloatArray, normals: FloatArray, tolerance: float) -> BoolArray:
    """Which polygons are convex with their corners in order, one way round or the other, shape (k,).

    Parameters
    ----------
    corners : ndarray of float64, shape (k, q, 3)
    normals : ndarray of float64, shape (k, 3)
        Unit normals of the planes that they lie in.
    tolerance : float
        Metres by which a corner may be within the line of its neighbours.
    """
    edges = np.roll(corners, -1, axis=1) - corners
    following = np.roll(edges, -1, axis=1)
    sine = np.einsum("kqi,ki->kq", np.cross(edges, following), normals)
    cosine = np.einsum("kqi,kqi->kq", edges, following)
    reach = np.linalg.norm(edges + following, axis=2) * tolerance
    one_way = (sine >= -reach).all(axis=1) | (sine <= reach).all(axis=1)
    turn = np.abs(np.arctan2(sine, cosine).sum(axis=1))
    return np.asarray(one_way & (np.abs(turn - 2 * np.pi) < 1))  # the turn is a multiple of 2 pi


def edge_planes(corners: FloatArray, normals: FloatArray) -> FloatArray:
    """Half-spaces ``n.x + d <= 0`` of the edges, unit normals in the plane of the polygon, shape (k, q, 4).

    The half-space of an edge of length zero is everything.
    """
    edges = np.roll(corners, -1, axis=1) - corners
    spokes = corners - corners[:, :1]
    area = np.cross(spokes[:, :-1], spokes[:, 1:]).sum(axis=1)
    way = np.where(np.einsum("ki,ki->k", area, normals) < 0, -1.0, 1.0)
    outward = np.cross(edges, (normals * way[:, None])[:, None])
    length = np.linalg.norm(outward, axis=2, keepdims=True)
    outward = outward / np.where(length > 0, length, 1)
    offset = -np.einsum("kqi,kqi->kq", outward, corners)
    return np.concatenate([outward, offset[..., None]], axis=2)


def distance(points: FloatArray, corners: FloatArray, normals: FloatArray) -> FloatArray:
    """Distance of points to convex polygons, measured within the planes of these, shape (k, r).

    Parameters
    ----------
    points : ndarray of float64, shape (k, r, 3)
    corners : ndarray of float64, shape (k, q, 3)
    normals : ndarray of float64, shape (k, 3)
    """
    planes = edge_planes(corners, normals)
    height = np.einsum("kri,kqi->krq", points, planes[..., :3]) + planes[:, None, :, 3]
    edges = np.roll(corners, -1, axis=1) - corners
    offset = points[:, :, None] - corners[:, None]
    offset = offset - np.einsum("krqi,ki->krq", offset, normals)[..., None] * normals[:, None, None]
    square = np.einsum("kqi,kqi->kq", edges, edges)
    along = np.einsum("krqi,kqi->krq", offset, edges) / np.where(square > 0, square, 1)[:, None]
    nearest = offset - np.clip(along, 0, 1)[..., None] * edges[:, None]
    to_edge = np.linalg.norm(nearest, axis=3).min(axis=2)
    return np.asarray(np.where(height.max(axis=2) <= 0, 0.0, to_edge))
