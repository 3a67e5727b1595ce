"""Cells as polyhedra: vertices and facets of many intersections of half-spaces at once."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

SAFE_DETERMINANT = 1e-6
"""Three planes whose unit normals span less volume are taken to have no common point. A point of such planes
2^13 m from the origin would be off by 2^13 * 2^-53 / 1e-6 = 1e-6 m, which is a tenth of the tolerance for a
step of 1 mm."""

CONE_ANGLE = 1e-9
"""Directions that stay within six half-spaces up to this sine count as going to infinity: a cell two steps
of 1 mm wide would have to be 2,000 km long to be taken for unbounded."""


@dataclass(frozen=True)
class Polyhedra:
    """Vertices and facets of n polyhedra of p planes.

    Attributes
    ----------
    planes : ndarray of float64, shape (n, p, 4)
    points : ndarray of float64, shape (n, t, 3)
        Meeting points of each three planes; where ``real`` is false a repetition of a vertex, or 0 if there
        is none.
    real : ndarray of bool, shape (n, t)
        Points that are vertices.
    triples : ndarray of int64, shape (t, 3)
    """

    planes: FloatArray
    points: FloatArray
    real: BoolArray
    triples: NDArray[np.int64]

    @property
    def low(self) -> FloatArray:
        """Lower corners of the bounding boxes, shape (n, 3)."""
        return np.asarray(self.points.min(axis=1))

    @property
    def high(self) -> FloatArray:
        """Upper corners of the bounding boxes, shape (n, 3)."""
        return np.asarray(self.points.max(axis=1))

    @property
    def corners(self) -> FloatArray:
        """Vertices without most of the repetitions, shape (n, v, 3)."""
        order = np.argsort(~self.real, axis=1, kind="stable")
        most = max(1, int(self.real.sum(axis=1).max(initial=1)))
        return np.take_along_axis(self.points, order[:, :most, None], axis=1)

    def facet(self, cells: NDArray[np.int64], plane: NDArray[np.int64]) -> FloatArray:
        """Corners of chosen facets in order around them, shape (k, q, 3); some are repeated.

        Parameters
        ----------
        cells, plane : ndarray of int64, shape (k,)
            Which polyhedron, and which of its planes.
        """
        on_plane = np.array(
            [np.flatnonzero((self.triples == p).any(axis=1)) for p in range(self.planes.shape[1])]
        )
        chosen = on_plane[plane]
        points = self.points[cells[:, None], chosen]
        real = self.real[cells[:, None], chosen]
        return _around(_fill(points, real), self.planes[cells, plane, :3])


def _fill(points: FloatArray, real: BoolArray) -> FloatArray:
    """Replace what is no vertex by the first vertex of the same row, or by 0."""
    rows = np.arange(len(points))
    first = points[rows, real.argmax(axis=1)] * np.asarray(real.any(axis=1))[:, None]
    return np.where(real[..., None], points, first[:, None])


def _around(points: FloatArray, normals: FloatArray) -> FloatArray:
    """Sort the corners of convex polygons by angle around their centres."""
    centre = points.mean(axis=1, keepdims=True)
    helper = np.eye(3)[np.abs(normals).argmin(axis=1)]
    u = np.cross(normals, helper)
    v = np.cross(normals, u)
    offset = points - centre
    angle = np.arctan2(np.einsum("kqi,ki->kq", offset, v), np.einsum("kqi,ki->kq", offset, u))
    order = angle.argsort(axis=1, kind="stable")
    return np.take_along_axis(points, order[..., None], axis=1)


def build(planes: FloatArray, tolerance: float) -> Polyhedra:
    """Find the vertices of polyhedra.

    Parameters
    ----------
    planes : ndarray of float64, shape (n, p, 4)
        Inside is ``n.x + d <= 0``; unit normals, nav frame, metres.
    tolerance : float
        Distance in metres by which a vertex may be outside a plane.
    """
    triples = np.array(list(combinations(range(planes.shape[1]), 3)), dtype=np.int64)
    points, solved = meet(planes, triples)
    outside = np.einsum("nti,npi->ntp", points, planes[..., :3]) + planes[:, None, :, 3]
    real = solved & (outside.max(axis=2) <= tolerance)
    return Polyhedra(planes, _fill(points, real), real, triples)


def meet(planes: FloatArray, triples: NDArray[np.int64]) -> tuple[FloatArray, BoolArray]:
    """Meeting points of triples of planes by Cramer's rule, shape (n, t, 3), and which triples have one."""
    first, second, third = (planes[:, triples[:, i]] for i in range(3))
    cross_23 = np.cross(second[..., :3], third[..., :3])
    cross_31 = np.cross(third[..., :3], first[..., :3])
    cross_12 = np.cross(first[..., :3], second[..., :3])
    determinant = np.einsum("nti,nti->nt", first[..., :3], cross_23)
    solved = np.abs(determinant) > SAFE_DETERMINANT
    total = first[..., 3:] * cross_23 + second[..., 3:] * cross_31 + third[..., 3:] * cross_12
    return -total / np.where(solved, determinant, 1.0)[..., None], solved


def unbounded(planes: FloatArray) -> BoolArray:
    """Which intersections of half-spaces are unbounded (or would be, were they not empty), shape (n,).

    Notes
    -----
    The recession cone {v : n_i.v <= 0} holds more than 0 exactly if it holds the meeting line of two planes,
    in one direction or the other, or if all normals are parallel.
    """
    normals = planes[..., :3]
    pairs = np.array(list(combinations(range(planes.shape[1]), 2)))
    lines = np.cross(normals[:, pairs[:, 0]], normals[:, pairs[:, 1]])
    length = np.linalg.norm(lines, axis=2)
    proper = length > CONE_ANGLE
    along = np.einsum("nli,npi->nlp", lines / np.where(proper, length, 1)[..., None], normals)
    escapes = proper & ((along.max(axis=2) <= CONE_ANGLE) | (along.min(axis=2) >= -CONE_ANGLE))
    return np.asarray(escapes.any(axis=1) | ~proper.any(axis=1))


def holds_ball(planes: FloatArray, radius: float | FloatArray, tolerance: float) -> BoolArray:
    """Which bounded polyhedra hold a ball: those that are not empty when every plane is moved in by its
    radius.

    Parameters
    ----------
    planes : ndarray of float64, shape (n, p, 4)
    radius : float or ndarray of float64, shape (n,)
    tolerance : float
        See ``build``.
    """
    moved = planes.copy()
    moved[..., 3] += np.reshape(radius, (-1, 1))
    return np.asarray(build(moved, tolerance).real.any(axis=1))


def largest_ball(planes: FloatArray, above: float, tolerance: float) -> FloatArray:
    """Radius of the largest ball by bisection; negative for an empty polyhedron, shape (n,).

    Parameters
    ----------
    above : float
        A radius in metres that no ball reaches.
    """
    low, high = np.full(len(planes), -above), np.full(len(planes), above)
    for _ in range(48):
        middle = (low + high) / 2
        holds = holds_ball(planes, middle, tolerance)
        low, high = np.where(holds, middle, low), np.where(holds, high, middle)
    return low


def polygon_area(corners: FloatArray) -> FloatArray:
    """Area of planar polygons with corners in order, shape (..., q, 3) -> (...)."""
    spokes = corners - corners[..., :1, :]
    vectors = np.cross(spokes[..., 1:-1, :], spokes[..., 2:, :]).sum(axis=-2)
    return np.asarray(np.linalg.norm(vectors, axis=-1) / 2)
