"""Rays that suggest which faces are visible; what they suggest is decided by exact segments (lines.py).

References
----------
I. Wald et al., Embree: a kernel framework for efficient CPU ray tracing, ACM TOG 33 (2014).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
from numpy.typing import NDArray

from tilesnav_ref.visibility.geometry import FineFrame, Geometry
from tilesnav_ref.visibility.lines import FAR
from tilesnav_ref.visibility.prisms import inner_range, slant

Hits = tuple[NDArray[np.int32], NDArray[np.float64]]
"""(R,) faces, -1 for none, and (R, 2) barycentric weights of corners 1 and 2."""

MOST_PASSED = 8
"""Porous faces that are found on one ray."""
PASS_STEP = 1.0
"""Grid steps behind a porous face from where a ray goes on; other rays find leaves that are nearer."""


class _Part:
    """Embree scene of some faces in grid steps about the middle of the scene; exact in float32."""

    def __init__(self, geometry: Geometry, frame: FineFrame, faces: NDArray[np.int32]) -> None:
        self._faces = np.append(faces, np.int32(-1))  # the last is for -1, none
        self._scene = rtcore_scene.EmbreeScene()
        corners = geometry.corners[faces] if len(faces) < len(geometry.corners) else geometry.corners
        triangles = np.ascontiguousarray(corners / frame.scale, np.float32)
        self._mesh = TriangleMesh(self._scene, triangles) if len(faces) else None

    def run(
        self,
        origins: NDArray[np.float32],
        directions: NDArray[np.float32],
        dists: NDArray[np.float32] | None = None,
    ) -> tuple[Hits, NDArray[np.float64]]:
        """First hits, and how far away they are in lengths of the direction."""
        count = len(origins)
        if self._mesh is None:
            return (np.full(count, -1, np.int32), np.zeros((count, 2))), np.full(count, np.inf)
        hit = self._scene.run(origins, directions, dists=dists, query="INTERSECT", output=True)
        weights = np.stack([hit["u"], hit["v"]], axis=1).astype(np.float64)
        return (self._faces[hit["primID"]], weights), hit["tfar"].astype(np.float64)


class RayCaster:
    """First hits of rays on a scene; where it has porous faces, on what is opaque and on what is porous."""

    def __init__(self, geometry: Geometry, frame: FineFrame) -> None:
        self._frame = frame
        self.has_porous = bool(geometry.porous.any())
        numbers = np.arange(len(geometry.corners), dtype=np.int32)
        self._opaque = _Part(geometry, frame, numbers[~geometry.porous])
        self._porous = _Part(geometry, frame, numbers[geometry.porous])

    def first_hits(
        self, points: NDArray[np.float64], directions: NDArray[np.float32]
    ) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
        """First opaque face that each ray hits (-1: none), and where on it.

        Parameters
        ----------
        points : (R, 3) fine units.
        directions : (R, 3) of any length.

        Returns
        -------
        (R,) faces and (R, 2) barycentric weights of corners 1 and 2.
        """
        return self.opaque_hits(points, directions)[0]

    def opaque_hits(
        self, points: NDArray[np.float64], directions: NDArray[np.float32]
    ) -> tuple[Hits, NDArray[np.float64]]:
        """First opaque faces as `first_hits` gives them, and how far they are, fine units (FAR: none)."""
        origins = np.ascontiguousarray(points / self._frame.scale, np.float32)
        hits, distances = self._opaque.run(origins, directions)
        return hits, np.where(hits[0] < 0, FAR, distances * self._frame.scale)

    def porous_hits(
        self, points: NDArray[np.float64], directions: NDArray[np.float32], free: NDArray[np.float64]
    ) -> Iterator[Hits]:
        """Porous faces on rays that go `free` (R,) fine units far: the first of each ray, the second, ..."""
        done = np.zeros(len(points))
        going = np.arange(len(points))
        for _ in range(MOST_PASSED):
            left = (free[going] - done[going]) / self._frame.scale
            going, left = going[left > 0], left[left > 0]
            if not len(going):
                return
            along = directions[going]
            origins = (points[going] + done[going, None] * along) / self._frame.scale
            hits, distances = self._porous.run(origins.astype(np.float32), along, left.astype(np.float32))
            met = hits[0] >= 0
            faces, weights = np.full(len(points), -1, np.int32), np.zeros((len(points), 2))
            faces[going[met]], weights[going[met]] = hits[0][met], hits[1][met]
            going = going[met]
            done[going] += (distances[met] + PASS_STEP) * self._frame.scale
            yield faces, weights


def random_directions(random: np.random.Generator, count: int) -> NDArray[np.float32]:
    """(count, 3) uniform directions on the sphere, float32 unit vectors."""
    z = random.uniform(-1.0, 1.0, count)
    angle = random.uniform(0.0, 2.0 * np.pi, count)
    radius = np.sqrt(1.0 - z * z)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1).astype(np.float32)


def random_points(random: np.random.Generator, prism: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """(count, 3) integer points strictly inside a prism (8, 3), fine units; uniform in a box."""
    low, high = prism.min(axis=0).astype(np.int64), prism.max(axis=0).astype(np.int64)
    points = random.integers(low + 1, high, (count, 3))
    u, v = slant(prism)
    if v >= 0:
        least, greatest = inner_range(prism, (u, v), points[:, u])
        points[:, v] = random.integers(least, greatest + 1)
    return points.astype(np.float64)


def points_within(
    random: np.random.Generator, prism: NDArray[np.float64], targets: NDArray[np.float64], near: int
) -> NDArray[np.float64]:
    """(K, 3) integer points strictly inside a prism (8, 3), in cubes of half-width `near` about targets.

    Where the cube of a target (K, 3) does not reach the prism, the point is one of the prism that is near it.
    """
    low = np.clip(np.ceil(targets - near), prism.min(axis=0) + 1, prism.max(axis=0) - 1)
    high = np.clip(np.floor(targets + near), low, prism.max(axis=0) - 1)
    shares = random.random(targets.shape)
    points = low + np.floor(shares * (high - low + 1))
    u, v = slant(prism)
    if v >= 0:
        least, greatest = inner_range(prism, (u, v), points[:, u].astype(np.int64))
        low = np.clip(np.ceil(targets[:, v] - near), least, greatest)
        high = np.clip(np.floor(targets[:, v] + near), low, greatest)
        points[:, v] = low + np.floor(shares[:, v] * (high - low + 1))
    return np.asarray(points)


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
