"""Least and greatest heights of faces over the square columns of a plan.

References
----------
I. E. Sutherland, G. W. Hodgman, "Reentrant polygon clipping", Communications of the ACM 17(1), 1974.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel

EMPTY = 1 << 40
"""Low of a column without a face; above every grid coordinate."""
_CLIP_ERROR = 2.0**-10
"""Grid steps; an interpolated height is off by less than 2**-26: coordinates below 2**24, a handful of
roundings of 2**-53."""
_CORNERS = 8
"""A triangle clipped by four lines has at most seven corners."""


@kernel
def _clip_side(polygon: NDArray[np.float64], count: int, cut: tuple[int, float, float]) -> int:
    """Cut a convex polygon (8, 3) in place to the side of a line; returns the corners that are left.

    ``cut`` is axis, place and sign: kept is sign * (coordinate - place) >= 0.
    """
    axis, place, sign = cut
    result, kept = np.empty((_CORNERS, 3)), 0
    for c in range(count):
        d = (c + 1) % count
        here, there = sign * (polygon[c, axis] - place), sign * (polygon[d, axis] - place)
        if here >= 0.0:
            result[kept] = polygon[c]
            kept += 1
        if (here > 0.0 and there < 0.0) or (here < 0.0 and there > 0.0):
            share = here / (here - there)
            for k in range(3):
                result[kept, k] = polygon[c, k] + share * (polygon[d, k] - polygon[c, k])
            kept += 1
    polygon[:kept] = result[:kept]
    return kept


@kernel
def height_range(
    triangle: NDArray[np.int64], column: NDArray[np.int64], polygon: NDArray[np.float64]
) -> tuple[int, int]:
    """Bounds of the heights of a triangle (3, 3) over a closed column (2, 2); (1, 0) where it is not there.

    ``polygon`` (8, 3) is room.
    """
    for k in range(2):
        most = max(triangle[0, k], triangle[1, k], triangle[2, k])
        least = min(triangle[0, k], triangle[1, k], triangle[2, k])
        if most < column[0, k] or least > column[1, k]:
            return 1, 0
    for c in range(3):
        for k in range(3):
            polygon[c, k] = triangle[c, k]
    count = 3
    for k in range(2):
        count = _clip_side(polygon, count, (k, float(column[0, k]), 1.0))
        count = _clip_side(polygon, count, (k, float(column[1, k]), -1.0))
        if count == 0:
            return 1, 0
    low, high = polygon[0, 2], polygon[0, 2]
    for c in range(1, count):
        low, high = min(low, polygon[c, 2]), max(high, polygon[c, 2])
    least = min(triangle[0, 2], triangle[1, 2], triangle[2, 2])
    most = max(triangle[0, 2], triangle[1, 2], triangle[2, 2])
    return max(least, math.floor(low - _CLIP_ERROR)), min(most, math.ceil(high + _CLIP_ERROR))


@kernel
def _visit_columns(
    corners: NDArray[np.int64],
    origin: NDArray[np.int64],
    size: int,
    low: NDArray[np.int64],
    high: NDArray[np.int64],
) -> None:
    """Lower the lows (high empty), or raise the highs by faces that begin near the low."""
    shape, polygon = low.shape, np.empty((_CORNERS, 3))
    column, first, last = np.empty((2, 2), np.int64), np.empty(2, np.int64), np.empty(2, np.int64)
    second_pass = len(high) > 0
    for f in range(len(corners)):
        triangle = corners[f]
        for k in range(2):
            least = min(triangle[0, k], triangle[1, k], triangle[2, k])
            most = max(triangle[0, k], triangle[1, k], triangle[2, k])
            first[k] = max((least - origin[k] - 1) // size, 0)  # a face on a border is in both columns
            last[k] = min((most - origin[k]) // size, shape[k] - 1)
        for i in range(first[0], last[0] + 1):
            for j in range(first[1], last[1] + 1):
                column[0, 0], column[0, 1] = origin[0] + i * size, origin[1] + j * size
                column[1, 0], column[1, 1] = column[0, 0] + size, column[0, 1] + size
                least, most = height_range(triangle, column, polygon)
                if least > most:
                    continue
                if not second_pass:
                    low[i, j] = min(low[i, j], least)
                elif least <= low[i, j] + size and most <= low[i, j] + 2 * size:
                    # walls and roofs begin or end higher: ground up to 45 degrees rises by 1.5 sizes at most
                    high[i, j] = max(high[i, j], most)


def column_heights(
    corners: NDArray[np.int64], origin: NDArray[np.int64], size: int, shape: tuple[int, int]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Heights of the lowest faces of every column.

    Parameters
    ----------
    corners
        (F, 3, 3) grid coordinates.
    origin
        (2,) lower corner of the columns.
    size
        Their edge, grid steps.
    shape
        Their numbers along x and y.

    Returns
    -------
    low, high
        (nx, ny) int64. Low is at most the lowest point of any face over the closed column, by less than two
        steps; EMPTY where no face is. High is at least the highest point of the faces that begin within one
        edge above the low and end within two, so of ground that is no steeper than 45 degrees.
    """
    low = np.full(shape, EMPTY, np.int64)
    _visit_columns(corners, origin, size, low, np.empty((0, 0), np.int64))
    high = low.copy()
    _visit_columns(corners, origin, size, low, high)
    return low, high


@kernel
def _extremes(
    heights: NDArray[np.int64], origin: NDArray[np.int64], size: int, boxes: NDArray[np.int64]
) -> NDArray[np.int64]:
    result = np.empty((len(boxes), 2), np.int64)
    first, last = np.empty(2, np.int64), np.empty(2, np.int64)
    for b in range(len(boxes)):
        for k in range(2):
            limit = heights.shape[k] - 1
            first[k] = min(max((boxes[b, 0, k] - origin[k]) // size, 0), limit)
            last[k] = min(max((boxes[b, 1, k] - origin[k] - 1) // size, 0), limit)
        part = heights[first[0] : last[0] + 1, first[1] : last[1] + 1]
        result[b, 0], result[b, 1] = part.min(), part.max()
    return result


def extremes_under(
    heights: NDArray[np.int64], origin: NDArray[np.int64], size: int, boxes: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Least and greatest of the heights (nx, ny) of the columns that the open plans of boxes (B, 2, 3) meet;
    (B, 2) int64."""
    return np.asarray(_extremes(heights, origin, size, np.ascontiguousarray(boxes)))
