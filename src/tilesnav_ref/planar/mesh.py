"""From planar features to a mesh whose faces meet along the creases of the planes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from tilesnav_ref.planar.borders import Borders, Stop
from tilesnav_ref.planar.creases import Creases
from tilesnav_ref.planar.mesh_settings import MeshSettings
from tilesnav_ref.planar.model import PlanarFeatures
from tilesnav_ref.planar.outline import Frame, Outline, find_outlines

_LEAST_AREA = 1e-4
"""Square metres: slivers of less are what is left of spikes that fold onto a crease."""


@dataclass(frozen=True)
class PlanarMesh:
    """Triangles on planes.

    Attributes
    ----------
    vertices : (V, 3) float64
        Metres, in the frame of the points.
    faces : (F, 3) int64
        Counter-clockwise seen from where the normal of the plane points to.
    face_plane : (F,) int64
        Feature of each face, ascending.
    shapes : tuple of shapely.MultiPolygon
        What the faces of each feature cover, in the frame of its plane.
    outlines : tuple of Outline
        The outlines they were made from.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    face_plane: NDArray[np.int64]
    shapes: tuple[shapely.MultiPolygon, ...]
    outlines: tuple[Outline, ...]

    def inlier_distances(
        self, points: NDArray[np.float64], features: PlanarFeatures, most: int = 1_000_000
    ) -> NDArray[np.float64]:
        """Distances of inliers from the faces of their own plane, metres; the nearest face may be another's.

        Parameters
        ----------
        points : (N, 3) float64
            Those that `features.labels` is about.
        features : PlanarFeatures
        most : int
            About this many of them are looked at, evenly chosen.
        """
        chosen = np.flatnonzero(features.labels >= 0)
        chosen = chosen[:: max(len(chosen) // most, 1)]
        chosen = chosen[np.argsort(features.labels[chosen], kind="stable")]
        borders = np.searchsorted(features.labels[chosen], np.arange(len(features) + 1))
        result = [np.zeros(0)]
        for feature, shape in enumerate(self.shapes):
            inliers = points[chosen[borders[feature] : borders[feature + 1]]]
            if shape.is_empty or not len(inliers):
                result.append(np.full(len(inliers), np.inf))
                continue
            flat = shapely.points(self.outlines[feature].frame.flat(inliers))
            shapely.prepare(shape)
            beside = np.where(shapely.intersects(shape, flat), 0.0, shapely.distance(shape, flat))
            result.append(np.hypot(features.distances(inliers, feature), beside))
        return np.concatenate(result)


def mesh_planes(
    points: NDArray[np.float64], features: PlanarFeatures, settings: MeshSettings | None = None
) -> PlanarMesh:
    """Make a mesh of planar features.

    Parameters
    ----------
    points : (N, 3) float64
        Metres; those that `features.labels` is about.
    features : PlanarFeatures
    settings : MeshSettings or None
        None for the defaults.

    Returns
    -------
    PlanarMesh

    Notes
    -----
    The border of a feature is drawn to the crease with a neighbour where both come near it, and ends of such
    pieces to corners of three planes. Vertices on a crease are the same for both planes, so that no crack is
    left between them. Where no neighbour was found the border is that of the inliers, and stays open.
    """
    settings = settings or MeshSettings()
    outlines = find_outlines(points, features, settings)
    borders = Borders(outlines, Creases(features, outlines, settings), settings)
    vertices = _Vertices()
    faces, shapes = [], []
    for feature, outline in enumerate(outlines):
        shape, known = _closed(feature, borders, outline.frame)
        shapes.append(shape)
        faces.append(_triangles(shape, known, outline.frame, vertices))
    counts = [len(part) for part in faces]
    joined = np.concatenate(faces) if faces else np.zeros((0, 3), np.int64)
    owner = np.repeat(np.arange(len(outlines)), counts)
    return PlanarMesh(vertices.array(), joined, owner, tuple(shapes), tuple(outlines))


Known = dict[tuple[float, float], tuple[float, float, float]]
"""Points in space of flat coordinates: those of the knots, equal for all planes that share them."""


class _Vertices:
    """Vertices by their coordinates."""

    def __init__(self) -> None:
        self._numbers: dict[tuple[float, float, float], int] = {}

    def number(self, point: tuple[float, float, float]) -> int:
        return self._numbers.setdefault(point, len(self._numbers))

    def array(self) -> NDArray[np.float64]:
        return np.array(list(self._numbers), np.float64).reshape(-1, 3)


def _closed(feature: int, borders: Borders, frame: Frame) -> tuple[shapely.MultiPolygon, Known]:
    """Valid polygons of a feature after its border was drawn to creases."""
    known: Known = {}
    parts: list[shapely.Polygon] = []
    for rings in borders.polygons[feature]:
        drawn = [_flat_ring(feature, stops, borders, frame, known) for stops in rings]
        flat = [ring for ring in drawn if ring]
        if drawn[0]:
            parts += _valid(shapely.Polygon(flat[0], flat[1:]))
    whole = shapely.union_all(parts) if len(parts) > 1 else shapely.MultiPolygon(parts)
    return shapely.MultiPolygon(_polygons(whole)), known


def _flat_ring(
    feature: int, stops: list[Stop], borders: Borders, frame: Frame, known: Known
) -> list[tuple[float, float]]:
    """Coordinates of a ring in its plane, empty where it has collapsed; the knots are put down in `known`."""
    knots = borders.ring(feature, stops)
    if len(set(knots)) < 3:
        return []
    points = np.array([borders.knots.point(knot) for knot in knots])
    flat = [(float(u), float(v)) for u, v in frame.flat(points)]
    known.update({place: tuple(point) for place, point in zip(flat, points.tolist(), strict=True)})
    return flat


def _valid(polygon: shapely.Polygon) -> list[shapely.Polygon]:
    if not polygon.is_valid:
        return _polygons(shapely.make_valid(polygon, method="structure", keep_collapsed=False))
    return _polygons(polygon)


def _polygons(shape: shapely.Geometry) -> list[shapely.Polygon]:
    """Polygons of any geometry that are larger than a sliver."""
    parts = shapely.get_parts(shapely.get_parts(shape))
    return [part for part in parts if part.geom_type == "Polygon" and part.area >= _LEAST_AREA]


def _triangles(
    shape: shapely.MultiPolygon, known: Known, frame: Frame, vertices: _Vertices
) -> NDArray[np.int64]:
    """(F, 3) triangles whose corners are the vertices of the polygons."""
    parts = shapely.get_parts(shape)
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(parts)) if len(parts) else parts
    if not len(triangles):
        return np.zeros((0, 3), np.int64)
    flat = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    first, second = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    clockwise = first[:, 0] * second[:, 1] < first[:, 1] * second[:, 0]
    flat[clockwise] = flat[clockwise][:, ::-1]
    lifted = frame.lifted(flat.reshape(-1, 2)).tolist()
    places = [(float(u), float(v)) for u, v in flat.reshape(-1, 2)]
    numbers = [vertices.number(known.get(p, tuple(q))) for p, q in zip(places, lifted, strict=True)]
    return np.array(numbers, np.int64).reshape(-1, 3)
