"""The height of the ground, a column at a time, found in the scene itself.

Notes
-----
The plan is divided into square columns. The *low* of a column is a lower bound, within one grid step, of the
lowest point of all faces in it (or of the faces that were named as terrain). Neighbouring columns join where
their lows differ by no more than the edge of a column, a slope of 45 degrees. What joins is a *patch*, and
each patch is ground or raised:

* A patch is raised when the sides at which it drops to a lower patch number at least 2 sqrt(n), n being its
  columns. A patch that drops on all sides has at least 4 sqrt(n) such sides, whatever its shape, so the roof
  of a free-standing house is never ground, nor one that others adjoin on up to half of its border. A terrace
  that drops on one or two sides, or a town with wells, is ground.
* Terrain that was named is ground wherever there is some.

Raised columns and columns without any face (holes) have no ground of their own. Each connected region of
them takes the lowest ground beside it, so that a ceiling measured from there is never too high.

References
----------
K. Zhang et al., "A progressive morphological filter for removing nonground measurements from airborne LIDAR
data", IEEE TGRS 41(4), 2003 (the idea of telling ground by drops of height); I. E. Sutherland, G. W. Hodgman,
"Reentrant polygon clipping", CACM 17(1), 1974 (the parts of faces in a column).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tilesnav_ref.cells.columns import EMPTY, column_heights, extremes_under

COLUMN = 2.0
"""Edge of a column, m: about the smallest cell, since a ceiling is never finer than a tile."""
COLUMN_LIMIT = 1 << 22
"""Most columns; their edge is doubled to stay below. 64 MiB of heights."""


@dataclass(frozen=True)
class Ground:
    """Ground heights of columns; beyond the columns, those at the border hold."""

    origin: NDArray[np.int64]
    """(2,) lower corner of column (0, 0), grid."""
    size: int
    """Edge of a column, grid steps."""
    low: NDArray[np.int64]
    """(nx, ny) lower bound of the ground in the column, grid."""
    high: NDArray[np.int64]
    """(nx, ny) upper bound of it; that of the ground beside a region without ground."""
    own: NDArray[np.bool_]
    """(nx, ny) whether ground was found in the column itself."""

    def under(self, boxes: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Least low and greatest high of the columns that the plans of boxes (B, 2, 3) meet; (B,), (B,)."""
        return (
            extremes_under(self.low, self.origin, self.size, boxes)[:, 0],
            extremes_under(self.high, self.origin, self.size, boxes)[:, 1],
        )

    def relief(self, boxes: NDArray[np.int64]) -> NDArray[np.int64]:
        """Difference of the lows below each of the boxes (B, 2, 3); (B,) grid steps."""
        found = extremes_under(self.low, self.origin, self.size, boxes)
        return found[:, 1] - found[:, 0]

    def at(self, points: NDArray[np.int64]) -> NDArray[np.int64]:
        """Low of the column of each point (P, 3); (P,) grid."""
        place = (points[:, :2] - self.origin) // self.size
        place = np.clip(place, 0, np.array(self.low.shape) - 1)
        return np.asarray(self.low[place[:, 0], place[:, 1]])


