"""Rays that suggest which faces are visible; what they suggest is decided by exact segments (lines.py).

References
----------
I. Wald et al., Embree: a kernel framework for efficient CPU ray tracing, ACM TOG 33 (2014).
"""

from __future__ import annotations

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
from numpy.typing import NDArray

from tilesnav_ref.visibility.geometry import FineFrame, Geometry


class RayCaster:
    """Embree scene in grid steps about the middle of the scene, exact in float32 for a scene on the grid."""

    def __init__(self, geometry: Geometry, frame: FineFrame) -> None:
        self._frame = frame
        self._scene = rtcore_scene.EmbreeScene()
        self._mesh = TriangleMesh(
            self._scene, np.ascontiguousarray(geometry.corners / frame.scale, np.float32)
        )

    def first_hits(
        self, points: NDArray[np.float64], directions: NDArray[np.float32]
    ) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
        """First face that each ray hits (-1: none), and where on it.

        Parameters
        ----------
        points : (R, 3) fine units.
        directions : (R, 3) of any length.

        Returns
        -------
        (R,) faces and (R, 2) barycentric weights of corners 1 and 2.
        """
        origins = np.ascontiguousarray(points / self._frame.scale, np.float32)
        hit = self._scene.run(origins, directions, query="INTERSECT", output=True)
        return hit["primID"].astype(np.int32), np.stack([hit["u"], hit["v"]], axis=1).astype(np.float64)


def random_directions(random: np.random.Generator, count: int) -> NDArray[np.float32]:
    """(count, 3) uniform directions on the sphere, float32 unit vectors."""
    z = random.uniform(-1.0, 1.0, count)
    angle = random.uniform(0.0, 2.0 * np.pi, count)
    radius = np.sqrt(1.0 - z * z)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1).astype(np.float32)


def random_points(random: np.random.Generator, box: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """(count, 3) uniform integer points strictly inside a box (2, 3), fine units."""
    return random.integers(box[0].astype(np.int64) + 1, box[1].astype(np.int64), (count, 3)).astype(
        np.float64
    )


def points_on_faces(
    random: np.random.Generator, corners: NDArray[np.float64], faces: NDArray[np.int64]
) -> NDArray[np.float64]:
    """(K, 3) a uniform point on each of the given faces (K,), rounded to float64; corners is (F, 3, 3)."""
    weights = random.random((2, len(faces), 1))
    u, v = np.where(weights.sum(axis=0) > 1.0, 1.0 - weights, weights)
    a, b, c = corners[faces].transpose(1, 0, 2)
    return np.asarray(a + (b - a) * u + (c - a) * v)


def directions_to(points: NDArray[np.float64], targets: NDArray[np.float64]) -> NDArray[np.float32]:
    """(K, 3) float32 unit vectors from points to targets, which differ."""
    away = targets - points
    return np.asarray(away / np.linalg.norm(away, axis=1, keepdims=True), np.float32)
