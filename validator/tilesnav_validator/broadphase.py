"""Pairs of overlapping bounding boxes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_BLOCK = 64
_MOST = 2_000_000


def _morton_order(centres: FloatArray) -> IntArray:
    """Order of positions along a Z curve of 2^10 cells a side, so that neighbours in it are near."""
    low, span = centres.min(axis=0), np.maximum(np.ptp(centres, axis=0), 1e-300)
    cell = np.minimum((centres - low) / span * 1024, 1023).astype(np.int64)
    code = np.zeros(len(centres), dtype=np.int64)
    for bit in range(10):
        for axis in range(3):
            code |= ((cell[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.argsort(code, kind="stable").astype(np.int64)


def overlaps(
    low_a: FloatArray, high_a: FloatArray, low_b: FloatArray, high_b: FloatArray
) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield the pairs (i, j) for which box i of a and box j of b have a common point, in portions.

    Parameters
    ----------
    low_a, high_a : ndarray of float64, shape (m, 3)
    low_b, high_b : ndarray of float64, shape (n, 3)

    Notes
    -----
    Boxes of a are taken in blocks of neighbours; the box of a block picks the boxes of b that its members are
    compared with.
    """
    if not len(low_a) or not len(low_b):
        return
    order = _morton_order((low_a + high_a) / 2)
    for start in range(0, len(order), _BLOCK):
        block = order[start : start + _BLOCK]
        low, high = low_a[block].min(axis=0), high_a[block].max(axis=0)
        near = np.flatnonzero(_hit(low, high, low_b, high_b))
        for part in range(0, len(near), _MOST // _BLOCK):
            some = near[part : part + _MOST // _BLOCK]
            hit = _hit(low_a[block, None], high_a[block, None], low_b[some][None], high_b[some][None])
            i, j = np.nonzero(hit)
            if len(i):
                yield block[i], some[j]


def _hit(low_a: FloatArray, high_a: FloatArray, low_b: FloatArray, high_b: FloatArray) -> NDArray[np.bool_]:
    """Overlap of boxes whose shapes broadcast."""
    hit = (low_a[..., 0] <= high_b[..., 0]) & (low_b[..., 0] <= high_a[..., 0])
    for axis in (1, 2):
        hit &= (low_a[..., axis] <= high_b[..., axis]) & (low_b[..., axis] <= high_a[..., axis])
    return np.asarray(hit)
