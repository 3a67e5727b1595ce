"""What part of the domain a mission divides: roots are narrowed, divided in plan, or left out.

Notes
-----
* ``aerial``: the band from altitude_min to altitude_max above the ground. The upper end of a root is measured
  from the lowest ground below it and the lower end from the highest, so that no point of a cell is above
  altitude_max or below altitude_min over the ground straight below. Where that would cost more height
  than the smallest cell, and more than a part of the band, the root is halved in plan.
* ``corridor``: the same, and only roots that a tube around a line meets. Cells are kept when their bounds
  meet the tube; all free space of the tube within the band is in some root.
* ``ground``: see standing.py.

Voxels are not narrowed: those that do not fit are left out.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.coverage import locate_points
from tilesnav_ref.cells.domain import GridSizes, altitude_steps
from tilesnav_ref.cells.prisms import prisms_of_boxes
from tilesnav_ref.cells.settings import CellError, CellSettings
from tilesnav_ref.cells.terrain import Ground
from tilesnav_ref.cells.tube import boxes_in_tube, points_in_tube

RELIEF = 32
"""Part of the band of altitude that a tile on a slope may lose; finer tiles are many cells for little air."""


class Mission:
    """The space that the cells of a mission may fill."""

    def __init__(self, settings: CellSettings, sizes: GridSizes, step: float, ground: Ground) -> None:
        self._settings = settings
        self._sizes = sizes
        self._ground = ground
        self._band = altitude_steps(settings, step)
        self._line = np.array(settings.corridor, np.float64).reshape(-1, 3) / step
        self._radius = settings.corridor_radius / step

    def roots(self, roots: NDArray[np.int64]) -> NDArray[np.int64]:
        """Roots (R, 2, 3) narrowed to the mission; those of a column stay one above the other.

        Raises
        ------
        CellError
            None is left.
        """
        found = self._in_band(self._divided(roots))
        if len(self._line):
            found = found[boxes_in_tube(found, self._line, self._radius)]
        if len(found) == 0:
            where = "the tube of the corridor" if len(self._line) else "the band of altitude"
            raise CellError(
                f"no free space: no tile of {len(roots)} holds a part of {where}; allowed: a mission that "
                "meets the domain"
            )
        return found

    def keep(self, bounds: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Which cells, by their bounds (N, 2, 3), belong to the mission; (N,) bool."""
        if len(self._line) == 0:
            return np.ones(len(bounds), np.bool_)
        return boxes_in_tube(bounds, self._line, self._radius)

    def holds(self, points: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Which points (P, 3) the mission asks to be covered; (P,) bool."""
        altitude = points[:, 2] - self._ground.at(points)
        inside = (altitude >= self._band[0]) & (altitude <= self._band[1])
        if len(self._line):
            inside &= points_in_tube(points, self._line, self._radius)
        return np.asarray(inside)

    def heights(self, points: NDArray[np.int64]) -> NDArray[np.int64]:
        """Heights of points (P, 3) above the lowest ground of their columns; (P,) grid steps."""
        return points[:, 2] - self._ground.at(points)

    def line_points(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The points (P, 3) that the line of a corridor was given by, and points (R, 3) between them, half a
        smallest cell apart; grid."""
        spacing, pieces = max(self._sizes.min_size / 2.0, 1.0), [np.zeros((0, 3))]
        for a, b in pairwise(self._line):
            count = math.ceil(float(np.linalg.norm(b - a)) / spacing)
            pieces.append(a + np.linspace(0.0, 1.0, count + 1)[1:-1, None] * (b - a))
        return np.round(self._line).astype(np.int64), np.round(np.concatenate(pieces)).astype(np.int64)

    def _limits(self, roots: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        low, high = self._ground.under(roots)
        return (low if self._band[0] <= 0 else high) + self._band[0], low + self._band[1]

    def _divided(self, roots: NDArray[np.int64]) -> NDArray[np.int64]:
        """Halve in plan what loses more height to the relief below it than the smallest cell."""
        if self._settings.method == "voxel":
            return roots
        done, smallest = [], self._sizes.min_size
        lost = max(smallest, (self._band[1] - self._band[0]) // RELIEF)
        while len(roots):
            bottom, top = self._limits(roots)
            cut = (top < roots[:, 1, 2]) & (top > roots[:, 0, 2])
            if self._band[0] > 0:
                cut |= (bottom > roots[:, 0, 2]) & (bottom < roots[:, 1, 2])
            edges = roots[:, 1, :2] - roots[:, 0, :2]
            cut &= (self._ground.relief(roots) > lost) & (edges.max(axis=1) >= 2 * smallest)
            done.append(roots[~cut])
            roots = _halved(roots[cut], edges[cut].argmax(axis=1))
        return np.concatenate(done) if done else roots

    def _in_band(self, roots: NDArray[np.int64]) -> NDArray[np.int64]:
        bottom, top = self._limits(roots)
        if self._settings.method == "voxel":
            low, _ = self._ground.under(roots)
            bottom = np.where(self._band[0] <= 0, low - self._sizes.max_size, bottom)
            return roots[(roots[:, 0, 2] >= bottom) & (roots[:, 1, 2] <= top)]
        narrowed = roots.copy()
        narrowed[:, 0, 2] = np.maximum(roots[:, 0, 2], bottom)
        narrowed[:, 1, 2] = np.minimum(roots[:, 1, 2], top)
        return narrowed[narrowed[:, 1, 2] - narrowed[:, 0, 2] >= self._sizes.min_size]


def _halved(roots: NDArray[np.int64], axes: NDArray[np.intp]) -> NDArray[np.int64]:
    """Both halves of roots (R, 2, 3) along an axis of each."""
    rows = np.arange(len(roots))
    middle = (roots[rows, 0, axes] + roots[rows, 1, axes]) >> 1
    first, second = roots.copy(), roots.copy()
    first[rows, 1, axes] = middle
    second[rows, 0, axes] = middle
    return np.stack((first, second), axis=1).reshape(-1, 2, 3)


def touches_top(bounds: NDArray[np.int64], roots: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which cells, by their bounds (N, 2, 3), end at the upper end of the roots (R, 2, 3): at the middle or
    near a corner of the upper side no root goes on; (N,) bool."""
    tiles, result = prisms_of_boxes(roots), np.zeros(len(bounds), np.bool_)
    low, high = bounds[:, 0, :2], bounds[:, 1, :2]
    inset = np.minimum(1, (high - low) // 2)
    for x in ("low", "middle", "high"):
        for y in ("low", "middle", "high"):
            if (x == "middle") != (y == "middle"):
                continue
            points = np.empty((len(bounds), 3), np.int64)
            for k, side in enumerate((x, y)):
                places = {
                    "low": low[:, k] + inset[:, k],
                    "middle": (low[:, k] + high[:, k]) >> 1,
                    "high": high[:, k] - inset[:, k],
                }
                points[:, k] = places[side]
            points[:, 2] = bounds[:, 1, 2] + 1
            result |= locate_points(tiles, points) < 0
    return result
