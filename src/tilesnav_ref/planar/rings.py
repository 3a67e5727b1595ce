"""Rings of outlines as runs: pieces that belong to one crease, and free pieces between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from tilesnav_ref.planar.creases import FREE


@dataclass(frozen=True)
class Run:
    """A piece of a ring."""

    label: int
    """The neighbour whose crease it belongs to, or FREE."""
    points: NDArray[np.float64]
    """(N, 2) in the frame of the plane, N at least 1."""


def divide_ring(flat: NDArray[np.float64], labels: NDArray[np.int64], least: float) -> list[Run]:
    """Divide a ring into runs.

    Parameters
    ----------
    flat : (N, 2) float64
        Points of the ring, the first not repeated.
    labels : (N,) int64
        Neighbour of each, or FREE.
    least : float
        Runs that are shorter are taken for noise where both sides of them are alike, metres.

    Returns
    -------
    list of Run
        In order around the ring; neighbours in the list differ in their labels, unless it has one run.
    """
    labels = _smoothed(flat, labels, least)
    starts = _starts(labels)
    if len(starts) <= 1:
        return [Run(int(labels[0]), flat)]
    order = np.roll(np.arange(len(flat)), -starts[0])
    pieces = np.split(order, (starts[1:] - starts[0]))
    return [Run(int(labels[piece[0]]), flat[piece]) for piece in pieces]


def _starts(labels: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.flatnonzero(labels != np.roll(labels, 1))


def _smoothed(flat: NDArray[np.float64], labels: NDArray[np.int64], least: float) -> NDArray[np.int64]:
    """Labels in which no short run lies between two of one label; the shortest go first."""
    labels = labels.copy()
    steps = np.linalg.norm(np.roll(flat, -1, axis=0) - flat, axis=1)
    while True:
        starts = _starts(labels)
        if len(starts) < 3:
            return labels
        ends = np.roll(starts, -1)
        order = np.cumsum(np.append(0.0, np.append(steps, steps)))
        lengths = order[np.where(ends > starts, ends, ends + len(flat)) - 1] - order[starts]
        own = labels[starts]
        alike = (np.roll(own, 1) == np.roll(own, -1)) & (lengths < least)
        if not alike.any():
            return labels
        k = int(np.flatnonzero(alike)[np.argmin(lengths[alike])])
        size = int((ends[k] - starts[k]) % len(flat))
        labels[(starts[k] + np.arange(size)) % len(flat)] = np.roll(own, 1)[k]


def simplified(
    run: Run, sides: tuple[NDArray[np.float64], NDArray[np.float64]], tolerance: float
) -> NDArray[np.float64]:
    """Points (M, 2) of a free run between the points (2,) on either side of it, by Douglas and Peucker.

    References
    ----------
    D. H. Douglas, T. K. Peucker, "Algorithms for the reduction of the number of points required to represent
    a digitized line or its caricature", Cartographica 10(2), 1973.
    """
    line = shapely.linestrings(np.vstack((sides[0], run.points, sides[1])))
    return np.asarray(shapely.get_coordinates(shapely.simplify(line, tolerance, preserve_topology=False)))[
        1:-1
    ]


def whole_ring(run: Run, tolerance: float) -> NDArray[np.float64]:
    """Points (M, 2) of a ring that is one free run; M at least 3 where it has an area."""
    ring = shapely.Polygon(run.points)
    return np.asarray(shapely.get_coordinates(shapely.simplify(ring, tolerance)))[:-1]


def is_free(run: Run) -> bool:
    """Whether a run belongs to no crease."""
    return run.label == FREE
