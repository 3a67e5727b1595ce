"""The tree of tiles of the greedy decomposition."""

from __future__ import annotations

import numpy as np

from tilesnav_ref.cells.greedy import NODES, collect_kept, prune
from tilesnav_ref.cells.prisms import WIDTH


def test_prism_at_the_end_of_the_longest_chain_is_collected() -> None:
    """Where one thin strip after the other is cut off, all of them wait for the tile at the end."""
    children, values = np.full(NODES, -1, np.int64), np.zeros(NODES)
    spans, rows = np.zeros((NODES, 2), np.int64), np.arange(WIDTH, dtype=np.int64)[None]
    count = NODES - 1
    children[0:1] = 1
    children[1 : count - 2 : 2] = np.arange(3, count, 2)  # the first part of each goes on
    spans[count - 2], values[count - 2] = (0, 1), 5.0
    keeps = np.empty(count, np.bool_)
    prune(children, values, count, keeps)
    assert values[0] == 5.0
    assert not keeps[0]
    result = np.zeros((4, WIDTH), np.int64)
    kernel = getattr(collect_kept, "py_func", collect_kept)  # compiled, it would write behind its arrays
    assert kernel(children, keeps, spans, rows, result) == 1
    assert np.array_equal(result[0], rows[0])