def find_ground(
    corners: NDArray[np.int64],
    plan: NDArray[np.int64],
    step: float,
    terrain: NDArray[np.bool_] | None = None,
) -> Ground:
    """Find the ground under a part of the plan.

    Parameters
    ----------
    corners
        (F, 3, 3) grid coordinates of the faces.
    plan
        (2, 2) lower and upper corner of the part, grid.
    step
        Metres of a grid step.
    terrain
        (F,) faces that are the ground; None: tell it by the drops of the lowest faces.

    Returns
    -------
    Ground
        Where no face meets the plan, the lowest point of all faces is the ground.
    """
    size = max(math.ceil(COLUMN / step), 1)
    while np.prod((plan[1] - plan[0]) // size + 1, dtype=np.float64) > COLUMN_LIMIT:
        size *= 2
    shape = np.maximum(-(-(plan[1] - plan[0]) // size), 1)  # the plan of an upright face has no width
    chosen = corners if terrain is None else corners[terrain]
    low, high = column_heights(np.ascontiguousarray(chosen), plan[0], size, (int(shape[0]), int(shape[1])))
    found = low != EMPTY
    own = found if terrain is not None else found & level_patches(low, low, found, size)
    if not np.any(own):
        low[:], high[:] = corners[:, :, 2].min(), corners[:, :, 2].min()
    else:
        _fill(low, high, own)
    return Ground(plan[0].copy(), size, low, high, own)


def level_ground(corners: NDArray[np.int64], plan: NDArray[np.int64]) -> Ground:
    """The lowest point of the faces (F, 3, 3) that meet a plan (2, 2), as the ground everywhere."""
    inside = np.all(
        (corners[:, :, :2].max(axis=1) >= plan[0]) & (corners[:, :, :2].min(axis=1) <= plan[1]), axis=1
    )
    chosen = corners[inside] if np.any(inside) else corners
    height = np.full((1, 1), chosen[:, :, 2].min(), np.int64)
    return Ground(plan[0].copy(), int((plan[1] - plan[0]).max()), height, height, np.ones((1, 1), np.bool_))


def level_patches(
    low: NDArray[np.int64], high: NDArray[np.int64], found: NDArray[np.bool_], join: int
) -> NDArray[np.bool_]:
    """Columns of patches that are not raised.

    Parameters
    ----------
    low, high
        (nx, ny) heights of the surface of each column.
    found
        (nx, ny) columns that have one.
    join
        Neighbours belong to one patch where the gap between their heights is at most this.

    Returns
    -------
    ndarray
        (nx, ny) bool.
    """
    numbers = np.arange(low.size).reshape(low.shape)
    along_x, along_y = found[:-1] & found[1:], found[:, :-1] & found[:, 1:]
    first = np.concatenate((numbers[:-1][along_x], numbers[:, :-1][along_y]))
    second = np.concatenate((numbers[1:][along_x], numbers[:, 1:][along_y]))
    drop = low.ravel()[first] - low.ravel()[second]
    gap = np.maximum(low.ravel()[first] - high.ravel()[second], low.ravel()[second] - high.ravel()[first])
    level = gap <= join
    links = coo_array(
        (np.ones(int(level.sum()), np.int8), (first[level], second[level])), shape=(low.size, low.size)
    )
    _, patch = connected_components(links, directed=False)
    higher = np.where(drop > 0, first, second)
    inner = patch[first] == patch[second]  # a drop inside of a patch, which joins around it
    drops = np.bincount(patch[higher[~level & ~inner]], minlength=low.size)
    columns = np.bincount(patch, minlength=low.size)
    raised = drops * drops >= 4 * columns  # drops >= 2 sqrt(columns), in integers
    return np.asarray(~(raised & (drops > 0))[patch].reshape(low.shape))


def _fill(low: NDArray[np.int64], high: NDArray[np.int64], own: NDArray[np.bool_]) -> None:
    """Give every connected region without ground the least low and the greatest high of the ground beside."""
    region, count = label(~own)
    least = np.full(count + 1, np.iinfo(np.int64).max)
    most = np.full(count + 1, np.iinfo(np.int64).min)
    for here, there in (
        (np.s_[:-1], np.s_[1:]),
        (np.s_[1:], np.s_[:-1]),
        (np.s_[:, :-1], np.s_[:, 1:]),
        (np.s_[:, 1:], np.s_[:, :-1]),
    ):
        beside = (region[here] > 0) & own[there]
        np.minimum.at(least, region[here][beside], low[there][beside])
        np.maximum.at(most, region[here][beside], high[there][beside])
    low[~own], high[~own] = least[region[~own]], most[region[~own]]
