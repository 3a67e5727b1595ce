"""Where a ground vehicle can stand: surfaces that carry it, a column at a time.

Notes
-----
A face carries a vehicle when it is no steeper than ``ground_slope``. The heights of all carrying faces over a
column are joined to *stands*: intervals of height between which no gap is higher than ``ground_step``. Two
stands of the same column are storeys, such as a street and the bridge above it.

References
----------
M. Mononen, "Navigation mesh generation via voxelization and watershed partitioning", AiGameDev Paris 2010,
and the library Recast (spans of a height field with a walkable slope and a walkable climb).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.columns import height_range
from tilesnav_ref.kernels import kernel

COLUMN_LIMIT = 1 << 24
"""Most columns; their edge is doubled to stay below. 128 MiB of offsets."""
RELIEF = 4
"""Tiles are halved where the ground under them differs by more than this part of the height of a cell."""


@dataclass(frozen=True)
class Stands:
    """Stands of every column of a plan, from below."""

    origin: NDArray[np.int64]
    """(2,) lower corner of column (0, 0), grid."""
    size: int
    """Edge of a column, grid steps."""
    shape: tuple[int, int]
    """Numbers of columns along x and y."""
    offsets: NDArray[np.int64]
    """(C + 1,) stands of column (i, j) begin at number i * shape[1] + j."""
    low: NDArray[np.int64]
    """(S,) lower end, grid."""
    high: NDArray[np.int64]
    """(S,) upper end, grid."""

    @property
    def column(self) -> NDArray[np.int64]:
        """(S,) column of each stand."""
        return np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets))


def carrying_faces(corners: NDArray[np.int64], slope: float) -> NDArray[np.bool_]:
    """Which faces (F, 3, 3) are no steeper than a slope, rise over run; (F,) bool."""
    edges = (corners[:, 1:] - corners[:, :1]).astype(np.float64)
    normals = np.cross(edges[:, 0], edges[:, 1])
    return np.asarray(np.hypot(normals[:, 0], normals[:, 1]) <= slope * np.abs(normals[:, 2]))


@kernel
def _visit_pieces(
    corners: NDArray[np.int64],
    origin: NDArray[np.int64],
    size: int,
    shape: tuple[int, int],
    pieces: NDArray[np.int64],
) -> int:
    """Count (pieces empty) or write column, low and high of every face over every column that it is in."""
    count, polygon, store = 0, np.empty((8, 3)), len(pieces) > 0
    column, first, last = np.empty((2, 2), np.int64), np.empty(2, np.int64), np.empty(2, np.int64)
    for f in range(len(corners)):
        triangle = corners[f]
        for k in range(2):
            least = min(triangle[0, k], triangle[1, k], triangle[2, k])
            most = max(triangle[0, k], triangle[1, k], triangle[2, k])
            first[k] = max((least - origin[k]) // size, 0)
            last[k] = min((most - origin[k] - 1) // size, shape[k] - 1)
        for i in range(first[0], last[0] + 1):
            for j in range(first[1], last[1] + 1):
                column[0, 0], column[0, 1] = origin[0] + i * size, origin[1] + j * size
                column[1, 0], column[1, 1] = column[0, 0] + size, column[0, 1] + size
                low, high = height_range(triangle, column, polygon)
                if low > high:
                    continue
                if store:
                    pieces[count, 0], pieces[count, 1], pieces[count, 2] = i * shape[1] + j, low, high
                count += 1
    return count


@kernel
def _join_pieces(pieces: NDArray[np.int64], step: int) -> int:
    """Join sorted pieces of a column with gaps of at most a step, in place; returns how many are left."""
    last = -1
    for p in range(len(pieces)):
        if last >= 0 and pieces[last, 0] == pieces[p, 0] and pieces[p, 1] <= pieces[last, 2] + step:
            pieces[last, 2] = max(pieces[last, 2], pieces[p, 2])
        else:
            last += 1
            pieces[last] = pieces[p]
    return last + 1


def find_stands(
    corners: NDArray[np.int64], plan: NDArray[np.int64], size: int, limits: tuple[float, int, int]
) -> Stands:
    """Find the stands over a part of the plan.

    Parameters
    ----------
    corners
        (F, 3, 3) grid coordinates of all faces.
    plan
        (2, 2) lower and upper corner, grid.
    size
        Wanted edge of a column, grid steps; doubled where there would be too many.
    limits
        Slope, rise over run; step; and headroom, grid steps: a stand with another one nearer above it, as is
        the underside of a bridge, is left out.
    """
    size = max(size, 1)
    while np.prod((plan[1] - plan[0]) // size + 1, dtype=np.float64) > COLUMN_LIMIT:
        size *= 2
    extent = -(-(plan[1] - plan[0]) // size)
    shape = int(extent[0]), int(extent[1])
    carriers = np.ascontiguousarray(corners[carrying_faces(corners, limits[0])])
    count = _visit_pieces(carriers, plan[0], size, shape, np.empty((0, 3), np.int64))
    pieces = np.empty((count, 3), np.int64)
    if count:
        _visit_pieces(carriers, plan[0], size, shape, pieces)
        pieces = pieces[np.lexsort((pieces[:, 2], pieces[:, 1], pieces[:, 0]))]
        pieces = pieces[: _join_pieces(pieces, limits[1])]
        low_roof = (pieces[1:, 0] == pieces[:-1, 0]) & (pieces[1:, 1] < pieces[:-1, 2] + limits[2])
        pieces = pieces[np.append(~low_roof, True)]
    offsets = np.searchsorted(pieces[:, 0], np.arange(shape[0] * shape[1] + 1))
    return Stands(
        plan[0].copy(), size, shape, offsets.astype(np.int64), pieces[:, 1].copy(), pieces[:, 2].copy()
    )


@kernel
def column_range(low: int, high: int, origin: int, size: int, count: int) -> tuple[int, int]:
    """First and last column along one axis that the open interval (low, high) meets; empty when first >
    last."""
    return max((low - origin) // size, 0), min((high - origin - 1) // size, count - 1)


@kernel
def _levels(
    box: NDArray[np.int64],
    frame: tuple[NDArray[np.int64], int, tuple[int, int]],
    table: tuple[NDArray[np.int64], NDArray[np.int64]],
    height: int,
    room: NDArray[np.int64],
) -> tuple[int, int]:
    """Least lows of the storeys under a tile, ``height`` apart, written to room; their number and relief.

    Room is (R,) and must hold every stand under the tile.
    """
    origin, size, shape = frame
    offsets, low = table
    i0, i1 = column_range(box[0, 0], box[1, 0], origin[0], size, shape[0])
    j0, j1 = column_range(box[0, 1], box[1, 1], origin[1], size, shape[1])
    count = 0
    for i in range(i0, i1 + 1):
        for j in range(j0, j1 + 1):
            column = i * shape[1] + j
            for s in range(offsets[column], offsets[column + 1]):
                room[count] = low[s]
                count += 1
    room[:count].sort()
    levels, relief = 0, 0
    for s in range(count):
        if levels and room[s] < room[levels - 1] + height:
            relief = max(relief, room[s] - room[levels - 1])
        else:
            room[levels] = room[s]
            levels += 1
    return levels, relief


@kernel
def _floor(
    box: NDArray[np.int64],
    frame: tuple[NDArray[np.int64], int, tuple[int, int]],
    table: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]],
    lows: tuple[int, int],
) -> int:
    """Highest end of the stands under a tile that begin in a range of heights; its least without any."""
    origin, size, shape = frame
    offsets, low, high = table
    i0, i1 = column_range(box[0, 0], box[1, 0], origin[0], size, shape[0])
    j0, j1 = column_range(box[0, 1], box[1, 1], origin[1], size, shape[1])
    result = lows[0]
    for i in range(i0, i1 + 1):
        for j in range(j0, j1 + 1):
            for s in range(offsets[i * shape[1] + j], offsets[i * shape[1] + j + 1]):
                if lows[0] <= low[s] <= lows[1]:
                    result = max(result, high[s])
    return result


@kernel
def _tile_roots(
    tiles: NDArray[np.int64],
    frame: tuple[NDArray[np.int64], int, tuple[int, int]],
    table: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]],
    sizes: tuple[int, int, int],
    found: NDArray[np.int64],
) -> int:
    """Roots of the tiles (T, 2, 3), one for every storey under each; only counted where found is empty.

    ``sizes`` are the height of the cells, the smallest edge of a tile, and the clearance.
    """
    height, smallest, clearance = sizes
    tolerance, most = height // RELIEF, height - smallest - clearance
    room, stack = np.empty(max(len(table[1]), 1), np.int64), np.empty((64, 2, 3), np.int64)
    count, store = 0, len(found) > 0
    for t in range(len(tiles)):
        stack[0], top = tiles[t], 1
        while top > 0:
            top -= 1
            box = stack[top].copy()
            levels, relief = _levels(box, frame, (table[0], table[1]), height, room)
            axis = 0 if box[1, 0] - box[0, 0] >= box[1, 1] - box[0, 1] else 1
            if relief > tolerance and box[1, axis] - box[0, axis] >= 2 * smallest:
                middle = (box[0, axis] + box[1, axis]) >> 1
                stack[top + 1] = box
                stack[top, 1, axis] = middle
                stack[top + 1, 0, axis] = middle
                top += 2
                continue
            if relief > most:
                levels, relief = _levels(box, frame, (table[0], table[1]), tolerance + 1, room)
            for s in range(levels):
                if store:
                    found[count], end = box, room[s] + height
                    box[0] -= clearance
                    box[1] += clearance
                    lows = (room[s] - tolerance, room[s] + max(relief, tolerance))
                    found[count, 0, 2] = max(room[s], _floor(box, frame, table, lows)) + clearance
                    found[count, 1, 2] = min(end, room[s + 1]) if s + 1 < levels else end
                    box[0] += clearance
                    box[1] -= clearance
                count += 1
    return count


def ground_roots(roots: NDArray[np.int64], stands: Stands, sizes: tuple[int, int, int]) -> NDArray[np.int64]:
    """Roots over the stands.

    Parameters
    ----------
    roots
        (R, 2, 3) roots of the domain; their plans are the tiles.
    stands
        Where vehicles stand.
    sizes
        Height of the cells above the lowest stand of their storey, smallest edge of a cell, and clearance,
        grid steps.

    Returns
    -------
    ndarray
        (R', 2, 3) int64, disjoint. A root ends ``height`` above the lowest stand of its storey, so that no
        point of it is higher than that above any of them, and begins at the clearance above the highest one,
        so that roots along a slope touch. Where the stands differ by more than a quarter of the height, tiles
        are halved down to the smallest edge; a smallest tile whose stands leave no room for a cell takes a
        storey for every quarter.
    """
    plans = roots.copy()
    plans[:, :, 2] = 0
    tiles = np.unique(plans.reshape(-1, 6), axis=0).reshape(-1, 2, 3)
    frame, table = (stands.origin, stands.size, stands.shape), (stands.offsets, stands.low, stands.high)
    count = _tile_roots(tiles, frame, table, sizes, np.empty((0, 2, 3), np.int64))
    found = np.empty((count, 2, 3), np.int64)
    if count:
        _tile_roots(tiles, frame, table, sizes, found)
    return found[found[:, 1, 2] - found[:, 0, 2] >= sizes[1]]
