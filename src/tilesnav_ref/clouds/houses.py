"""Houses of the made-up town as triangles with the number of their plane."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Corner = tuple[float, float]


class Rectangle(NamedTuple):
    """A rectangle along the axes in the horizontal plane, metres."""

    x0: float
    y0: float
    x1: float
    y1: float

    def corners(self) -> tuple[Corner, Corner, Corner, Corner]:
        """Counter-clockwise."""
        return (self.x0, self.y0), (self.x1, self.y0), (self.x1, self.y1), (self.x0, self.y1)

    def sides(self) -> Iterator[tuple[Corner, Corner]]:
        """Ends of the four sides, counter-clockwise."""
        corners = self.corners()
        return zip(corners, (*corners[1:], corners[0]), strict=True)

    def inner(self, by: float) -> Rectangle:
        """The rectangle with every side moved inwards."""
        return Rectangle(self.x0 + by, self.y0 + by, self.x1 - by, self.y1 - by)


class Patches:
    """Triangles that are added one polygon at a time, each with its plane."""

    def __init__(self) -> None:
        self._corners: list[NDArray[np.float64]] = []
        self._planes: list[int] = []
        self._count = 0

    def new_plane(self) -> int:
        """Return the number of a plane that has no triangle yet."""
        self._count += 1
        return self._count - 1

    def polygon(self, plane: int, corners: Sequence[Sequence[float]]) -> None:
        """Add a convex polygon, counter-clockwise from outside, as a fan."""
        fixed = np.asarray(corners, np.float64)
        for k in range(1, len(fixed) - 1):
            self._corners.append(fixed[[0, k, k + 1]])
            self._planes.append(plane)

    def flat(self, plane: int, part: Rectangle, z: float) -> None:
        """Add a horizontal rectangle that looks up."""
        self.polygon(plane, [(x, y, z) for x, y in part.corners()])

    def wall(self, plane: int, a: Corner, b: Corner, low: float, high: float) -> None:
        """Add an upright rectangle that looks to the right of the way from a to b."""
        self.polygon(plane, [(*a, low), (*b, low), (*b, high), (*a, high)])

    def triangles(self) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        """(T, 3, 3) float64 corners and (T,) int32 planes."""
        return np.array(self._corners), np.array(self._planes, np.int32)


def uncovered(whole: Rectangle, covered: Sequence[Rectangle]) -> list[Rectangle]:
    """Disjoint rectangles of what is left of a rectangle beneath others."""
    xs = sorted({whole.x0, whole.x1, *(x for part in covered for x in (part.x0, part.x1))})
    ys = sorted({whole.y0, whole.y1, *(y for part in covered for y in (part.y0, part.y1))})
    cells = [
        Rectangle(x0, y0, x1, y1) for x0, x1 in itertools.pairwise(xs) for y0, y1 in itertools.pairwise(ys)
    ]
    return [cell for cell in cells if not any(_inside(cell, part) for part in covered)]


def _inside(cell: Rectangle, part: Rectangle) -> bool:
    x, y = (cell.x0 + cell.x1) / 2, (cell.y0 + cell.y1) / 2
    return part.x0 < x < part.x1 and part.y0 < y < part.y1


def add_house(
    patches: Patches, lot: Rectangle, ground: float, random: np.random.Generator
) -> list[Rectangle]:
    """Add one of five kinds of house, and return the ground that it covers."""
    width, depth = random.uniform(9.0, 16.0), random.uniform(9.0, 14.0)
    x, y = lot.x0 + random.uniform(2.0, 4.0), lot.y0 + random.uniform(2.0, 4.0)
    base = Rectangle(x, y, x + width, y + depth)
    eaves = ground + random.uniform(4.0, 12.0)
    kind = random.integers(5)
    if kind == 0:
        _flat_with_box(patches, base, (ground, eaves), random)
    elif kind == 1:
        _gabled(patches, base, (ground, eaves), random)
    elif kind == 2:
        _hipped(patches, base, (ground, eaves), random)
    elif kind == 3:
        return [base, _with_annex(patches, base, (ground, eaves), random)]
    else:
        _with_parapet(patches, base, (ground, eaves), random)
    return [base]


def _walls(patches: Patches, base: Rectangle, heights: tuple[float, float]) -> None:
    for a, b in base.sides():
        patches.wall(patches.new_plane(), a, b, *heights)


def _flat_with_box(
    patches: Patches, base: Rectangle, heights: tuple[float, float], random: np.random.Generator
) -> None:
    """A flat roof with a machine room on it."""
    _walls(patches, base, heights)
    x, y = base.x0 + random.uniform(2.0, 3.0), base.y0 + random.uniform(2.0, 3.0)
    room = Rectangle(x, y, x + random.uniform(3.0, 5.0), y + random.uniform(3.0, 4.0))
    roof = patches.new_plane()
    for part in uncovered(base, [room]):
        patches.flat(roof, part, heights[1])
    top = heights[1] + random.uniform(2.0, 3.0)
    _walls(patches, room, (heights[1], top))
    patches.flat(patches.new_plane(), room, top)


def _gabled(
    patches: Patches, base: Rectangle, heights: tuple[float, float], random: np.random.Generator
) -> None:
    """A ridge along x; on the side that looks to -y, a dormer with a flat top in two of three houses."""
    low, eaves = heights
    middle = (base.y0 + base.y1) / 2
    rise = (middle - base.y0) * random.uniform(0.5, 1.0)
    ridge = eaves + rise
    (a, b, c, d) = base.corners()
    patches.wall(patches.new_plane(), a, b, low, eaves)
    patches.wall(patches.new_plane(), c, d, low, eaves)
    for p, q in ((b, c), (d, a)):
        gable = [(*p, low), (*q, low), (*q, eaves), (p[0], middle, ridge), (*p, eaves)]
        patches.polygon(patches.new_plane(), gable)
    back = [(*c, eaves), (*d, eaves), (base.x0, middle, ridge), (base.x1, middle, ridge)]
    patches.polygon(patches.new_plane(), back)
    slope = rise / (middle - base.y0)
    front = patches.new_plane()
    covered = []
    if random.uniform() < 2 / 3:
        covered = [_dormer(patches, base, (eaves, slope, middle), random)]
    for part in uncovered(Rectangle(base.x0, base.y0, base.x1, middle), covered):
        corners = [(x, y, eaves + slope * (y - base.y0)) for x, y in part.corners()]
        patches.polygon(front, corners)


def _dormer(
    patches: Patches, base: Rectangle, roof: tuple[float, float, float], random: np.random.Generator
) -> Rectangle:
    """A dormer on the slope that rises from the eaves along y; returns the roof that it covers."""
    eaves, slope, middle = roof
    x = base.x0 + random.uniform(2.0, base.x1 - base.x0 - 5.5)
    place = Rectangle(
        x, base.y0 + 0.8, x + random.uniform(2.5, 3.5), base.y0 + 0.8 + 0.7 * (middle - base.y0)
    )
    foot, top = (eaves + slope * (y - base.y0) for y in (place.y0, place.y1))
    (a, b, c, d) = place.corners()
    patches.wall(patches.new_plane(), a, b, foot, top)
    patches.polygon(patches.new_plane(), [(*b, foot), (*c, top), (*b, top)])
    patches.polygon(patches.new_plane(), [(*a, foot), (*a, top), (*d, top)])
    patches.flat(patches.new_plane(), place, top)
    return place


def _hipped(
    patches: Patches, base: Rectangle, heights: tuple[float, float], random: np.random.Generator
) -> None:
    _walls(patches, base, heights)
    eaves = heights[1]
    half = min(base.x1 - base.x0, base.y1 - base.y0) / 2 - 0.5
    ridge = eaves + half * random.uniform(0.5, 1.0)
    top = base.inner(half)
    for (a, b), (p, q) in zip(base.sides(), top.sides(), strict=True):
        patches.polygon(patches.new_plane(), [(*a, eaves), (*b, eaves), (*q, ridge), (*p, ridge)])
    patches.flat(patches.new_plane(), top, ridge)


def _with_annex(
    patches: Patches, base: Rectangle, heights: tuple[float, float], random: np.random.Generator
) -> Rectangle:
    """A box with a lower one at the side that looks to +x; returns the base of the lower one."""
    low, eaves = heights
    y = base.y0 + random.uniform(0.5, 2.0)
    annex = Rectangle(base.x1, y, base.x1 + random.uniform(3.0, 5.0), y + random.uniform(4.0, 6.0))
    top = low + random.uniform(2.5, 3.5)
    for number, (a, b) in enumerate(base.sides()):
        plane = patches.new_plane()
        if number == 1:
            for y0, y1, floor in ((a[1], annex.y0, low), (annex.y0, annex.y1, top), (annex.y1, b[1], low)):
                patches.wall(plane, (a[0], y0), (a[0], y1), floor, eaves)
        else:
            patches.wall(plane, a, b, low, eaves)
    patches.flat(patches.new_plane(), base, eaves)
    for number, (a, b) in enumerate(annex.sides()):
        if number != 3:
            patches.wall(patches.new_plane(), a, b, low, top)
    patches.flat(patches.new_plane(), annex, top)
    return annex


def _with_parapet(
    patches: Patches, base: Rectangle, heights: tuple[float, float], random: np.random.Generator
) -> None:
    """A flat roof behind a wall 0.4 m thick, whose top is one plane around the roof."""
    low, roof = heights
    edge = roof + random.uniform(0.9, 1.2)
    _walls(patches, base, (low, edge))
    inner = base.inner(0.4)
    for a, b in inner.sides():
        patches.wall(patches.new_plane(), b, a, roof, edge)
    rim = patches.new_plane()
    for part in uncovered(base, [inner]):
        patches.flat(rim, part, edge)
    patches.flat(patches.new_plane(), inner, roof)
