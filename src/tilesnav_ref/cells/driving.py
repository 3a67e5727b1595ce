"""The mission of ground vehicles: cells over ground that they come to.

Notes
-----
Roots follow the stands (standing.py), and a cell is kept when a vehicle can stand below it and comes there
along the ground, from cell to cell (climb.py): from the ground under the open sky, or from the cells that
hold the seeds. Portals that only something that flies could pass, such as that above the edge of a terrace,
are left out.

Ground to start from is the lowest stand of a column where it is near the ground of terrain.py and its patch
(of columns whose stands join within one step) does not drop on half of its border, so neither a roof nor a
platform is.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.buckets import FaceBuckets
from tilesnav_ref.cells.climb import ClimbGraph, climb_graph
from tilesnav_ref.cells.coverage import locate_points
from tilesnav_ref.cells.domain import GridSizes
from tilesnav_ref.cells.portals import Contacts
from tilesnav_ref.cells.sectors import connected_within
from tilesnav_ref.cells.selection import open_sky
from tilesnav_ref.cells.settings import CellError, CellSettings
from tilesnav_ref.cells.standing import find_stands, ground_roots
from tilesnav_ref.cells.terrain import Ground, level_patches
from tilesnav_ref.scene.model import Scene


class GroundMission:
    """The space of ground vehicles; it knows which stands were reached once cells have been chosen."""

    def __init__(self, scene: Scene, settings: CellSettings, sizes: GridSizes, ground: Ground) -> None:
        self._settings = settings
        self._sizes = sizes
        self._ground = ground
        self._step = math.floor(settings.ground_step / scene.step)
        plan = np.stack((ground.origin, ground.origin + ground.size * np.array(ground.low.shape)))
        limits = settings.ground_slope, self._step, sizes.min_size + sizes.clearance
        self._stands = find_stands(scene.corners(), plan, sizes.min_size // 2, limits)
        self._reached = np.ones(len(self._stands.low), np.bool_)

    def roots(self, roots: NDArray[np.int64]) -> NDArray[np.int64]:
        """Roots over the stands below roots (R, 2, 3), within the heights of these.

        Raises
        ------
        CellError
            There is none.
        """
        sizes = self._sizes
        if sizes.min_size + sizes.clearance > sizes.ground_height:
            raise CellError(
                f"ground_height is {self._settings.ground_height} m; mission ground needs min_size and "
                f"clearance at least, {self._settings.min_size} + {self._settings.clearance} m"
            )
        found = ground_roots(roots, self._stands, (sizes.ground_height, sizes.min_size, sizes.clearance))
        found[:, 1, 2] = np.minimum(found[:, 1, 2], roots[:, 1, 2].max())
        found = found[
            (found[:, 0, 2] >= roots[:, 0, 2].min()) & (found[:, 1, 2] - found[:, 0, 2] >= sizes.min_size)
        ]
        if len(found) == 0:
            raise CellError(
                f"no free space: no face of slope {self._settings.ground_slope:g} or less is in the domain; "
                "allowed: ground that carries a vehicle, or a greater ground_slope"
            )
        return np.asarray(found)

    def choose(
        self,
        cells: tuple[NDArray[np.int64], NDArray[np.int64]],
        contacts: Contacts,
        buckets: FaceBuckets,
        places: NDArray[np.int64],
        step: float,
    ) -> tuple[NDArray[np.bool_], Contacts]:
        """Choose the cells that vehicles come to, and the contacts that they pass.

        Parameters
        ----------
        cells
            (N, 8, 3) corners of the cells, and the cells as :func:`locate_points` takes them.
        contacts
            Where they touch.
        buckets
            Faces.
        places
            (N, 2) sector of each cell.
        step
            Metres of a grid step.

        Raises
        ------
        CellError
            A vehicle comes to no cell.
        """
        limits = self._sizes.ground_height, self._step
        where = (contacts.pairs, contacts.rectangles)
        graph = climb_graph(cells[0], where, self._stands, limits, (buckets, self._sizes.clearance))
        starts = self._starts(graph, cells, buckets, step)
        if not np.any(starts):
            raise CellError(
                f"no free space: of {len(cells[0])} free cells none is over ground under the open sky or "
                "holds a seed over ground; allowed: seeds on the ground, keep_interiors, or a named terrain"
            )
        kept = connected_within(graph.links, starts, places[graph.cells])
        self._reached = np.zeros(len(self._stands.low), np.bool_)
        self._reached[graph.stands[kept]] = True
        chosen = np.zeros(len(cells[0]), np.bool_)
        chosen[graph.cells[kept]] = True
        passed = np.zeros(len(contacts.pairs), np.bool_)
        along = graph.contacts[kept[graph.links].all(axis=1)] if len(graph.links) else graph.contacts
        passed[along[along >= 0]] = True
        return chosen, contacts.select(passed)

    def holds(self, points: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Which points (P, 3) are over a stand that is reached, at most the height of a cell above its lower
        end; (P,) bool."""
        heights = self.heights(points)
        return np.asarray((heights >= 0) & (heights <= self._sizes.ground_height))

    def heights(self, points: NDArray[np.int64]) -> NDArray[np.int64]:
        """Heights of points (P, 3) above the lower end of the highest reached stand below; -1 without one."""
        stands, result = self._stands, np.full(len(points), -1, np.int64)
        place = (points[:, :2] - stands.origin) // stands.size
        inside = np.all((place >= 0) & (place < np.array(stands.shape)), axis=1)
        column = np.where(inside, place[:, 0] * stands.shape[1] + place[:, 1], 0)
        first, last = stands.offsets[column], np.where(inside, stands.offsets[column + 1], 0)
        for storey in range(int((last - first).max(initial=0))):
            s = np.minimum(first + storey, max(len(stands.low) - 1, 0))
            below = (first + storey < last) & self._reached[s] & (stands.low[s] <= points[:, 2])
            result = np.where(below, points[:, 2] - stands.low[s], result)
        return result

    def _starts(
        self,
        graph: ClimbGraph,
        cells: tuple[NDArray[np.int64], NDArray[np.int64]],
        buckets: FaceBuckets,
        step: float,
    ) -> NDArray[np.bool_]:
        """(N,) nodes that need no way to them."""
        settings, corners = self._settings, cells[0]
        if settings.keep_interiors:
            return np.ones(len(graph.cells), np.bool_)
        if settings.seeds != "sky":
            seeds = np.round(np.array(settings.seeds, np.float64).reshape(-1, 3) / step).astype(np.int64)
            return np.isin(graph.cells, locate_points(cells[1], seeds))
        bounds = np.stack((corners.min(axis=1), corners.max(axis=1)), axis=1)
        open_cells = open_sky(bounds, buckets, self._sizes.clearance)
        return np.asarray(open_cells[graph.cells] & self._on_ground()[graph.stands])

    def _on_ground(self) -> NDArray[np.bool_]:
        """(S,) stands that are the ground of their column."""
        stands = self._stands
        result = np.zeros(len(stands.low), np.bool_)
        found = np.diff(stands.offsets) > 0
        lowest = stands.offsets[:-1][found]
        low, high = np.zeros(len(found), np.int64), np.zeros(len(found), np.int64)
        low[found], high[found] = stands.low[lowest], stands.high[lowest]
        shaped = (low.reshape(stands.shape), high.reshape(stands.shape), found.reshape(stands.shape))
        level = level_patches(*shaped, self._step).ravel()
        column = np.flatnonzero(found)
        middle = np.column_stack(
            (column // stands.shape[1], column % stands.shape[1], np.zeros(len(column), np.int64))
        )
        middle[:, :2] = stands.origin + middle[:, :2] * stands.size + stands.size // 2
        near = np.abs(stands.low[lowest] - self._ground.at(middle)) <= self._ground.size
        result[lowest] = level[column] & near
        return result
