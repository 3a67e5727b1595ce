"""Outlines of planar features: alpha shapes of their inliers, with holes.

References
----------
H. Edelsbrunner, D. Kirkpatrick, R. Seidel, "On the shape of a set of points in the plane", IEEE Transactions
on Information Theory 29(4), 1983.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import Delaunay, QhullError

from tilesnav_ref.planar.mesh_settings import MeshSettings
from tilesnav_ref.planar.model import PlanarFeatures


@dataclass(frozen=True)
class Frame:
    """Coordinates u, v in a plane."""

    origin: NDArray[np.float64]
    """(3,) on the plane, metres."""
    axes: NDArray[np.float64]
    """(2, 3) unit vectors; their cross product is the normal."""

    def flat(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 2) coordinates of the feet of (N, 3) points on the plane."""
        return np.asarray((points - self.origin) @ self.axes.T)

    def lifted(self, flat: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) points of (N, 2) coordinates."""
        return np.asarray(self.origin + flat @ self.axes)


@dataclass(frozen=True)
class Outline:
    """Where the inliers of a feature are."""

    frame: Frame
    shape: shapely.MultiPolygon
    """Polygons with holes in the frame of the plane; every vertex is an inlier. Empty where there are too
    few inliers for an area."""
    spacing: float
    """Median circumradius of the Delaunay triangles of the inliers, metres."""
    samples: NDArray[np.float64]
    """(M, 3) inliers of the outline, at most one a square of the resolution, metres."""


def plane_frame(features: PlanarFeatures, feature: int) -> Frame:
    """Frame along the sides of the extent rectangle."""
    return Frame(features.extents.centres[feature], features.extents.axes[feature])


def find_outlines(
    points: NDArray[np.float64], features: PlanarFeatures, settings: MeshSettings
) -> list[Outline]:
    """Find the outline of every feature.

    Parameters
    ----------
    points : (N, 3) float64
        Metres; those that `features.labels` is about.
    features : PlanarFeatures
    settings : MeshSettings

    Returns
    -------
    list of Outline
        In the order of the features.
    """
    order = np.argsort(features.labels, kind="stable")
    borders = np.searchsorted(features.labels[order], np.arange(len(features) + 1))
    return [
        find_outline(points[order[borders[k] : borders[k + 1]]], plane_frame(features, k), settings)
        for k in range(len(features))
    ]


def find_outline(inliers: NDArray[np.float64], frame: Frame, settings: MeshSettings) -> Outline:
    """Alpha shape of inliers (N, 3) in a plane."""
    flat = frame.flat(inliers)
    samples = _thin(flat, settings.resolution)
    flat = flat[samples]
    nothing = Outline(frame, shapely.MultiPolygon(), settings.resolution, inliers[samples])
    if len(flat) < 3:
        return nothing
    try:
        triangles = Delaunay(flat).simplices.astype(np.int64)
    except QhullError:  # all on a line
        return nothing
    radii = _circumradii(flat[triangles])
    spacing = float(np.median(radii))
    kept = radii <= settings.alpha * spacing
    shape = _joined(flat, triangles[kept], settings.hole * np.pi * (settings.alpha * spacing) ** 2)
    return Outline(frame, shape, spacing, inliers[samples])


def _thin(flat: NDArray[np.float64], resolution: float) -> NDArray[np.int64]:
    """Indices of one point (the first) for each square of the resolution, ascending."""
    places = np.floor(flat / resolution).astype(np.int64)
    places -= places.min(axis=0, initial=0)
    codes = places[:, 0] * (places[:, 1].max(initial=0) + 1) + places[:, 1]
    return np.sort(np.unique(codes, return_index=True)[1])


def _circumradii(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T,) radii of the circles through the corners (T, 3, 2) of triangles; infinite without area."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    doubled = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    lengths = np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1) * np.linalg.norm(a - b, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        radii = lengths / (2.0 * doubled)
    return np.where(np.isfinite(radii), radii, np.inf)


def _joined(
    flat: NDArray[np.float64], triangles: NDArray[np.int64], least_hole: float
) -> shapely.MultiPolygon:
    """Union of triangles (T, 3) of one triangulation of points (N, 2), without holes below an area.

    Notes
    -----
    Edges of two triangles are inside; the others bound the union, and a union of triangles is what an odd
    number of their rings encloses.
    """
    if not len(triangles):
        return shapely.MultiPolygon()
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    codes, counts = np.unique(edges[:, 0] * len(flat) + edges[:, 1], return_counts=True)
    border = codes[counts == 1]
    ends = np.stack((flat[border // len(flat)], flat[border % len(flat)]), axis=1)
    lines = shapely.multilinestrings(shapely.linestrings(ends))
    parts = [_without_small_holes(part, least_hole) for part in shapely.get_parts(shapely.build_area(lines))]
    return shapely.MultiPolygon(sorted(parts, key=lambda part: -part.area))


def _without_small_holes(part: shapely.Polygon, least: float) -> shapely.Polygon:
    return shapely.Polygon(
        part.exterior, [hole for hole in part.interiors if shapely.Polygon(hole).area >= least]
    )
