"""The ground between planes: a triangulated height field that has the borders of the planes as its own.

Notes
-----
Ground undulates, so planes divide it and leave gaps between their outlines. What is known of these gaps is
the plan of the ground points less that of the faces on the ground. It is divided along the lines of squares,
which get smaller where the ground points are not met, and triangulated without further vertices. A triangle
that ground points still do not lie on is left out: the gap stays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tilesnav_ref.planar.mesh import PlanarMesh
from tilesnav_ref.planar.mesh_settings import MeshSettings
from tilesnav_ref.planar.model import PlanarFeatures
from tilesnav_ref.planar.outline import Frame, find_outline

LEVEL = 0.7
"""Least vertical component of the normal of a plane or triangle on the ground: 45 degrees."""
MOSTLY = 0.5
"""Least part of the inliers of a plane on the ground that are ground points."""
SQUARES = (16.0, 8.0, 4.0, 2.0)
"""Edges of the squares, metres; the largest where they do."""
OFF = 0.1
"""Greatest part of the ground points over a triangle that may be farther from it than the inlier distance."""
STRAYS = 1
"""So many points may be farther away in any case: blades of grass."""
NEAREST = 8
"""Points whose plane has the height of a place between them: noise is a third of theirs."""
LEVELLED = 0.01
"""Part of the spread of these points by which the plane is held level, where all of them are on a line."""
FEWEST = NEAREST
_LEAST_AREA = 1e-3
"""Square metres: slivers of less come from rounding."""
_TOUCHING = 1e-6
"""Metres: a vertex that lies on a border up to rounding."""


@dataclass(frozen=True)
class HeightField:
    """Triangles of the ground.

    Attributes
    ----------
    vertices : (V, 3) float64
        Metres, in the frame of the points.
    faces : (F, 3) int64
        Counter-clockwise seen from above.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]


_NOTHING = HeightField(np.zeros((0, 3)), np.zeros((0, 3), np.int64))


def fill_ground(
    points: NDArray[np.float64],
    ground: NDArray[np.bool_],
    features: PlanarFeatures,
    mesh: PlanarMesh,
    settings: MeshSettings,
) -> HeightField:
    """Close the gaps between the planes on the ground.

    Parameters
    ----------
    points : (N, 3) float64
        Metres, z up; those that `features.labels` is about.
    ground : (N,) bool
        Which are on the ground.
    features : PlanarFeatures
    mesh : PlanarMesh
        Of the features.
    settings : MeshSettings

    Returns
    -------
    HeightField
        Empty where there is no gap or no ground.
    """
    chosen = points[ground]
    outline = find_outline(chosen, Frame(np.zeros(3), np.eye(3)[:2]), settings)
    if outline.shape.is_empty or len(outline.samples) < FEWEST:
        return _NOTHING
    level = _level_faces(ground, features, mesh)
    corners = mesh.vertices[mesh.faces[level]]
    footprint = shapely.union_all(_plan(corners))
    gaps = _polygons(shapely.difference(outline.shape, footprint))
    if not len(gaps):
        return _NOTHING
    heights = _Heights(outline.samples, corners)
    return _filled(gaps, heights, chosen, features.inlier_distance)


def _level_faces(ground: NDArray[np.bool_], features: PlanarFeatures, mesh: PlanarMesh) -> NDArray[np.bool_]:
    """(F,) whether the plane of a face is one of the ground."""
    known = features.labels >= 0
    of_ground = np.bincount(features.labels[known & ground], minlength=len(features))
    level = (features.normals[:, 2] >= LEVEL) & (of_ground >= MOSTLY * features.counts)
    return np.asarray(level[mesh.face_plane])


def _plan(corners: NDArray[np.float64]) -> NDArray[np.object_]:
    """Plans of triangles (T, 3, 3)."""
    return np.asarray(shapely.polygons(corners[:, :, :2]))


