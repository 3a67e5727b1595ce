"""Convex polygons on the grid with the name of what they belong to, and the ground under them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilesnav_ref.scene.build import Soup
from tilesnav_ref.scene.sample.settings import UNIT

Point = tuple[int, int, int]
"""Grid coordinates."""


class Canvas:
    """Collects triangles part by part."""

    def __init__(self) -> None:
        self._triangles: list[tuple[Point, Point, Point]] = []
        self._parts: list[int] = []
        self._names: list[str] = []

    def begin(self, name: str) -> None:
        """Start a part."""
        self._names.append(name)

    def polygon(self, *points: Point) -> None:
        """Draw a convex polygon, seen counter-clockwise from outside."""
        for i in range(1, len(points) - 1):
            self._triangles.append((points[0], points[i], points[i + 1]))
            self._parts.append(len(self._names) - 1)

    def soup(self) -> Soup:
        """All triangles, vertices not yet shared."""
        vertices = np.array(self._triangles, np.int64).reshape(-1, 3)
        faces = np.arange(len(vertices)).reshape(-1, 3)
        return Soup(vertices, faces, np.array(self._parts, np.int64), tuple(self._names))


@dataclass(frozen=True)
class Terrain:
    """Ground that is level along y and, along x, linear between streets."""

    knots: tuple[int, ...]
    """Grid coordinates of the middles of streets, ascending multiples of UNIT."""
    slopes: tuple[int, ...]
    """Rise between knots in 1/64, so that a UNIT of way changes the height by whole grid steps."""

    def height(self, x: int) -> int:
        """Grid coordinate of the ground at x, a multiple of UNIT within the knots.

        Raises
        ------
        ValueError
            When the height would not be on the grid.
        """
        if x % UNIT:
            raise ValueError(f"x = {x} is not a multiple of {UNIT} steps")
        total = 0
        for start, end, slope in zip(self.knots, self.knots[1:], self.slopes, strict=False):
            if x > start:
                total += (min(x, end) - start) * slope // UNIT
        return total

    def point(self, x: int, y: int) -> Point:
        """The point of the ground at x, y."""
        return (x, y, self.height(x))
