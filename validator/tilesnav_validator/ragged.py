"""Ragged lists: N + 1 offsets into one array of elements."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int64]


def rows(offsets: IntArray) -> IntArray:
    """Number of the list that each element belongs to.

    Parameters
    ----------
    offsets : ndarray of int64, shape (n + 1,)

    Returns
    -------
    ndarray of int64, shape (offsets[-1] - offsets[0],)
    """
    return np.repeat(np.arange(len(offsets) - 1, dtype=np.int64), np.diff(offsets))


def not_ascending(values: NDArray[Any], offsets: IntArray) -> IntArray:
    """Indices of the elements that are not greater than the one before them in the same list."""
    if len(values) < 2:
        return np.zeros(0, np.int64)
    falls = np.zeros(len(values), dtype=bool)
    falls[1:] = values[1:] <= values[:-1]
    starts = offsets[:-1]
    falls[starts[starts < len(values)]] = False
    return np.flatnonzero(falls).astype(np.int64)


def take(offsets: IntArray, which: IntArray) -> tuple[IntArray, IntArray]:
    """Elements of chosen lists, one list after the other.

    Parameters
    ----------
    offsets : ndarray of int64, shape (n + 1,)
    which : ndarray of int64, shape (k,)

    Returns
    -------
    position : ndarray of int64
        For each element the position in ``which`` of its list.
    index : ndarray of int64
        For each element its index in the array of elements.
    """
    lengths = offsets[which + 1] - offsets[which]
    position = np.repeat(np.arange(len(which), dtype=np.int64), lengths)
    before = np.repeat(np.cumsum(lengths) - lengths, lengths)
    index = np.arange(len(position), dtype=np.int64) - before + offsets[which][position]
    return position, index
