"""Scans thinned for registration: one point a voxel, and the plane around each.

References
----------
K. Koide: small_gicp: efficient and parallel algorithms for point cloud registration, JOSS 9(100) (2024).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tilesnav_ref.registration.motion import place
from tilesnav_ref.registration.settings import RegistrationError, RegistrationSettings

GICP_NEIGHBOURS = 20
"""Neighbours of which the spread around a point is taken, as small_gicp does by itself."""
PLANE_NEIGHBOURS = 30
"""Neighbours that a plane is fitted to; with 8 the plane follows the two points that are compared, so their
distance from it is too small."""
FLAT = 0.1
"""Greatest ratio of the least to the middle spread (squares) of a neighbourhood that is taken for a plane."""
CHUNK = 100_000
"""Points whose neighbours are held at once, about 100 MB."""
LEAST_POINTS = 50
"""A scan with fewer points in voxels says nothing about its pose."""
VOXELS_ACROSS = 1 << 20
"""small_gicp leaves points out that are more voxels than this away from zero."""


@dataclass(frozen=True)
class Thinned:
    """A scan in its own frame."""

    points: NDArray[np.float64]
    """(N, 3) means of the points of each voxel, metres."""
    cloud: Any
    """The same for small_gicp, with the spread around each."""
    tree: Any
    """scipy's cKDTree of `points`."""


@dataclass(frozen=True)
class Planes:
    """The planes around the points of a scan, in its own frame."""

    normals: NDArray[np.float64]
    """(N, 3) unit vectors."""
    flat: NDArray[np.bool_]
    """(N,) whether the neighbourhood is flat."""


def gicp() -> Any:
    """Module small_gicp.

    Raises
    ------
    RegistrationError
        When the extra is missing.
    """
    try:
        import small_gicp  # noqa: PLC0415 - an extra
    except ImportError as error:
        allowed = "the extra 'lidar': pip install 'tilesnav[lidar]'"
        raise RegistrationError("registration", "no small_gicp", allowed) from error
    return small_gicp


def thin(name: str, points: NDArray[np.float64], settings: RegistrationSettings) -> Thinned:
    """Thin a scan (N, 3); points that are not finite are left out.

    Raises
    ------
    RegistrationError
        When too little is left, or it is too large for the voxels.
    """
    library = gicp()
    kept = np.ascontiguousarray(points[np.isfinite(points).all(axis=1)], np.float64)
    reach = float(np.abs(kept).max(initial=0.0))
    if reach >= VOXELS_ACROSS * settings.voxel:
        allowed = f"less than {VOXELS_ACROSS * settings.voxel:.0f} m; larger voxels"
        raise RegistrationError(name, f"points {reach:.0f} m away", allowed)
    # One thread: with more, small_gicp's voxels depend on how the threads run.
    cloud = library.preprocess_points(kept, settings.voxel, GICP_NEIGHBOURS, 1)[0] if len(kept) else None
    if cloud is None or cloud.size() < LEAST_POINTS:
        count = 0 if cloud is None else cloud.size()
        allowed = f"{LEAST_POINTS} or more; smaller voxels"
        raise RegistrationError(name, f"points in {count} voxels of {settings.voxel:g} m", allowed)
    means = np.array(cloud.points()[:, :3])
    return Thinned(means, cloud, cKDTree(means))


def middles_of(scans: list[Thinned], poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """(S, 3) means of the points of scans as they lie."""
    means = [place(pose, scan.points.mean(axis=0)) for scan, pose in zip(scans, poses, strict=True)]
    return np.array(means).reshape(-1, 3)


def planes_of(scans: list[Thinned], poses: NDArray[np.float64]) -> list[Planes]:
    """Fit a plane around each point of all scans, among the points of all of them as they lie now.

    The rings of one scan are lines, whose neighbourhoods are no planes; those of all scans together are.
    """
    placed = np.concatenate([place(pose, scan.points) for scan, pose in zip(scans, poses, strict=True)])
    normals, flat = _fit(placed)
    bounds = np.cumsum([0, *(len(scan.points) for scan in scans)])
    return [
        Planes(normals[first:last] @ pose[:3, :3], flat[first:last])
        for first, last, pose in zip(bounds, bounds[1:], poses, strict=False)
    ]


def _fit(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    tree = cKDTree(points)
    normals, flat = np.empty_like(points), np.empty(len(points), np.bool_)
    count = min(PLANE_NEIGHBOURS, len(points))
    for first in range(0, len(points), CHUNK):
        part = slice(first, first + CHUNK)
        _, near = tree.query(points[part], k=count)
        away = points[near] - points[near].mean(axis=1, keepdims=True)
        spread, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", away, away) / count)
        normals[part], flat[part] = axes[:, :, 0], spread[:, 0] < FLAT * spread[:, 1]
    return normals, flat
