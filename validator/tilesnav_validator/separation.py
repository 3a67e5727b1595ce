"""The second condition of the parity theorem: what an occluder keeps off.

Two convex polytopes without a common point are divided by a plane that is parallel to a facet of one of them
or to an edge of each (the edges of a flat one, and a direction across it, count as well). So finitely many
directions decide; each is given by two vectors, and a height over it is a determinant.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator.prisms import box_corners
from tilesnav_validator.signs import SignArray, determinant

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

Direction = tuple[IntArray, IntArray]
DirectionsOf = Callable[[list[IntArray], IntArray], list[Direction]]
"""From the edges of the triangles and the corners of the others."""

AXES = np.eye(3, dtype=np.int64)
_CHUNK = 2**14
"""Pairs that are looked at together: a few megabytes for each array of signs."""


def keep_off_open_boxes(triangles: IntArray, low: IntArray, high: IntArray) -> BoolArray:
    """Which triangles meet no point of an open box.

    Parameters
    ----------
    triangles : ndarray of int64, shape (k, 3, 3)
    low, high : ndarray of int64, shape (k, 3)
    """
    apart = np.asarray(((triangles.max(axis=1) <= low) | (triangles.min(axis=1) >= high)).any(axis=1))
    return _by_directions((triangles, box_corners(low, high)), apart, _of_boxes, closed=False)


def keep_off_open_prisms(triangles: IntArray, corners: IntArray) -> BoolArray:
    """Which triangles meet no point of an open prism, its corners given, shape (k, 8, 3)."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    apart = np.asarray(((triangles.max(axis=1) <= low) | (triangles.min(axis=1) >= high)).any(axis=1))
    return _by_directions((triangles, corners), apart, _of_prisms, closed=False)


def keep_off_closed_boxes(triangles: IntArray, low: IntArray, high: IntArray) -> BoolArray:
    """Which triangles meet no point of a closed box, which may be flat across one axis."""
    apart = np.asarray(((triangles.max(axis=1) < low) | (triangles.min(axis=1) > high)).any(axis=1))
    return _by_directions((triangles, box_corners(low, high)), apart, _of_boxes, closed=True)


def keep_off_triangles(triangles: IntArray, others: IntArray) -> BoolArray:
    """Which triangles meet no point of the relative interior of another one, shape (k, 3, 3) as well."""
    low, high = others.min(axis=1), others.max(axis=1)
    flat = low == high
    above, below = triangles.min(axis=1), triangles.max(axis=1)
    apart = np.where(flat, (below < low) | (above > high), (below <= low) | (above >= high)).any(axis=1)
    return _by_directions((triangles, others), np.asarray(apart), _of_triangles, closed=False)


def _by_directions(
    pairs: tuple[IntArray, IntArray], apart: BoolArray, directions: DirectionsOf, *, closed: bool
) -> BoolArray:
    """Complete ``apart``, which says what the axes have divided already."""
    left = np.flatnonzero(~apart)
    for first in range(0, len(left), _CHUNK):
        part = left[first : first + _CHUNK]
        apart[part] = _divided(pairs[0][part], pairs[1][part], directions, closed=closed)
    return apart


def _edges(triangles: IntArray) -> list[IntArray]:
    return [triangles[:, (i + 1) % 3] - triangles[:, i] for i in range(3)]


def _along_axes(edges: list[IntArray]) -> list[Direction]:
    return [(edge, np.broadcast_to(axis, edge.shape)) for edge in edges for axis in AXES]


def _of_boxes(mine: list[IntArray], _: IntArray) -> list[Direction]:
    """Directions of edges of a triangle and those of a box; its facets have been looked at."""
    return _along_axes(mine)


def _of_prisms(mine: list[IntArray], corners: IntArray) -> list[Direction]:
    """The same of prisms, and directions of their facets.

    Edges that are parallel to an axis have one direction; the four along the run axis have two, and that of
    the first corner and that of the last are not the same.
    """
    first = [corners[:, 1 << axis] - corners[:, 0] for axis in range(3)]
    last = [corners[:, 7] - corners[:, 7 - (1 << axis)] for axis in range(3)]
    facets = [(some[i], some[j]) for some in (first, last) for i, j in ((0, 1), (1, 2), (2, 0))]
    return facets + [(one, other) for one in mine for other in (*first, *last)]


def _of_triangles(mine: list[IntArray], others: IntArray) -> list[Direction]:
    """Directions of the other triangle, of edges of both, and across edges of both."""
    theirs = _edges(others)
    both = [(one, other) for one in mine for other in theirs]
    return [(theirs[0], theirs[1]), *_along_axes(mine), *both, *_along_axes(theirs)]


def _divided(
    triangles: IntArray, others: IntArray, directions: DirectionsOf, *, closed: bool
) -> BoolArray:
    """Which pairs a plane of one of the directions divides."""
    mine = _edges(triangles)
    apart = np.zeros(len(triangles), dtype=bool)
    for one, other in ((mine[0], mine[1]), *directions(mine, others)):
        left = np.flatnonzero(~apart)
        between = triangles[left][:, :, None] - others[left][:, None]
        signs = determinant(one[left][:, None, None], other[left][:, None, None], between)
        apart[left] = _on_one_side(signs, closed=closed) | _on_one_side(-signs, closed=closed)
    return apart


def _on_one_side(signs: SignArray, *, closed: bool) -> BoolArray:
    """Whether a plane divides, from the signs of all differences of corners, shape (k, 3, m).

    A closed set has to be strictly beyond. An open one may touch the plane but not lie in it: for each corner
    of the triangle there is a corner of the other that is not at the same height.
    """
    if closed:
        return np.asarray((signs > 0).all(axis=(1, 2)))
    apart = np.asarray((signs > 0).any(axis=2))
    return np.asarray((signs >= 0).all(axis=(1, 2)) & apart.all(axis=1))
