"""The first condition of the parity theorem: no segment from a part of a region to a part of a target meets
an edge.

A part of the region is an open prism, most often a box; a part of the target is a triangle (without its
border) or a closed box. Each test excludes the line or the segment of an edge for sure; an edge that passes
none of them is *open*.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator.prisms import box_corners
from tilesnav_validator.signs import BLUR, determinant, filtered, turn

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

Bounds = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]

_CHUNK = 2**14
"""Pairs of edge and leaf whose 24 or 64 determinants are computed at once: some ten megabytes an array."""


@dataclass(frozen=True)
class Parts:
    """Parts of k leaves, in units.

    Attributes
    ----------
    corners : ndarray of int64, shape (k, 8, 3)
        Of the open prisms of the region; corner i is on the upper side of axis j where bit j of i is set.
    target : ndarray of int64, shape (k, 3, 3) or (k, 8, 3)
        Corners of the triangles, or of the closed boxes, of the target.
    """

    corners: IntArray
    target: IntArray

    @cached_property
    def low(self) -> IntArray:
        """Least coordinates of the prisms, shape (k, 3)."""
        return np.asarray(self.corners.min(axis=1))

    @cached_property
    def high(self) -> IntArray:
        """Greatest coordinates of the prisms, shape (k, 3)."""
        return np.asarray(self.corners.max(axis=1))

    @cached_property
    def slanted(self) -> BoolArray:
        """Prisms that are not boxes, shape (k,)."""
        return np.asarray((self.corners != box_corners(self.low, self.high)).any(axis=(1, 2)))

    def take(self, chosen: IntArray | BoolArray) -> Parts:
        """Some of the leaves."""
        return Parts(self.corners[chosen], self.target[chosen])


BoundsOf = Callable[[Parts, IntArray, IntArray], Bounds]


def open_edges(parts: Parts, leaf: IntArray, start: IntArray, end: IntArray) -> IntArray:
    """Indices of the edges that no test clears.

    Parameters
    ----------
    parts : Parts
    leaf : ndarray of int64, shape (e,)
        Leaf that each edge is judged for.
    start, end : ndarray of int64, shape (e, 3)
        Ends of the edges, in units.
    """
    left = np.flatnonzero(~_beside(parts, leaf, start, end))
    for test in (_past_lines, _behind_target, _past_segments):
        left = left[~test(parts, leaf[left], start[left], end[left])]
    return left


def _beside(parts: Parts, leaf: IntArray, start: IntArray, end: IntArray) -> BoolArray:
    """Edges that a plane perpendicular to an axis divides from both parts."""
    low = np.minimum(parts.low, parts.target.min(axis=1))
    high = np.maximum(parts.high, parts.target.max(axis=1))
    below = np.maximum(start, end) <= low[leaf]
    above = np.minimum(start, end) >= high[leaf]
    return np.asarray((below | above).any(axis=1))


def _past_lines(parts: Parts, leaf: IntArray, start: IntArray, end: IntArray) -> BoolArray:
    """Edges that a line through like corners of both rectangles divides from them, in the view along an
    axis."""
    boxes = (parts.low, parts.high), (parts.target.min(axis=1), parts.target.max(axis=1))
    cleared = np.zeros(len(leaf), dtype=bool)
    for x, y in ((0, 1), (1, 2), (2, 0)):
        for one, other in ((0, 0), (0, 1), (1, 0), (1, 1)):
            near_x, near_y = boxes[0][one][:, x], boxes[0][other][:, y]
            along_x, along_y = boxes[1][one][:, x] - near_x, boxes[1][other][:, y] - near_y
            side = np.zeros((2, len(near_x)), dtype=bool)
            for box in boxes:
                for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
                    found = turn(along_x, along_y, box[i][:, x] - near_x, box[j][:, y] - near_y)
                    side |= found < 0, found > 0
            # One side only; with equal corners there is no line, and no sign either.
            usable = side[0] != side[1]
            left = np.flatnonzero(usable[leaf] & ~cleared)
            at = leaf[left]
            away = np.where(side[0][at], 1, -1)
            beyond = np.ones(len(left), dtype=bool)
            for point in (start, end):
                px, py = point[left, x] - near_x[at], point[left, y] - near_y[at]
                beyond &= turn(along_x[at], along_y[at], px, py) * away >= 0
            cleared[left[beyond]] = True
    return cleared


def _behind_target(parts: Parts, leaf: IntArray, start: IntArray, end: IntArray) -> BoolArray:
    """Edges on the far side of the plane of a triangle, or in it."""
    if parts.target.shape[1] != 3:
        return np.zeros(len(leaf), dtype=bool)
    base = parts.target[:, 0]
    one, two = parts.target[:, 1] - base, parts.target[:, 2] - base
    signs = determinant(one[:, None], two[:, None], parts.corners - base[:, None])
    # All zero are the signs of a triangle without area only; then least and most are 0, and so is the side.
    least, most = signs.min(axis=1).astype(np.int64), signs.max(axis=1).astype(np.int64)
    side = np.where(least * most < 0, 0, least + most)
    cleared = side[leaf] != 0
    for point in (start, end):
        cleared &= determinant(one[leaf], two[leaf], point - base[leaf]) * side[leaf] <= 0
    return np.asarray(cleared)


def _past_segments(parts: Parts, leaf: IntArray, start: IntArray, end: IntArray) -> BoolArray:
    """Edges whose lines all segments pass on one side."""
    cleared = np.zeros(len(leaf), dtype=bool)
    slanted = parts.slanted[leaf]
    for kind, bounds in ((~slanted, _box_bounds), (slanted, _prism_bounds)):
        rows = np.flatnonzero(kind)
        for first in range(0, len(rows), _CHUNK):
            part = rows[first : first + _CHUNK]
            cleared[part] = _one_sided(parts.take(leaf[part]), start[part], end[part], bounds)
    return cleared


def _one_sided(parts: Parts, start: IntArray, end: IntArray, bounds: BoundsOf) -> BoolArray:
    """``_past_segments`` for one edge a leaf: by bounds over the prism, and corner by corner where they do
    not tell."""
    least, most, error = bounds(parts, start, end)
    error = error.max(axis=1)
    least, most = least.min(axis=1), most.max(axis=1)
    cleared = (least > error) | (most < -error)
    unsure = np.flatnonzero(~cleared & ~((least < -error) & (most > error)))
    few = parts.take(unsure)
    along, towards = end[unsure] - start[unsure], few.target - start[unsure][:, None]
    outward = few.corners - start[unsure][:, None]
    signs = determinant(along[:, None, None], outward[:, :, None], towards[:, None])
    weak = (signs >= 0).all(axis=(1, 2)) | (signs <= 0).all(axis=(1, 2))
    cleared[unsure] = weak & signs.any(axis=(1, 2))
    return np.asarray(cleared)


def _box_bounds(parts: Parts, start: IntArray, end: IntArray) -> Bounds:
    """Least and greatest determinant over a box for each corner of the target, shape (k, m), in float64,
    and bounds of the errors.

    Notes
    -----
    det(q - p, c - p, t - p) is the scalar product of c - p with n = (t - p) x (q - p); over the box each term
    takes its extremes by itself. Roundings are as many as in a determinant by its definition.
    """
    along = (end - start).astype(np.float64)[:, None]
    towards = (parts.target - start[:, None]).astype(np.float64)
    # The first and the last corner of a box have its bounds.
    low = (parts.corners[:, 0] - start).astype(np.float64)[:, None]
    high = (parts.corners[:, 7] - start).astype(np.float64)[:, None]
    least = np.zeros(towards.shape[:2])
    most, size = least.copy(), least.copy()
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        left, right = towards[..., j] * along[..., k], towards[..., k] * along[..., j]
        one, two = (left - right) * low[..., i], (left - right) * high[..., i]
        least += np.minimum(one, two)
        most += np.maximum(one, two)
        size += (np.abs(left) + np.abs(right)) * np.maximum(np.abs(low[..., i]), np.abs(high[..., i]))
    return least, most, size * BLUR


def _prism_bounds(parts: Parts, start: IntArray, end: IntArray) -> Bounds:
    """The same over a prism, by its corners."""
    along = (end - start).astype(np.float64)[:, None, None]
    towards = (parts.target - start[:, None]).astype(np.float64)[:, :, None]
    outward = (parts.corners - start[:, None]).astype(np.float64)[:, None]
    value, error = filtered(outward, towards, along)
    return value.min(axis=2), value.max(axis=2), error.max(axis=2)
