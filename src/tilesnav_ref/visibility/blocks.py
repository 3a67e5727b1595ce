"""Blocks of neighbouring cells: what is hidden from a block is hidden from each of its cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Block:
    """A set of cells, the box around them, and its two halves (none for a single cell)."""

    cells: tuple[int, ...]
    box: NDArray[np.float64]
    """(2, 3) fine units."""
    halves: tuple[Block, ...]


def make_groups(boxes: NDArray[np.float64], cells: NDArray[np.int64], limit: int) -> list[NDArray[np.int64]]:
    """Groups of at most `limit` of some cells by median cuts of the cell middles; boxes is (N, 2, 3)."""
    groups: list[NDArray[np.int64]] = []
    waiting = [cells]
    while waiting:
        part = waiting.pop()
        if len(part) <= limit:
            groups.append(part)
        else:
            waiting.extend(reversed(_halves(boxes, part)))
    return groups


def make_blocks(boxes: NDArray[np.float64], cells: NDArray[np.int64], limit: int) -> list[Block]:
    """Blocks of at most `limit` of some cells."""
    return [_tree(boxes, part) for part in make_groups(boxes, cells, limit)]


def _halves(boxes: NDArray[np.float64], cells: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    middles = boxes[cells].sum(axis=1)
    axis = int(np.argmax(np.ptp(middles, axis=0)))
    order = cells[np.argsort(middles[:, axis], kind="stable")]
    return [order[: len(order) // 2], order[len(order) // 2 :]]


def _tree(boxes: NDArray[np.float64], cells: NDArray[np.int64]) -> Block:
    box = np.stack([boxes[cells, 0].min(axis=0), boxes[cells, 1].max(axis=0)])
    halves = tuple(_tree(boxes, half) for half in _halves(boxes, cells)) if len(cells) > 1 else ()
    return Block(tuple(int(c) for c in cells), box, halves)
