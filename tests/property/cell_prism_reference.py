"""Cells judged in fractions, from their corners alone."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from itertools import permutations

import numpy as np

Point = tuple[Fraction, ...]
HalfSpace = tuple[tuple[int, int, int], Fraction]
"""Outward normal n and bound b of n . x <= b."""
PRECISION = 10**9
"""Bounds that are irrational are too small by less than 1 / PRECISION of a normal's length."""


def half_spaces(corners: np.ndarray, moved: int = 0) -> list[HalfSpace]:
    """Half-spaces of a cell (8, 3), moved outwards by a distance that is too short by the precision."""
    result = []
    middle = [Fraction(int(value), 8) for value in corners.sum(axis=0)]
    for axis in range(3):
        for upper in range(2):
            side = [corners[c] for c in range(8) if c >> axis & 1 == upper]
            a, b = side[1] - side[0], side[2] - side[0]
            normal = tuple(int(value) for value in np.cross(a, b))
            bound = dot(normal, side[0])
            assert all(dot(normal, corner) == bound for corner in side), "corners of a side in one plane"
            if dot(normal, middle) > bound:
                normal, bound = tuple(-n for n in normal), -bound
            assert dot(normal, middle) < bound, "the middle is inside"
            square = sum(n * n for n in normal)
            shift = math.isqrt(moved * moved * square * PRECISION**2)
            result.append((normal, bound + Fraction(shift, PRECISION)))
    return result


def dot(normal: tuple[int, ...], point: Iterable[int | Fraction]) -> Fraction:
    """Exact scalar product; numbers of numpy are made to numbers of Python, which do not overflow."""
    exact = (x if isinstance(x, Fraction) else int(x) for x in point)
    return sum((n * Fraction(x) for n, x in zip(normal, exact, strict=True)), Fraction(0))


def clip(polygon: list[Point], half_space: HalfSpace) -> list[Point]:
    """The part of a convex polygon in a closed half-space."""
    normal, bound = half_space
    over = [dot(normal, point) - bound for point in polygon]
    kept = []
    for a, (point, height) in enumerate(zip(polygon, over, strict=True)):
        b = (a + 1) % len(polygon)
        if height <= 0:
            kept.append(point)
        if height * over[b] < 0:
            share = height / (height - over[b])
            kept.append(tuple(x + share * (y - x) for x, y in zip(point, polygon[b], strict=True)))
    return kept


def meets(triangle: np.ndarray, spaces: list[HalfSpace]) -> bool:
    """Whether a closed triangle meets the interior of a polyhedron: see `meets_by_clipping`."""
    polygon: list[Point] = [tuple(Fraction(int(x)) for x in corner) for corner in triangle]
    for space in spaces:
        polygon = clip(polygon, space)
    if not polygon:
        return False
    mean = tuple(sum((v[k] for v in polygon), Fraction(0)) / len(polygon) for k in range(3))
    return all(dot(normal, mean) < bound for normal, bound in spaces)


def side_polygon(corners: np.ndarray, axis: int, upper: int) -> list[Point]:
    """Corners of a side in order around it."""
    i, j = 1 << (axis + 1) % 3, 1 << (axis + 2) % 3
    base = upper << axis
    return [tuple(Fraction(int(x)) for x in corners[base | c]) for c in (0, i, i | j, j)]


def twice_area(polygon: list[Point], axis: int) -> Fraction:
    """Twice the area of a polygon's projection along an axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    return abs(
        sum(
            (a[i] * b[j] - a[j] * b[i] for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True)),
            Fraction(0),
        )
    )


def interiors_meet(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two cells have a common interior point: a side of the one, or a point inside it, is inside the
    other."""
    for a, b in ((one, other), (other, one)):
        spaces = half_spaces(b)
        middle = [Fraction(int(value), 8) for value in a.sum(axis=0)]
        if all(dot(n, middle) < bound for n, bound in spaces):
            return True
        for axis in range(3):
            for upper in range(2):
                quad = side_polygon(a, axis, upper)
                for k in (1, 2):
                    if meets_points([quad[0], quad[k], quad[k + 1]], spaces):
                        return True
    return False


def meets_points(polygon: list[Point], spaces: list[HalfSpace]) -> bool:
    """As `meets`, for a polygon with rational corners."""
    for space in spaces:
        polygon = clip(polygon, space)
    if not polygon:
        return False
    mean = tuple(sum((v[k] for v in polygon), Fraction(0)) / len(polygon) for k in range(3))
    return all(dot(normal, mean) < bound for normal, bound in spaces)


def is_prism(corners: np.ndarray) -> bool:
    """Whether there are axes u, v, w as `CellComplex` asks for."""
    grid = corners.reshape(2, 2, 2, 3)  # sides of z, y, x
    for u, v, w in permutations(range(3)):
        flat = all(
            np.ptp(np.moveaxis(grid[..., k], 2 - k, 0).reshape(2, 4), axis=1).max() == 0 for k in (u, w)
        )
        if flat and np.ptp(np.moveaxis(grid[..., v], 2 - w, 0), axis=0).max() == 0:
            return True
    return False