def _polygons(shape: shapely.Geometry) -> NDArray[np.object_]:
    parts = shapely.get_parts(shape)
    return np.asarray(
        parts[
            (shapely.get_type_id(parts) == shapely.GeometryType.POLYGON)
            & (shapely.area(parts) >= _LEAST_AREA)
        ]
    )


class _Heights:
    """Height of the ground at any place: that of the faces on whose border it is, else between the points."""

    def __init__(self, samples: NDArray[np.float64], corners: NDArray[np.float64]) -> None:
        known = np.concatenate((corners.reshape(-1, 3), samples))
        plan, first = np.unique(known[:, :2], axis=0, return_index=True)
        self._exact = {(x, y): z for (x, y), z in zip(plan.tolist(), known[first, 2].tolist(), strict=True)}
        self._points = known[first]
        self._near = cKDTree(plan)
        self._corners = corners
        self._tree = shapely.STRtree(_plan(corners))

    def at(self, plan: NDArray[np.float64]) -> NDArray[np.float64]:
        """(M,) heights at (M, 2) places, metres."""
        exact = [self._exact.get((x, y), np.nan) for x, y in plan.tolist()]
        found = np.array(exact, np.float64)
        asked = np.flatnonzero(np.isnan(found))
        if len(self._corners) and len(asked):
            places, faces = self._tree.query(shapely.points(plan[asked]), "dwithin", _TOUCHING)
            found[asked[places]] = _heights_of(self._corners[faces], plan[asked[places]])
            asked = np.flatnonzero(np.isnan(found))
        found[asked] = self._between(plan[asked])
        return found

    def _between(self, plan: NDArray[np.float64]) -> NDArray[np.float64]:
        """Heights of least squares planes through the nearest points."""
        near = self._points[self._near.query(plan, k=NEAREST)[1].reshape(len(plan), NEAREST)]
        middle = near.mean(axis=1)
        beside, up = near[:, :, :2] - middle[:, None, :2], near[:, :, 2] - middle[:, None, 2]
        square = np.einsum("mki,mkj->mij", beside, beside)
        square += LEVELLED * np.trace(square, axis1=1, axis2=2)[:, None, None] * np.eye(
            2
        ) + _TOUCHING * np.eye(2)
        slopes = np.linalg.solve(square, np.einsum("mki,mk->mi", beside, up)[..., None])[..., 0]
        return np.asarray(middle[:, 2] + np.einsum("mi,mi->m", slopes, plan - middle[:, :2]))


