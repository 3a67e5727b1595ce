"""Pulling a way through convex gates tight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

INSET = 0.05
"""Share of the way from a border of a gate to its middle by which a way keeps inside: along the border of a
gate it would run along the borders of cells, where a vehicle would be in both."""
SWEEPS = 2000
GAIN = 1e-5
"""m; sweeps end when one shortens the way by less than this."""

Points = NDArray[np.float64]


def tighten(start: Points, gates: Sequence[Points], end: Points) -> Points:
    """Shorten the way from a start (3,) through gates, in order, to an end (3,).

    Parameters
    ----------
    gates : sequence of (K, 3)
        Vertices around convex polygons; two vertices are a line.

    Returns
    -------
    (G + 2, 3) float64
        Start, a point of each gate, end.

    Notes
    -----
    The length is convex in all points together. Points are moved in turns, every second one at a time,
    towards where the straight line between their neighbours crosses the gate, and only where that is
    shorter; so the way is never longer than that through the middles. It is not always the shortest one:
    moving one point at a time may stop early at the border of a gate.

    Examples
    --------
    >>> gate = np.array(((1.0, -9, 0), (1, 1, 0)))
    >>> tighten(np.zeros(3), [gate], np.array((2.0, 0, 0))).round(6).tolist()
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]
    """
    if not gates:
        return np.array([start, end], np.float64)
    narrowed = Polygons.of([gate + INSET * (gate.mean(axis=0) - gate) for gate in gates])
    way = np.concatenate((start[None], [gate.mean(axis=0) for gate in gates], end[None]))
    turns = [Turn(narrowed, np.arange(first, len(gates), 2)) for first in (0, 1)]
    length = _length(way)
    for _ in range(SWEEPS):
        for turn in turns:
            turn.move(way)
        before, length = length, _length(way)
        if before - length < GAIN:
            break
    return way


def _length(way: Points) -> float:
    return float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())


@dataclass(frozen=True)
class Polygons:
    """Convex polygons and lines, made of one number of vertices by repeating the last."""

    corners: Points
    """(G, K, 3)."""
    edges: Points
    """(G, K, 3) to the next corner."""
    normals: Points
    """(G, 3) twice the area long; zero for lines."""
    lines: NDArray[np.bool_]
    """(G,)."""

    @classmethod
    def of(cls, polygons: Sequence[Points]) -> Polygons:
        """Collect polygons (K, 3), each with its own number of vertices."""
        most = max(len(one) for one in polygons)
        corners = np.array([np.concatenate((one, one[-1:].repeat(most - len(one), 0))) for one in polygons])
        edges = np.roll(corners, -1, axis=1) - corners
        arms = corners - corners[:, :1]
        normals = np.cross(arms, np.roll(arms, -1, axis=1)).sum(axis=1)
        return cls(corners, edges, normals, np.array([len(one) == 2 for one in polygons]))

    def rows(self, chosen: NDArray[np.int64]) -> Polygons:
        """Some of the polygons."""
        return Polygons(self.corners[chosen], self.edges[chosen], self.normals[chosen], self.lines[chosen])

    def nearest(self, points: Points) -> Points:
        """(G, 3) point of each polygon nearest to its point (G, 3)."""
        size = _dot(self.normals, self.normals)
        height = _dot(points - self.corners[:, 0], self.normals) / np.where(size > 0.0, size, 1.0)
        feet = points - height[:, None] * self.normals
        sides = _dot(np.cross(self.edges, feet[:, None] - self.corners), self.normals[:, None])
        inside = (size > 0.0) & np.all(sides >= 0.0, axis=1)
        squares = np.maximum(_dot(self.edges, self.edges), 1e-300)
        shares = np.clip(_dot(points[:, None] - self.corners, self.edges) / squares, 0.0, 1.0)
        on_border = self.corners + shares[:, :, None] * self.edges
        away = ((on_border - points[:, None]) ** 2).sum(axis=2)
        return np.where(inside[:, None], feet, on_border[np.arange(len(points)), np.argmin(away, axis=1)])

    def crossings(self, before: Points, after: Points) -> Points:
        """(G, 3) where the lines from (G, 3) to (G, 3) cross the planes of the polygons.

        Notes
        -----
        For a line: the point of it through which the shortest way leads. Turned around the line into one
        plane, that way is straight, so it divides the way along the line as the distances from it.
        """
        way = after - before
        climb = _dot(way, self.normals)
        rise = _dot(self.corners[:, 0] - before, self.normals)
        share = np.where(climb != 0.0, rise / np.where(climb != 0.0, climb, 1.0), 0.5).clip(0.0, 1.0)
        across = before + share[:, None] * way
        origin = self.corners[:, 0]
        along = self.edges[:, 0] / np.maximum(np.linalg.norm(self.edges[:, 0], axis=1), 1e-300)[:, None]
        begin, last = _dot(before - origin, along), _dot(after - origin, along)
        near = np.linalg.norm(before - origin - begin[:, None] * along, axis=1)
        far = np.linalg.norm(after - origin - last[:, None] * along, axis=1)
        divided = np.where(near + far > 0.0, near / np.where(near + far > 0.0, near + far, 1.0), 0.5)
        turned = origin + (begin + divided * (last - begin))[:, None] * along
        return np.where(self.lines[:, None], turned, across)


class Turn:
    """Points of a way that are moved at the same time; none of them is a neighbour of another."""

    def __init__(self, polygons: Polygons, gates: NDArray[np.int64]) -> None:
        self._polygons = polygons.rows(gates)
        self._gates = gates

    def move(self, way: Points) -> None:
        """Move the points of a way (G + 2, 3), in place."""
        before, here, after = (way[self._gates + k] for k in range(3))
        if len(here) == 0:
            return
        moved = self._polygons.nearest(self._polygons.crossings(before, after))
        bound = _through(before, here, after)
        better = _through(before, moved, after) < bound
        way[self._gates[better] + 1] = moved[better]


def _through(before: Points, here: Points, after: Points) -> NDArray[np.float64]:
    lengths = np.linalg.norm(here - before, axis=1) + np.linalg.norm(after - here, axis=1)
    return np.asarray(lengths)


def _dot(left: Points, right: Points) -> NDArray[np.float64]:
    return np.asarray((left * right).sum(axis=-1))
