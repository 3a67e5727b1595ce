"""Borders of planar features drawn to the creases of their planes, as rings of shared vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from tilesnav_ref.planar.creases import FREE, Creases
from tilesnav_ref.planar.knots import Knots
from tilesnav_ref.planar.mesh_settings import MeshSettings
from tilesnav_ref.planar.outline import Outline
from tilesnav_ref.planar.rings import Run, divide_ring, is_free, simplified, whole_ring

_SHORT = 2.0
"""Runs of fewer spacings are noise: an outline has a vertex about every one or two."""
_CORNER_REACH = 2.0
"""Reaches from the end of a run to the corner that it is drawn to, at most: both coordinates of a corner can
be off by one."""


@dataclass(frozen=True)
class Stop:
    """A vertex of a ring and the edge behind it."""

    knot: int
    label: int
    """The neighbour along whose crease the ring goes on to the next vertex; FREE where it does not."""


class Borders:
    """Rings of all features as stops, drawn to creases."""

    def __init__(self, outlines: list[Outline], creases: Creases, settings: MeshSettings) -> None:
        self._outlines = outlines
        self._creases = creases
        self._settings = settings
        self.knots = Knots(creases)
        self.polygons = [
            [
                [self._ring(feature, ring) for ring in (part.exterior, *part.interiors)]
                for part in shapely.get_parts(outlines[feature].shape)
            ]
            for feature in range(len(outlines))
        ]
        """For each feature its polygons, for each of these its rings, the outer one first."""
        self.knots.settle()

    def ring(self, feature: int, stops: list[Stop]) -> list[int]:
        """Knots around a ring after merging, with those of the neighbours between its own; each once in a
        row."""
        knots: list[int] = []
        for stop, following in zip(stops, stops[1:] + stops[:1], strict=True):
            start, end = self.knots.merged(stop.knot), self.knots.merged(following.knot)
            knots.append(start)
            if stop.label != FREE and start != end:
                knots += self.knots.between(feature, stop.label, (start, end))
        behind = knots[1:] + knots[:1]
        return [knot for knot, after in zip(knots, behind, strict=True) if knot != after]

    def _ring(self, feature: int, ring: shapely.LinearRing) -> list[Stop]:
        outline = self._outlines[feature]
        flat = shapely.get_coordinates(ring)[:-1]
        labels = self._creases.label(feature, outline.frame.lifted(flat))
        runs = divide_ring(flat, labels, _SHORT * outline.spacing)
        tolerance = self._settings.tolerance * outline.spacing
        if len(runs) == 1 and is_free(runs[0]):
            points = outline.frame.lifted(whole_ring(runs[0], tolerance))
            return [Stop(self.knots.add(point), FREE) for point in points]
        return self._stops(feature, self._without_gaps(feature, runs), tolerance)

    def _without_gaps(self, feature: int, runs: list[Run]) -> list[Run]:
        """Leave out short free runs between two creases that have a corner near."""
        kept = []
        for k, run in enumerate(runs):
            before, after = runs[k - 1], runs[(k + 1) % len(runs)]
            points = np.vstack((before.points[-1:], run.points, after.points[:1]))
            length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
            short = is_free(run) and length <= _CORNER_REACH * self._creases.reach[feature]
            if not (short and self._corner(feature, before, after) is not None):
                kept.append(run)
        return kept

    def _corner(self, feature: int, before: Run, after: Run) -> int | None:
        """The corner between two runs along creases, where both ends are near it."""
        if is_free(before) or is_free(after) or before.label == after.label:
            return None
        point = self._creases.corner(feature, before.label, after.label)
        if point is None:
            return None
        flat = self._outlines[feature].frame.flat(point[None])[0]
        ends = np.stack((before.points[-1], after.points[0]))
        reach = max(self._creases.reach[[feature, before.label, after.label]])
        if np.linalg.norm(ends - flat, axis=1).max() > _CORNER_REACH * reach:
            return None
        return self.knots.corner(feature, before.label, after.label)

    def _stops(self, feature: int, runs: list[Run], tolerance: float) -> list[Stop]:
        frame = self._outlines[feature].frame
        ends = [self._ends(feature, runs, k) for k in range(len(runs))]
        stops: list[Stop] = []
        for k, run in enumerate(runs):
            if is_free(run):
                before, after = ends[k - 1], ends[(k + 1) % len(runs)]
                sides = [frame.flat(self.knots.point(knot)[None])[0] for knot in (before[1], after[0])]
                points = frame.lifted(simplified(run, (sides[0], sides[1]), tolerance))
                stops += [Stop(self.knots.add(point), FREE) for point in points]
            else:
                stops += [Stop(ends[k][0], run.label), Stop(ends[k][1], FREE)]
        return stops

    def _ends(self, feature: int, runs: list[Run], k: int) -> tuple[int, int]:
        """First and last knot of a run along a crease; (-1, -1) of a free one."""
        run = runs[k]
        if is_free(run):
            return -1, -1
        lifted = self._outlines[feature].frame.lifted(run.points[[0, -1]])
        start = self._corner(feature, runs[k - 1], run)
        stop = self._corner(feature, run, runs[(k + 1) % len(runs)])
        first = self.knots.add_on_crease(feature, run.label, lifted[0]) if start is None else start
        last = self.knots.add_on_crease(feature, run.label, lifted[1]) if stop is None else stop
        return first, last
