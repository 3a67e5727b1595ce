"""Labelled point clouds whose true planes are known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from tilesnav_ref.planar import NO_PLANE, PlanarFeatures, Rectangles
from tilesnav_ref.scene.model import Scene


def coplanar_parts(corners: NDArray[np.float64]) -> NDArray[np.int64]:
    """(F,) number of the flat connected patch of each triangle (F, 3, 3)."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals *= np.where(normals[:, [2, 1, 0]][np.arange(len(normals)), _first_large(normals)] < 0, -1.0, 1.0)[
        :, None
    ]
    offsets = np.einsum("fk,fk->f", normals, corners[:, 0])
    keys = np.round(np.column_stack((normals * 1000, offsets * 100)))
    _, plane = np.unique(keys, axis=0, return_inverse=True)
    _, vertex = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    faces = vertex.reshape(-1, 3)
    edges = np.column_stack(
        (np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), np.repeat(plane, 3))
    )
    _, place = np.unique(edges, axis=0, return_inverse=True)
    order = np.argsort(place, kind="stable")
    same = place[order][1:] == place[order][:-1]
    first, second = order[1:][same] // 3, order[:-1][same] // 3
    links = coo_array((np.ones(len(first)), (first, second)), shape=(len(corners), len(corners)))
    return connected_components(links, directed=False)[1].astype(np.int64)


def _first_large(normals: NDArray[np.float64]) -> NDArray[np.int64]:
    return np.argmax(np.abs(normals[:, [2, 1, 0]]) > 1e-9, axis=1)


def sample_triangles(
    corners: NDArray[np.float64], density: float, noise: float, seed: int
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Uniform points on triangles (F, 3, 3), `density` a square metre, and the triangle of each."""
    rng = np.random.default_rng(seed)
    edges = corners[:, 1:] - corners[:, :1]
    areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 2
    owner = np.repeat(np.arange(len(corners)), rng.poisson(areas * density))
    u, v = rng.random((2, len(owner)))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    points = corners[owner, 0] + u[:, None] * edges[owner, 0] + v[:, None] * edges[owner, 1]
    return points + rng.normal(0.0, noise, points.shape), owner


def features_of(points: NDArray[np.float64], labels: NDArray[np.int64], least: int = 30) -> PlanarFeatures:
    """Features of labelled points by least squares, those with fewer points than `least` left out."""
    counts = np.bincount(labels[labels >= 0])
    kept = np.flatnonzero(counts >= least)
    kept = kept[np.argsort(-counts[kept], kind="stable")]
    number = np.full(len(counts) + 1, NO_PLANE, np.int32)
    number[kept] = np.arange(len(kept))
    rows = [_fit(points[labels == k]) for k in kept]
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    normals, centroids, covariances, rms, centres, axes, halves = columns
    return PlanarFeatures(
        normals=normals,
        offsets=-np.einsum("kj,kj->k", normals, centroids),
        centroids=centroids,
        covariances=covariances,
        rms=rms,
        counts=counts[kept].astype(np.int64),
        extents=Rectangles(centres, axes, halves),
        labels=number[labels],
        inlier_distance=0.08,
        normal_deviation=0.3,
    )


def _fit(inliers: NDArray[np.float64]) -> tuple[object, ...]:
    centroid = inliers.mean(axis=0)
    covariance = np.cov((inliers - centroid).T, bias=True)
    values, vectors = np.linalg.eigh(covariance)
    normal = vectors[:, 0]
    normal = normal * (-1.0 if normal[::-1][np.argmax(np.abs(normal[::-1]) > 1e-9)] < 0 else 1.0)
    first = vectors[:, 2]
    axes = np.stack((first, np.cross(normal, first)))
    flat = (inliers - centroid) @ axes.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    centre = centroid + (low + high) / 2 @ axes
    return normal, centroid, covariance, float(np.sqrt(max(values[0], 0.0))), centre, axes, (high - low) / 2


def labelled_scene(
    scene: Scene, density: float, noise: float = 0.02, seed: int = 0
) -> tuple[NDArray[np.float64], PlanarFeatures]:
    """Noisy points on the faces of a scene and their true features."""
    corners = scene.corners() * scene.step
    points, owner = sample_triangles(corners, density, noise, seed)
    return points, features_of(points, coplanar_parts(corners)[owner])


def distances_to_triangles(
    points: NDArray[np.float64], corners: NDArray[np.float64], density: float = 100.0
) -> NDArray[np.float64]:
    """(N,) distances of points (N, 3) from triangles (F, 3, 3); exact distances from those near samples of
    them, so never too small."""
    samples, owner = sample_triangles(corners, density, 0.0, 0)
    samples, owner = np.vstack((samples, corners.mean(axis=1))), np.append(owner, np.arange(len(corners)))
    _, near = cKDTree(samples).query(points, k=8)
    best = np.full(len(points), np.inf)
    for column in owner[near].T:
        best = np.minimum(best, _to_triangle(points, corners[column]))
    return best


def _to_triangle(points: NDArray[np.float64], corners: NDArray[np.float64]) -> NDArray[np.float64]:
    edges = np.roll(corners, -1, axis=1) - corners
    normals = np.cross(edges[:, 0], edges[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    steps = points[:, None] - corners
    inside = np.all(np.einsum("nij,nj->ni", np.cross(edges, steps), normals) >= 0, axis=1)
    lengths = np.maximum(np.einsum("nij,nij->ni", edges, edges), 1e-30)
    along = np.clip(np.einsum("nij,nij->ni", steps, edges) / lengths, 0.0, 1.0)
    borders = np.linalg.norm(steps - along[:, :, None] * edges, axis=2).min(axis=1)
    return np.where(inside, np.abs(np.einsum("nj,nj->n", steps[:, 0], normals)), borders)
