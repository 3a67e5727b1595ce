"""Faces that rays suggest as visible; Embree only suggests, exact segments decide.

References
----------
I. Wald et al., Embree: a kernel framework for efficient CPU ray tracing, ACM TOG 33 (2014).
"""

from __future__ import annotations

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.visibility.certify import trailing_zeros
from tilesnav_ref.visibility.geometry import FineFrame, Geometry
from tilesnav_ref.visibility.sight import blocker


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


@kernel
def confirm(geometry, points, faces, weights, proven):  # type: ignore[no-untyped-def]
    """Set `proven` for every suggested face that an exact segment from its ray's origin sees.

    The suggested point is moved to the nearest point of the face's relative interior whose barycentric
    weights are multiples of a power of two, so that it has integer coordinates and is exactly on the face.
    """
    for i in range(len(faces)):
        face = faces[i]
        if face < 0 or proven[face]:
            continue
        part = geometry.corners[face]
        bits = trailing_zeros(part)
        whole = np.int64(1) << bits
        one = min(max(np.int64(np.round(weights[i, 0] * whole)), 1), whole - 2)
        two = min(max(np.int64(np.round(weights[i, 1] * whole)), 1), whole - one - 1)
        three = whole - one - two
        t = (
            (three * part[0, 0] + one * part[1, 0] + two * part[2, 0]) / whole,
            (three * part[0, 1] + one * part[1, 1] + two * part[2, 1]) / whole,
            (three * part[0, 2] + one * part[1, 2] + two * part[2, 2]) / whole,
        )
        c = (points[i, 0], points[i, 1], points[i, 2])
        if blocker(geometry, c, t, face) < 0:
            proven[face] = True


def sample_cell(
    geometry: Geometry, caster: RayCaster, box: NDArray[np.float64], rays: int, random: np.random.Generator
) -> NDArray[np.bool_]:
    """(F,) faces that `rays` uniform rays from a cell (2, 3) prove visible."""
    proven = np.zeros(len(geometry.corners), np.bool_)
    points = random_points(random, box, rays)
    faces, weights = caster.first_hits(points, random_directions(random, rays))
    confirm(geometry, points, faces, weights, proven)
    return proven
