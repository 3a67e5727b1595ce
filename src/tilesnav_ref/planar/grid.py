"""Points sorted into cubes, so that neighbours are found without a tree."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

KEYS_MAX = 1 << 62
"""More cubes than this in the bounding box have no number in 64 bits."""


class Grid(NamedTuple):
    """Points in the order of their cubes; cubes along z follow each other.

    The points within one edge of a point lie in the nine runs of its cube.
    """

    points: NDArray[np.float64]
    """(N, 3) metres, sorted by cube."""
    order: NDArray[np.int64]
    """(N,) number of each point in the order that was given."""
    cubes: NDArray[np.int64]
    """(C + 1,) first point of each cube that holds one."""
    runs: NDArray[np.int32]
    """(C, 9, 2) first point, and the one after the last, of the columns of three cubes around each cube."""
    edge: float
    """Edge of a cube, metres."""


def make_grid(points: NDArray[np.float64], edge: float) -> Grid:
    """Sort points into cubes.

    Parameters
    ----------
    points : (N, 3) float64
        Metres, finite.
    edge : float
        Edge of a cube, metres, greater than 0.

    Raises
    ------
    ValueError
        When the bounding box has more cubes than numbers.
    """
    low = points.min(axis=0)
    size = np.floor((points.max(axis=0) - low) / edge) + 3.0
    if size.prod() >= KEYS_MAX:
        raise ValueError(f"bounding box of {size.max() * edge:g} m is too large for cubes of {edge:g} m")
    columns, rows, layers = (int(n) for n in size)
    keys = np.zeros(len(points), np.int64)
    for axis, factor in enumerate((1, rows, layers)):  # Horner, column by column to save memory
        keys *= factor
        keys += ((points[:, axis] - low[axis]) / edge).astype(np.int64) + 1
    if columns * rows * layers < 1 << 31:
        keys = keys.astype(np.int32)  # sorts in less time
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    first = np.flatnonzero(np.concatenate(((True,), keys[1:] != keys[:-1])))
    cubes = np.append(first, len(keys))
    return Grid(points[order], order, cubes, _runs(keys[first].astype(np.int64), cubes, rows, layers), edge)


def _runs(used: NDArray[np.int64], cubes: NDArray[np.int64], rows: int, layers: int) -> NDArray[np.int32]:
    """Points of the columns of three cubes around each used cube."""
    runs = np.empty((len(used), 9, 2), np.int32)
    for number in range(9):
        middle = used + ((number // 3 - 1) * rows + number % 3 - 1) * layers
        runs[:, number, 0] = cubes[np.searchsorted(used, middle - 1)]
        runs[:, number, 1] = cubes[np.searchsorted(used, middle + 1, side="right")]
    return runs


def cube_of_point(grid: Grid) -> NDArray[np.int32]:
    """(N,) int32 cube of each sorted point."""
    return np.repeat(np.arange(len(grid.cubes) - 1, dtype=np.int32), np.diff(grid.cubes))


def slices_of(grid: Grid, parts: int) -> list[tuple[int, int]]:
    """Cubes in at most `parts` slices with about as many points each."""
    wanted = np.linspace(0, len(grid.points), parts + 1)[1:-1]
    cuts = np.unique(np.concatenate(((0, len(grid.cubes) - 1), np.searchsorted(grid.cubes, wanted))))
    return [(int(a), int(b)) for a, b in itertools.pairwise(cuts)]
