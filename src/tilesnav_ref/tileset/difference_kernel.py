"""Differences of sorted lists by merging.

References
----------
Knuth, The Art of Computer Programming, volume 3, section 5.2.4 (merging).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel

__all__ = ["count_differences", "fill_differences"]


@kernel
def count_differences(
    offsets: NDArray[np.int64],
    values: NDArray[Any],
    kept: NDArray[np.int64],
    removed: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Count the elements of list kept[k] that are not in list removed[k], for every k.

    Parameters
    ----------
    offsets : (N + 1,) int64
        Bounds of the lists in `values`.
    values : (P,) uint32 or uint64
        Strictly ascending within each list.
    kept, removed : (M,) int64
        Numbers of lists.

    Returns
    -------
    (M,) int64

    Examples
    --------
    >>> lists = np.array([1, 4, 6, 4, 7], dtype=np.uint32)
    >>> count_differences(np.array([0, 3, 5]), lists, np.array([0, 1]), np.array([1, 0])).tolist()
    [2, 1]
    """
    counts = np.zeros(len(kept), dtype=np.int64)
    for k in range(len(kept)):
        i, i_end = offsets[kept[k]], offsets[kept[k] + 1]
        j, j_end = offsets[removed[k]], offsets[removed[k] + 1]
        while i < i_end:
            while j < j_end and values[j] < values[i]:
                j += 1
            if j == j_end or values[j] != values[i]:
                counts[k] += 1
            i += 1
    return counts


@kernel
def fill_differences(
    offsets: NDArray[np.int64],
    values: NDArray[Any],
    kept: NDArray[np.int64],
    removed: NDArray[np.int64],
    total: int,
) -> NDArray[Any]:
    """List the elements that `count_differences` counts, list after list, ascending within each.

    Parameters
    ----------
    offsets, values, kept, removed
        As in `count_differences`.
    total : int
        Sum of the counts.

    Returns
    -------
    (total,) of the type of `values`
    """
    out = np.empty(total, dtype=values.dtype)
    n = 0
    for k in range(len(kept)):
        i, i_end = offsets[kept[k]], offsets[kept[k] + 1]
        j, j_end = offsets[removed[k]], offsets[removed[k] + 1]
        while i < i_end:
            while j < j_end and values[j] < values[i]:
                j += 1
            if j == j_end or values[j] != values[i]:
                out[n] = values[i]
                n += 1
            i += 1
    return out
