"""Triangles clipped by half-spaces in rational numbers, to compare tests for contact with."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np

HalfSpace = Callable[[tuple[Fraction, ...]], Fraction]


def clipped(polygon: list[tuple[Fraction, ...]], inside: HalfSpace) -> list[tuple[Fraction, ...]]:
    """Part of a convex polygon, a segment or a point where a linear function is not negative."""
    kept = []
    for index, here in enumerate(polygon):
        after = polygon[(index + 1) % len(polygon)]
        one, two = inside(here), inside(after)
        if one >= 0:
            kept.append(here)
        if one * two < 0:
            kept.append(tuple(a + one / (one - two) * (b - a) for a, b in zip(here, after, strict=True)))
    return kept


def common(triangle: Any, sides: list[HalfSpace], strict: list[bool]) -> bool:
    """Whether a closed triangle has a point within half-spaces, some of them open."""
    polygon = [tuple(map(Fraction, corner)) for corner in triangle]
    for side in sides:
        polygon = clipped(polygon, side)
    if not polygon:
        return False
    middle = tuple(sum(axis, Fraction(0)) / len(polygon) for axis in zip(*polygon, strict=True))
    return all(side(middle) > 0 for side, is_open in zip(sides, strict, strict=True) if is_open)


def along(normal: Any, base: Any) -> HalfSpace:
    return lambda p: sum(
        (int(n) * (x - int(b)) for n, x, b in zip(normal, p, base, strict=True)), Fraction(0)
    )


def box_sides(low: Any, high: Any) -> list[HalfSpace]:
    axes = np.eye(3, dtype=int)
    return [along(axis, low) for axis in axes] + [along(-axis, high) for axis in axes]
