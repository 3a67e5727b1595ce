"""Prisms over trapezoids as rows of integers, and what follows from a row.

Notes
-----
A row holds ``u, v, w, u0, u1, w0, w1, l0, l1, h0, h1``: three axes, each once; the range along u and along w;
the lower side across v runs from l0 at u0 to l1 at u1, the upper side from h0 to h1. A box is a prism with
l0 = l1 and h0 = h1; its axes are then 0, 1, 2, so that equal boxes are equal rows.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel

WIDTH = 11
"""Integers in a row."""
U, V, W, U0, U1, W0, W1, L0, L1, H0, H1 = range(WIDTH)


@kernel
def write_box(lower: NDArray[np.int64], upper: NDArray[np.int64], row: NDArray[np.int64]) -> None:
    """Write the row of a box."""
    row[U], row[V], row[W] = 0, 1, 2
    row[U0], row[U1], row[W0], row[W1] = lower[0], upper[0], lower[2], upper[2]
    row[L0], row[L1], row[H0], row[H1] = lower[1], lower[1], upper[1], upper[1]


@kernel
def is_box(row: NDArray[np.int64]) -> bool:
    """Whether both sides across v are flat."""
    return bool(row[L0] == row[L1] and row[H0] == row[H1])


@kernel
def write_bounds(row: NDArray[np.int64], bounds: NDArray[np.int64]) -> None:
    """Write the bounds of a row to (2, 3)."""
    bounds[0, row[U]], bounds[1, row[U]] = row[U0], row[U1]
    bounds[0, row[W]], bounds[1, row[W]] = row[W0], row[W1]
    bounds[0, row[V]], bounds[1, row[V]] = min(row[L0], row[L1]), max(row[H0], row[H1])


@kernel
def move(row: NDArray[np.int64], shift: NDArray[np.int64], result: NDArray[np.int64]) -> None:
    """Write the row moved by a vector (3,)."""
    result[:] = row
    for k in range(U0, W0):
        result[k] += shift[row[U]]
    for k in range(W0, L0):
        result[k] += shift[row[W]]
    for k in range(L0, WIDTH):
        result[k] += shift[row[V]]


@kernel
def holds_point(row: NDArray[np.int64], point: NDArray[np.int64]) -> bool:
    """Whether the closed prism holds a point (3,); exact for coordinates below 2**24 in magnitude."""
    u, v, w = point[row[U]], point[row[V]], point[row[W]]
    if not (row[U0] <= u <= row[U1] and row[W0] <= w <= row[W1]):
        return False
    run, along = row[U1] - row[U0], u - row[U0]
    if (v - row[L0]) * run < (row[L1] - row[L0]) * along:
        return False
    return bool((v - row[H0]) * run <= (row[H1] - row[H0]) * along)


def prisms_of_boxes(boxes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Rows (B, 11) of boxes (B, 2, 3)."""
    rows = np.empty((len(boxes), WIDTH), np.int64)
    rows[:, [U, V, W]] = np.arange(3)
    rows[:, [U0, U1, W0, W1]] = boxes[:, [0, 1, 0, 1], [0, 0, 2, 2]]
    rows[:, [L0, L1, H0, H1]] = boxes[:, [0, 0, 1, 1], [1, 1, 1, 1]]
    return rows


def prism_corners(rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """Corners (P, 8, 3) of rows (P, 11); corner i is on the upper side of axis k where bit k of i is set.

    Examples
    --------
    >>> prism_corners(np.array([[1, 0, 2, 0, 8, 0, 5, 1, 3, 9, 9]]))[0, 2].tolist()
    [3, 8, 0]
    """
    corners = np.empty((len(rows), 8, 3), np.int64)
    every = np.arange(len(rows))
    for corner in range(8):
        up = (corner >> rows[:, [U, V, W]]) & 1
        corners[every, corner, rows[:, U]] = rows[every, U0 + up[:, 0]]
        corners[every, corner, rows[:, V]] = rows[every, L0 + 2 * up[:, 1] + up[:, 0]]
        corners[every, corner, rows[:, W]] = rows[every, W0 + up[:, 2]]
    return corners


def prism_bounds(rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """Bounds (P, 2, 3) of rows (P, 11)."""
    corners = prism_corners(rows)
    return np.stack((corners.min(axis=1), corners.max(axis=1)), axis=1)


def with_plain_boxes(rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """The rows (P, 11), those that are boxes with the axes 0, 1, 2."""
    flat = (rows[:, L0] == rows[:, L1]) & (rows[:, H0] == rows[:, H1])
    return np.where(flat[:, None], prisms_of_boxes(prism_bounds(rows)), rows)
