"""Exact corners of cells, and whether they lie in the closed regions.

The planes of a cell are FLOAT64 and its corners as a rule are not, so a corner is kept as three whole numbers
over a fourth. Nothing is rounded: a region that a cell leaves by a hair proves nothing about that hair.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import combinations
from math import lcm

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator import prisms
from tilesnav_validator.certfile import Certificates

Whole = tuple[int, int, int, int]


def corners(planes: NDArray[np.float64], found: Certificates, exponent: int) -> list[list[Fraction]]:
    """Corners of a bounded cell in the units of a certificate file.

    Parameters
    ----------
    planes : ndarray of float64, shape (6, 4)
        Nav frame, metres.
    found : Certificates
    exponent : int
        The grid step is 2 to this power, in metres.
    """
    unit = Fraction(2) ** (exponent - found.subdivision)
    origin = [int(x) << found.subdivision for x in found.origin]
    whole = [_in_whole_numbers(plane) for plane in planes.tolist()]
    result = []
    for three in combinations(whole, 3):
        x, y, z, below = _meet(*three)
        if below and all(_height(plane, (x, y, z, below)) <= 0 for plane in whole):
            point = (Fraction(value, below) / unit for value in (x, y, z))
            result.append([value - start for value, start in zip(point, origin, strict=True)])
    return result


def _in_whole_numbers(plane: list[float]) -> Whole:
    """A multiple of a plane in whole numbers."""
    parts = [Fraction(value) for value in plane]
    scale = lcm(*(value.denominator for value in parts))
    x, y, z, d = (int(value * scale) for value in parts)
    return x, y, z, d


def _meet(a: Whole, b: Whole, c: Whole) -> Whole:
    """Meeting point of three planes by Cramer's rule, over a denominator of 0 or more; 0 where there is
    none."""

    def minor(i: int, j: int, k: int) -> int:
        return (
            a[i] * (b[j] * c[k] - b[k] * c[j])
            + a[j] * (b[k] * c[i] - b[i] * c[k])
            + a[k] * (b[i] * c[j] - b[j] * c[i])
        )

    x, y, z, below = minor(1, 2, 3), minor(2, 0, 3), minor(0, 1, 3), minor(0, 1, 2)
    # n.x = -d: each column of normals is exchanged for -d in turn.
    return (-x, -y, -z, below) if below > 0 else (x, y, z, -below)


def _height(plane: Whole, point: Whole) -> int:
    """Height of a point over a plane, times something positive."""
    return sum(a * b for a, b in zip(plane, point, strict=True))


def outside(
    points: list[list[Fraction]], rows: NDArray[np.int64], shapes: NDArray[np.int64]
) -> Iterator[tuple[int, str]]:
    """Indices of prisms, given by their rows (k, 8) and shapes (k,), that do not hold all points, and how far
    these reach."""
    if not points:
        return
    low = [min(point[axis] for point in points) for axis in range(3)]
    high = [max(point[axis] for point in points) for axis in range(3)]
    # Whole numbers around the cell decide: bounds of regions are whole.
    floor = np.array([value.__floor__() for value in low], dtype=object)
    ceiling = np.array([value.__ceil__() for value in high], dtype=object)
    beyond = (rows[:, :3] > floor) | (rows[:, 3:6] < ceiling)
    slanted = np.flatnonzero(shapes)
    beyond[slanted, prisms.SLANTED_AXIS[shapes[slanted]]] = False  # there the bounds change along the way
    wrong = np.asarray(beyond.any(axis=1))
    slanted = slanted[~wrong[slanted]]
    # Certificates of one region mostly stand one after the other, and a run of them is looked at once.
    table = np.column_stack([shapes[slanted], rows[slanted]])
    starts = np.ones(len(table), dtype=bool)
    starts[1:] = (table[1:] != table[:-1]).any(axis=1)
    whole = [_over_one_denominator(point) for point in points]
    beside = np.array(
        [
            next((number for number, point in enumerate(whole) if not _between(point, row)), -1)
            for row in table[starts].tolist()
        ],
        dtype=np.int64,
    )[np.cumsum(starts) - 1]
    for index in np.flatnonzero(wrong):
        yield int(index), f"from {[float(x) for x in low]} to {[float(x) for x in high]} units"
    for place in np.flatnonzero(beside >= 0):
        yield int(slanted[place]), f"corner {[float(x) for x in points[beside[place]]]} units"


def _over_one_denominator(point: list[Fraction]) -> Whole:
    """A point as three whole numbers over a fourth, which is positive."""
    below = lcm(*(value.denominator for value in point))
    x, y, z = (int(value * below) for value in point)
    return x, y, z, below


def _between(point: Whole, row: list[int]) -> bool:
    """Whether a point lies between the lines that bound a prism along its slanted axis, or on one of them."""
    shape, *part, p, q = row
    u, v = prisms.AXES[shape]
    below = point[3]
    run, gone = part[u + 3] - part[u], point[u] - part[u] * below
    over_lower = (point[v] - part[v] * below) * run - gone * (p - part[v])
    over_upper = (point[v] - part[v + 3] * below) * run - gone * (q - part[v + 3])
    return over_lower >= 0 >= over_upper
