"""First hits of rays on a scene, with Embree.

References
----------
I. Wald et al., Embree: a kernel framework for efficient CPU ray tracing, ACM TOG 33 (2014).
"""

from __future__ import annotations

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
from numpy.typing import NDArray

from tilesnav_ref.scene import Scene

GRAZING = 1e-3
"""Sine of the angle between ray and face below which the plane of the face says little about the range."""


class SceneRays:
    """A scene that rays are cast on; both sides of every face return.

    Notes
    -----
    Embree computes in float32. The scene stands in grid steps, which float32 holds exactly below 2^24, so
    the surface is the true one wherever on Earth the scene lies: the nav frame is its local origin. Origins
    are rounded by at most half a step. Embree decides which face is hit; how far it is follows in float64
    from the plane of the face, so the range is exact for that face.
    """

    def __init__(self, scene: Scene) -> None:
        self._step = scene.step
        corners = scene.corners()
        self._corner = corners[:, 0] * scene.step
        edges = np.diff(corners, axis=1).astype(np.float64)
        normals = np.cross(edges[:, 0], edges[:, 1])
        self._normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        # Without the robust mode rays slip between faces that share an edge now and then.
        self._scene = rtcore_scene.EmbreeScene(robust=True)
        self._mesh = TriangleMesh(self._scene, np.ascontiguousarray(corners, np.float32))

    def first_hits(
        self, origins: NDArray[np.float64], directions: NDArray[np.float64], max_range: float
    ) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
        """First face that each ray hits, and how far away.

        Parameters
        ----------
        origins : (R, 3) float64
            Metres, nav frame.
        directions : (R, 3) float64
            Unit vectors.
        max_range : float
            Metres; what is farther is not hit.

        Returns
        -------
        faces : (R,) int32
            -1 for none.
        ranges : (R,) float64
            Metres; infinite for none.
        """
        starts = np.ascontiguousarray(origins / self._step, np.float32)
        ways = np.ascontiguousarray(directions, np.float32)
        reach = np.full(len(starts), max_range / self._step, np.float32)
        hit = self._scene.run(starts, ways, dists=reach, query="INTERSECT", output=True)
        faces = np.asarray(hit["primID"], np.int32)
        met = np.flatnonzero(faces >= 0)
        ranges = np.full(len(faces), np.inf)
        ranges[met] = hit["tfar"][met] * np.float64(self._step)
        normals = self._normals[faces[met]]
        slope = np.einsum("ij,ij->i", directions[met], normals)
        away = np.einsum("ij,ij->i", self._corner[faces[met]] - origins[met], normals)
        steep = np.abs(slope) > GRAZING
        ranges[met[steep]] = away[steep] / slope[steep]
        return faces, ranges