def _normals(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T, 3) normals of triangles, as long as twice their area."""
    return np.asarray(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def _heights_of(corners: NDArray[np.float64], plan: NDArray[np.float64]) -> NDArray[np.float64]:
    """Heights of the planes of triangles (T, 3, 3), none upright, at places (T, 2)."""
    normals = _normals(corners)
    along = np.einsum("tk,tk->t", normals[:, :2], plan - corners[:, 0, :2])
    return np.asarray(corners[:, 0, 2] - along / normals[:, 2])


def _filled(
    gaps: NDArray[np.object_], heights: _Heights, ground: NDArray[np.float64], distance: float
) -> HeightField:
    """Divide and triangulate, with smaller squares where ground points are farther away than the distance."""
    low = np.floor(shapely.total_bounds(gaps)[:2])
    squares = _squares_of(gaps, low, SQUARES[0])
    for edge in SQUARES:
        corners = _triangles(gaps, low, squares, heights)
        bad = _misses(corners, ground, distance)
        if edge == SQUARES[-1] or not bad.any():
            break
        squares = _divided(squares, low, corners[bad].mean(axis=1)[:, :2], edge)
    kept = corners[~bad]
    steep = _normals(kept)
    kept = kept[np.abs(steep[:, 2]) >= LEVEL * np.linalg.norm(steep, axis=1)]
    vertices, faces = np.unique(kept.reshape(-1, 3), axis=0, return_inverse=True)
    return HeightField(vertices, faces.reshape(-1, 3).astype(np.int64))


Squares = dict[float, set[tuple[int, int]]]
"""Columns and rows of squares by their edge."""


def _squares_of(gaps: NDArray[np.object_], low: NDArray[np.float64], edge: float) -> Squares:
    """All squares of an edge that meet a gap."""
    bounds = np.floor((shapely.bounds(gaps) - np.tile(low, 2)) / edge).astype(np.int64)
    places = np.unique(
        np.concatenate(
            [
                np.stack(np.meshgrid(np.arange(a, c + 1), np.arange(b, d + 1)), axis=-1).reshape(-1, 2)
                for a, b, c, d in bounds.tolist()
            ]
        ),
        axis=0,
    )
    start = low + places * edge
    met = np.unique(shapely.STRtree(shapely.box(*start.T, *(start + edge).T)).query(gaps, "intersects")[1])
    return {edge: set(map(tuple, places[met].tolist()))}


def _divided(squares: Squares, low: NDArray[np.float64], places: NDArray[np.float64], edge: float) -> Squares:
    """Squares with those of an edge that hold any of the places (M, 2) divided into four."""
    asked = set(map(tuple, np.floor((places - low) / edge).astype(np.int64).tolist()))
    chosen = squares[edge] & asked
    quarters = {(2 * x + i, 2 * y + j) for x, y in chosen for i in (0, 1) for j in (0, 1)}
    return {**squares, edge: squares[edge] - chosen, edge / 2: quarters}


def _triangles(
    gaps: NDArray[np.object_], low: NDArray[np.float64], squares: Squares, heights: _Heights
) -> NDArray[np.float64]:
    """(T, 3, 3) triangles of the gaps, divided along the squares; neighbours share their vertices."""
    boxes = np.concatenate(
        [
            shapely.box(*start.T, *(start + edge).T)
            for edge, places in squares.items()
            if places
            for start in [low + np.array(sorted(places)) * edge]
        ]
    )
    # lines with nodes wherever any of them meet: a larger square gets the corners of its smaller neighbours
    lines = shapely.union_all(np.concatenate((shapely.boundary(gaps), shapely.boundary(boxes))))
    pieces = shapely.get_parts(shapely.polygonize(shapely.get_parts(lines)))
    # the gaps are asked, since shapely prepares what asks: they have most vertices
    inside = shapely.STRtree(shapely.point_on_surface(pieces)).query(gaps, "contains")[1]
    pieces = pieces[np.unique(inside)]
    parts = shapely.get_parts(shapely.get_parts(shapely.constrained_delaunay_triangles(pieces)))
    flat = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    first, second = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    clockwise = first[:, 0] * second[:, 1] < first[:, 1] * second[:, 0]
    flat[clockwise] = flat[clockwise][:, ::-1]
    plan, back = np.unique(flat.reshape(-1, 2), axis=0, return_inverse=True)
    return np.column_stack((plan, heights.at(plan)))[back.reshape(-1)].reshape(-1, 3, 3)


def _misses(corners: NDArray[np.float64], ground: NDArray[np.float64], distance: float) -> NDArray[np.bool_]:
    """(T,) triangles that more than a part `OFF` of the ground points over them are not on."""
    upright = _normals(corners)[:, 2] <= 0.0  # no plan: rounding
    places, faces = shapely.STRtree(_plan(corners)).query(shapely.points(ground[:, :2]), "intersects")
    kept = ~upright[faces]
    places, faces = places[kept], faces[kept]
    normals = _normals(corners[faces])
    cosine = normals[:, 2] / np.linalg.norm(normals, axis=1)
    away = np.abs(ground[places, 2] - _heights_of(corners[faces], ground[places, :2])) * cosine
    counts = np.bincount(faces, minlength=len(corners))
    off = np.bincount(faces[away > distance], minlength=len(corners))
    return np.asarray(upright | (off > np.maximum(OFF * counts, STRAYS)))
