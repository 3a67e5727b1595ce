"""Knots: vertices of outlines that several planes share, on creases and at corners of three planes."""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.planar.creases import Creases

_CORNERS_ALIKE = 0.25
"""Corners of one crease that are nearer than this part of the merging distance are one: two planes of nearly
the same place, such as two pieces of a wall, give two of them."""

Pair = tuple[int, int]


class Knots:
    """Vertices that are collected first and then merged along every crease.

    Notes
    -----
    A knot is a number. The borders of two features along their crease end at places that differ by up to the
    reach; these are merged to one knot, so that both have the same vertex. Corners of three planes attract
    the ends near them.
    """

    def __init__(self, creases: Creases) -> None:
        self._creases = creases
        self._points: list[NDArray[np.float64]] = []
        self._is_corner: list[bool] = []
        self._on_line: dict[Pair, list[tuple[float, int]]] = {}
        self._corners: dict[tuple[int, ...], int | None] = {}
        self._root: NDArray[np.int64] = np.zeros(0, np.int64)
        self._settled: NDArray[np.float64] = np.zeros((0, 3))
        self._along: dict[Pair, list[tuple[float, int]]] = {}

    def add(self, point: NDArray[np.float64]) -> int:
        """A vertex (3,) that nobody shares."""
        self._points.append(point)
        self._is_corner.append(False)
        return len(self._points) - 1

    def add_on_crease(self, feature: int, other: int, point: NDArray[np.float64]) -> int:
        """A vertex at the foot of a point (3,) on a crease."""
        line = self._creases.line(feature, other)
        place = line.places(point[None])
        knot = self.add(line.points(place)[0])
        self._on_line.setdefault(_pair(feature, other), []).append((float(place[0]), knot))
        return knot

    def corner(self, feature: int, first: int, second: int) -> int | None:
        """The vertex of three planes; None where they have none."""
        triple = tuple(sorted((feature, first, second)))
        if triple not in self._corners:
            point = self._creases.corner(feature, first, second)
            self._corners[triple] = None if point is None else self._add_corner(triple, point)
        return self._corners[triple]

    def _add_corner(self, triple: tuple[int, ...], point: NDArray[np.float64]) -> int:
        knot = self.add(point)
        self._is_corner[knot] = True
        for pair in combinations(triple, 2):
            if self._creases.has_line(*pair):
                place = float(self._creases.line(*pair).places(point[None])[0])
                self._on_line.setdefault(pair, []).append((place, knot))
        return knot

    def point(self, knot: int) -> NDArray[np.float64]:
        """Where a knot is (3,): before :meth:`settle` as it was added, then where it was merged to."""
        return self._settled[knot] if len(self._settled) else self._points[knot]

    def settle(self) -> None:
        """Merge the knots along every crease; call once, when all have been added."""
        self._root = np.arange(len(self._points))
        for pair in sorted(self._on_line):
            reach = float(self._creases.reach[list(pair)].min())
            self._merge(sorted(self._on_line[pair]), reach)
        self._root = np.array([self._find(k) for k in range(len(self._root))], np.int64)
        points = np.array(self._points).reshape(-1, 3)
        weights = np.where(np.array(self._is_corner, bool), 1.0, 0.0)
        with_corner = np.bincount(self._root, weights, len(points)) > 0
        weights[~with_corner[self._root]] = 1.0
        total = np.bincount(self._root, weights, len(points))
        sums = [np.bincount(self._root, weights * points[:, k], len(points)) for k in range(3)]
        with np.errstate(invalid="ignore"):  # numbers that were merged into others have no weight
            self._settled = (np.stack(sums, axis=1) / total[:, None])[self._root]
        for pair, entries in self._on_line.items():
            line = self._creases.line(*pair)
            roots = np.unique(self._root[[knot for _, knot in entries]])
            places = line.places(self._settled[roots])
            order = np.lexsort((roots, places))
            self._along[pair] = [(float(places[k]), int(roots[k])) for k in order]

    def merged(self, knot: int) -> int:
        """The knot that stands for it after :meth:`settle`."""
        return int(self._root[knot])

    def between(self, feature: int, other: int, ends: Pair) -> list[int]:
        """Knots on a crease strictly between two of it, in the order from the first to the second."""
        line = self._creases.line(feature, other)
        start, stop = (float(line.places(self._settled[[end]])[0]) for end in ends)
        low, high = min(start, stop), max(start, stop)
        along = self._along[_pair(feature, other)]
        inner = [knot for place, knot in along if low < place < high and knot not in ends]
        return inner if start <= stop else inner[::-1]

    def _merge(self, entries: list[tuple[float, int]], reach: float) -> None:
        corners = [entry for entry in entries if self._is_corner[entry[1]]]
        for (place, knot), (following, other) in pairwise(corners):
            if following - place <= _CORNERS_ALIKE * reach:
                self._unite(knot, other)
        loose: list[tuple[float, int]] = []
        for place, knot in entries:
            if self._is_corner[knot]:
                continue
            near = min(((abs(place - at), corner) for at, corner in corners), default=(np.inf, -1))
            if near[0] <= reach:
                self._unite(near[1], knot)
            else:
                loose.append((place, knot))
        first = loose[0] if loose else (0.0, -1)
        for place, knot in loose[1:]:
            if place - first[0] <= reach:
                self._unite(first[1], knot)
            else:
                first = (place, knot)

    def _find(self, knot: int) -> int:
        while self._root[knot] != knot:
            self._root[knot] = self._root[self._root[knot]]
            knot = int(self._root[knot])
        return knot

    def _unite(self, first: int, second: int) -> None:
        low, high = sorted((self._find(first), self._find(second)))
        self._root[high] = low


def _pair(first: int, second: int) -> Pair:
    return (min(first, second), max(first, second))
