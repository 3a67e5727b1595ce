"""Where a point lies: the cell around it, or the nearest one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.reader import NavTileset

SLACK = 1e-6
"""m; a point this far outside of a plane still counts as in the cell: rounding of coordinates of kilometres
in float64 and of what people type, and far below the step of the grid."""


@dataclass(frozen=True)
class Places:
    """The planes of all cells of a tileset.

    Notes
    -----
    A point is compared with all planes at once. For 60,000 cells this takes about 3 ms, which is less than an
    index would take to build for the few way points of a route.
    """

    planes: NDArray[np.float64]
    """(N, 6, 4) outward unit normal and d; inside is n.x + d <= 0; m, nav frame."""

    @cached_property
    def _normals(self) -> NDArray[np.float64]:
        return np.ascontiguousarray(self.planes[:, :, :3])

    def heights(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N,) height of a point (3,) over the plane that it lies farthest outside of, m; negative inside."""
        return np.asarray((self._normals @ point + self.planes[:, :, 3]).max(axis=1))

    def cell_at(self, point: NDArray[np.float64]) -> int | None:
        """Return the cell that a point (3,) lies deepest in, the first of several; None outside of all."""
        heights = self.heights(point)
        cell = int(np.argmin(heights))
        return cell if heights[cell] <= SLACK else None

    def nearest(self, point: NDArray[np.float64]) -> tuple[int, float]:
        """Return the cell nearest to a point (3,) outside of all cells, and its distance in metres.

        Notes
        -----
        The height over a plane is never more than the distance from the cell, so cells are measured in
        the order of their heights until these exceed the least distance.
        """
        heights = self.heights(point)
        best, least = -1, np.inf
        for cell in np.argsort(heights, kind="stable"):
            if heights[cell] >= least:
                break
            distance = distance_from_cell(self.planes[cell], point)
            if distance < least:
                best, least = int(cell), distance
        return best, float(least)


def places_of(tileset: NavTileset) -> Places:
    """Return the planes of the cells of all sectors, by cell."""
    return Places(np.concatenate([np.asarray(sector.planes) for sector in tileset.sectors]))


def distance_from_cell(planes: NDArray[np.float64], point: NDArray[np.float64]) -> float:
    """Distance of a point (3,) from a cell (6, 4), m; 0 inside, infinity from a cell without points.

    Notes
    -----
    The nearest point is the projection onto one plane, the common line of two or the common point of three;
    of those that lie in the cell the nearest is taken.

    Examples
    --------
    >>> cube = np.concatenate((np.eye(3), -np.eye(3)))
    >>> planes = np.column_stack((cube, np.full(6, -1.0)))
    >>> distance_from_cell(planes, np.array((4.0, 5.0, 0.5)))
    5.0
    """
    normals, offsets = planes[:, :3], planes[:, 3]
    least = np.inf
    for count in range(4):
        for chosen in combinations(range(len(planes)), count):
            rows = normals[list(chosen)]
            heights = rows @ point + offsets[list(chosen)]
            foot = point - np.linalg.pinv(rows) @ heights if count else point
            if np.all(normals @ foot + offsets <= SLACK):
                least = min(least, float(np.linalg.norm(point - foot)))
    return least
