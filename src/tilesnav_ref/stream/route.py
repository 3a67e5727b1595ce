"""Ways through cells: from way point to way point by the shortest way through the portals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.errors import RouteError
from tilesnav_ref.stream.gates import Gates, reach_from_point
from tilesnav_ref.stream.places import Places
from tilesnav_ref.stream.tighten import tighten

Points = NDArray[np.float64]


@dataclass(frozen=True)
class Passage:
    """The part of a route that lies in one cell; metres along the route."""

    cell: int
    begin: float
    end: float


@dataclass(frozen=True)
class Route:
    """A line of straight pieces, each within one cell; metres, nav frame."""

    points: Points
    """(P, 3), no two in a row alike."""
    cells: NDArray[np.int64]
    """(P - 1,) cell that each piece lies in."""

    @cached_property
    def arc(self) -> NDArray[np.float64]:
        """(P,) length of the way to each point."""
        pieces = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        return np.concatenate(([0.0], np.cumsum(pieces)))

    @property
    def length(self) -> float:
        """Of the whole route."""
        return float(self.arc[-1])

    @cached_property
    def passages(self) -> tuple[Passage, ...]:
        """Cells in the order of the way; each begins where the one before ends, and is another."""
        firsts = np.flatnonzero(np.diff(self.cells, prepend=-1))
        lasts = np.append(firsts[1:], len(self.cells))
        return tuple(
            Passage(int(self.cells[first]), float(self.arc[first]), float(self.arc[last]))
            for first, last in zip(firsts, lasts, strict=True)
        )

    def at(self, places: NDArray[np.float64]) -> Points:
        """(K, 3) points of the route at lengths (K,) along it."""
        return np.column_stack([np.interp(places, self.arc, self.points[:, axis]) for axis in range(3)])


def route_through(gates: Gates, places: Places, way_points: Sequence[Sequence[float]]) -> Route:
    """Find the way from point to point.

    Parameters
    ----------
    gates, places
        Of the tileset.
    way_points : sequence of triples
        Metres, nav frame; two at least.

    Returns
    -------
    Route
        Between two way points: the shortest of the ways that lead straight from the middle of a portal to
        the middle of a next one of the same cell (Dijkstra), then pulled tight within its portals.

    Raises
    ------
    RouteError
        When there are too few way points, one lies in no cell, no way joins two of them, or all are one
        place.

    References
    ----------
    E. W. Dijkstra, A note on two problems in connexion with graphs, Numerische Mathematik 1, 1959.
    """
    points = np.asarray(way_points, np.float64).reshape(-1, 3)
    if len(points) < 2:
        raise RouteError(f"route: found {len(points)} way points; allowed: two or more")
    cells = [_cell_of(places, point, number) for number, point in enumerate(points, start=1)]
    pieces = [
        _leg(gates, (points[k], points[k + 1]), (cells[k], cells[k + 1]), k + 1)
        for k in range(len(points) - 1)
    ]
    return join(pieces)


def join(pieces: Sequence[tuple[Points, list[int]]]) -> Route:
    """Join lines (K, 3) with the cells of their K - 1 pieces; each begins where the one before ends.

    Raises
    ------
    RouteError
        When all points are one.
    """
    points = np.concatenate([pieces[0][0][:1], *(line[1:] for line, _ in pieces)])
    cells = np.array([cell for _, passed in pieces for cell in passed], np.int64)
    moves = np.any(np.diff(points, axis=0) != 0.0, axis=1)
    if not moves.any():
        raise RouteError("route: found way points that are all in one place; allowed: a way of some length")
    return Route(np.concatenate((points[:1], points[1:][moves])), cells[moves])


def way_through(
    gates: Gates, ends: tuple[Points, Points], cells: tuple[int, int], passed: Sequence[int]
) -> tuple[Points, list[int]]:
    """Pull the way through some gates tight.

    Parameters
    ----------
    ends : two (3,)
        Where it begins and ends, in the two `cells`.
    passed : sequence of int
        The gates, in order.

    Returns
    -------
    (K + 2, 3) points, K + 1 cells
        For K gates; each piece lies in its cell.
    """
    inside = [cells[0]]
    for gate in passed:
        low, high = gates.cells[gate]
        inside.append(int(high if inside[-1] == low else low))
    line = tighten(ends[0], [gates.polygon(gate) for gate in passed], ends[1])
    return line, inside


def _cell_of(places: Places, point: Points, number: int) -> int:
    cell = places.cell_at(point)
    if cell is None:
        near, distance = places.nearest(point)
        shown = ", ".join(f"{value:g}" for value in point)
        raise RouteError(
            f"route, way point {number}: found {shown}, which lies in no cell; allowed: points in cells; the"
            f" nearest is cell {near}, {distance:.3g} m away"
        )
    return cell


def _leg(
    gates: Gates, ends: tuple[Points, Points], cells: tuple[int, int], number: int
) -> tuple[Points, list[int]]:
    if cells[0] == cells[1]:
        return way_through(gates, ends, cells, [])
    reach = reach_from_point(gates, ends[0], cells[0])
    last = gates.of_cell(cells[1])
    lengths = reach.lengths[last] + np.linalg.norm(gates.middles[last] - ends[1], axis=1)
    if not np.isfinite(lengths).any():
        raise RouteError(
            f"route: found no way from way point {number} in cell {cells[0]} to way point {number + 1} in"
            f" cell {cells[1]}; allowed: way points in cells that portals connect"
        )
    return way_through(gates, ends, cells, reach.way(int(last[np.argmin(lengths)])))
