"""The second condition of the parity theorem: what an occluder keeps off.

Two convex polytopes without a common point are divided by a plane that is parallel to a facet of one of them
or to an edge of each (the edges of a flat one, and a direction across it, count as well). So finitely many
directions decide; each is given by two vectors, and a height over it is a determinant.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator.shafts import box_corners
from tilesnav_validator.signs import SignArray, determinant

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

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
    return _by_directions(triangles, box_corners(low, high), apart, closed=False)


def keep_off_closed_boxes(triangles: IntArray, low: IntArray, high: IntArray) -> BoolArray:
    """Which triangles meet no point of a closed box, which may be flat across one axis."""
    apart = np.asarray(((triangles.max(axis=1) < low) | (triangles.min(axis=1) > high)).any(axis=1))
    return _by_directions(triangles, box_corners(low, high), apart, closed=True)


def keep_off_triangles(triangles: IntArray, others: IntArray) -> BoolArray:
    """Which triangles meet no point of the relative interior of another one, shape (k, 3, 3) as well."""
    low, high = others.min(axis=1), others.max(axis=1)
    flat = low == high
    above, below = triangles.min(axis=1), triangles.max(axis=1)
    apart = np.where(flat, (below < low) | (above > high), (below <= low) | (above >= high)).any(axis=1)
    return _by_directions(triangles, others, np.asarray(apart), closed=False)


def _by_directions(triangles: IntArray, others: IntArray, apart: BoolArray, *, closed: bool) -> BoolArray:
    """Complete ``apart``, which says what the axes have divided already."""
    left = np.flatnonzero(~apart)
    for first in range(0, len(left), _CHUNK):
        part = left[first : first + _CHUNK]
        apart[part] = _divided(triangles[part], others[part], closed=closed)
    return apart


def _edges(triangles: IntArray) -> list[IntArray]:
    return [triangles[:, (i + 1) % 3] - triangles[:, i] for i in range(3)]


def _divided(triangles: IntArray, others: IntArray, *, closed: bool) -> BoolArray:
    """Which pairs a plane of one of the directions divides."""
    mine = _edges(triangles)
    directions: list[tuple[IntArray, IntArray]] = [(mine[0], mine[1])]
    axes = [np.broadcast_to(axis, mine[0].shape) for axis in AXES]
    directions += [(edge, axis) for edge in mine for axis in axes]
    if others.shape[1] == 3:
        theirs = _edges(others)
        directions.append((theirs[0], theirs[1]))
        directions += [(one, other) for one in mine for other in theirs]
        directions += [(edge, axis) for edge in theirs for axis in axes]
    apart = np.zeros(len(triangles), dtype=bool)
    for one, other in directions:
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
