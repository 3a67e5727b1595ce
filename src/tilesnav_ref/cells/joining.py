"""Greedy joining of prisms whose union is a prism.

Notes
-----
Two prisms with the same axes share a whole side, and are one, in three ways: along w with the same trapezoid,
along u where their slanted sides go on in one line, along v with a common line between them. A box takes part
with any axes. Pairs are found by equal keys of the shared sides, and passes repeat until nothing changes. The
union is judged by the exact test like any other cell: without a clearance a thin wall can lie between.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.buckets import FaceBuckets
from tilesnav_ref.cells.meeting import prisms_with_faces
from tilesnav_ref.cells.prisms import (
    H0,
    H1,
    L0,
    L1,
    U0,
    U1,
    W0,
    W1,
    U,
    V,
    W,
    prism_bounds,
    prism_corners,
    with_plain_boxes,
)
from tilesnav_ref.kernels import kernel

_BEFORE = ((U0, U1, L0, L1, H0, H1, W1), (W0, W1, L1, H1, U1), (U0, U1, W0, W1, H0, H1))
_BEHIND = ((U0, U1, L0, L1, H0, H1, W0), (W0, W1, L0, H0, U0), (U0, U1, W0, W1, L0, L1))
"""What must be equal of a prism and the one behind it, along w, u and v."""
_TAKEN = ((W1,), (U1, L1, H1), (H0, H1))
"""What the union takes from the one behind."""

_MIXER = np.uint64(0x9E3779B97F4A7C15)
"""2**64 over the golden ratio, odd: D. E. Knuth, "The Art of Computer Programming", volume 3, 6.4."""
_AXES = ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0))


def _in_axes(prisms: NDArray[np.int64], axes: tuple[int, int, int]) -> tuple[NDArray[np.int64], ...]:
    """Numbers of the prisms that can be written with these axes u, v, w, and their rows."""
    flat = (prisms[:, L0] == prisms[:, L1]) & (prisms[:, H0] == prisms[:, H1])
    numbers = np.flatnonzero(flat | np.all(prisms[:, [U, V, W]] == axes, axis=1))
    rows, bounds = prisms[numbers].copy(), prism_bounds(prisms[numbers])
    boxes = np.flatnonzero(flat[numbers])
    u, v, w = axes
    rows[boxes, U], rows[boxes, V], rows[boxes, W] = u, v, w
    for columns, axis, side in (
        ((U0,), u, 0),
        ((U1,), u, 1),
        ((W0,), w, 0),
        ((W1,), w, 1),
        ((L0, L1), v, 0),
        ((H0, H1), v, 1),
    ):
        for column in columns:
            rows[boxes, column] = bounds[boxes, side, axis]
    return numbers, rows


def _mixed(keys: NDArray[np.int64]) -> NDArray[np.uint64]:
    """One number for each row of keys (K, C); (K,)."""
    codes = np.zeros(len(keys), np.uint64)
    for column in range(keys.shape[1]):
        codes ^= keys[:, column].astype(np.uint64)
        codes *= _MIXER
        codes ^= codes >> np.uint64(29)
    return codes


def _matches(before: NDArray[np.int64], behind: NDArray[np.int64]) -> NDArray[np.int64]:
    """Pairs (Q, 2) of rows with equal keys; each row has at most one partner, since prisms are disjoint.

    Rows are brought together by a 64-bit mixture of their numbers and then compared, so that two keys with
    the same mixture could at worst hide a pair.
    """
    first, second = _mixed(before), _mixed(behind)
    order = np.argsort(second, kind="stable")
    place = np.searchsorted(second[order], first)
    partner = order[np.minimum(place, len(order) - 1)] if len(order) else place
    found = np.flatnonzero(np.all(before == behind[partner], axis=1)) if len(order) else place
    return np.column_stack((found, partner[found]))


@kernel
def _independent(pairs: NDArray[np.int64], used: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which pairs are taken, in order, so that no row is in two of them."""
    taken = np.zeros(len(pairs), np.bool_)
    for p in range(len(pairs)):
        if not used[pairs[p, 0]] and not used[pairs[p, 1]]:
            used[pairs[p, 0]] = used[pairs[p, 1]] = taken[p] = True
    return taken


def _collinear(before: NDArray[np.int64], behind: NDArray[np.int64]) -> NDArray[np.bool_]:
    one, two = before[:, U1] - before[:, U0], behind[:, U1] - behind[:, U0]
    lower = (before[:, L1] - before[:, L0]) * two == (behind[:, L1] - behind[:, L0]) * one
    upper = (before[:, H1] - before[:, H0]) * two == (behind[:, H1] - behind[:, H0]) * one
    return np.asarray(lower & upper)


def _join(
    prisms: NDArray[np.int64],
    axes: tuple[int, int, int],
    way: int,
    limits: tuple[int, int],
    buckets: FaceBuckets,
) -> NDArray[np.int64]:
    """One pass along w (way 0), u (1) or v (2)."""
    numbers, rows = _in_axes(prisms, axes)
    pairs = _matches(rows[:, _BEFORE[way]], rows[:, _BEHIND[way]])
    before, behind = rows[pairs[:, 0]], rows[pairs[:, 1]]
    union = before.copy()
    for column in _TAKEN[way]:
        union[:, column] = behind[:, column]
    extents = np.ptp(prism_corners(union), axis=1)
    legal = np.all(extents <= limits[0], axis=1)
    if way == 1:
        legal &= _collinear(before, behind)
    pairs, union = pairs[legal], union[legal]
    clear = ~prisms_with_faces(buckets, union, limits[1])
    pairs, union = pairs[clear], union[clear]
    taken = _independent(pairs, np.zeros(len(rows), np.bool_))
    if not np.any(taken):
        return prisms
    result, gone = prisms.copy(), np.zeros(len(prisms), np.bool_)
    result[numbers[pairs[taken, 0]]] = union[taken]
    gone[numbers[pairs[taken, 1]]] = True
    return result[~gone]


def join_prisms(
    prisms: NDArray[np.int64], max_size: int, clearance: int, buckets: FaceBuckets
) -> NDArray[np.int64]:
    """Join prisms to larger ones.

    Parameters
    ----------
    prisms
        (P, 11) rows, disjoint interiors.
    max_size
        Largest extent along an axis, grid steps.
    clearance
        Grid steps; see `meeting.inflate`.
    buckets
        Faces.

    Returns
    -------
    ndarray
        (P', 11) int64; the same point set, P' <= P.
    """
    # most cells of open air are as large as may be; whatever they were joined with would be too large
    full = np.all(np.ptp(prism_corners(prisms), axis=1) == max_size, axis=1)
    done, prisms, count = prisms[full], prisms[~full], -1
    while len(prisms) != count:
        count = len(prisms)
        for axes in _AXES:
            for way in range(3):
                prisms = _join(prisms, axes, way, (max_size, clearance), buckets)
    return with_plain_boxes(np.concatenate((done, prisms)))
