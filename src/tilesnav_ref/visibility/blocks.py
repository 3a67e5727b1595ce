"""Blocks of neighbouring cells: what is hidden from a block is hidden from each of its cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.visibility.prisms import bounds_of, box_prism


@dataclass(frozen=True)
class Block:
    """A set of cells, a prism that holds them, and its two halves (none for a single cell)."""

    cells: tuple[int, ...]
    region: NDArray[np.float64]
    """(8, 3) the box around the cells, or the single cell itself; fine units."""
    halves: tuple[Block, ...]


def make_groups(prisms: NDArray[np.float64], cells: NDArray[np.int64], limit: int) -> list[NDArray[np.int64]]:
    """Groups of at most `limit` of some cells by median cuts of the cell middles; prisms is (N, 8, 3)."""
    return _groups(bounds_of(prisms), cells, limit)


def _groups(boxes: NDArray[np.float64], cells: NDArray[np.int64], limit: int) -> list[NDArray[np.int64]]:
    groups: list[NDArray[np.int64]] = []
    waiting = [cells]
    while waiting:
        part = waiting.pop()
        if len(part) <= limit:
            groups.append(part)
        else:
            waiting.extend(reversed(_halves(boxes, part)))
    return groups


def make_blocks(prisms: NDArray[np.float64], cells: NDArray[np.int64], limit: int) -> list[Block]:
    """Blocks of at most `limit` of some cells; prisms is (N, 8, 3)."""
    boxes = bounds_of(prisms)
    return [_tree((boxes, prisms), part) for part in _groups(boxes, cells, limit)]


def _halves(boxes: NDArray[np.float64], cells: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    middles = boxes[cells].sum(axis=1)
    axis = int(np.argmax(np.ptp(middles, axis=0)))
    order = cells[np.argsort(middles[:, axis], kind="stable")]
    return [order[: len(order) // 2], order[len(order) // 2 :]]


def _tree(shapes: tuple[NDArray[np.float64], NDArray[np.float64]], cells: NDArray[np.int64]) -> Block:
    boxes, prisms = shapes
    numbers = tuple(int(c) for c in cells)
    if len(cells) == 1:
        return Block(numbers, np.ascontiguousarray(prisms[cells[0]]), ())
    box = np.stack([boxes[cells, 0].min(axis=0), boxes[cells, 1].max(axis=0)])
    return Block(numbers, box_prism(box), tuple(_tree(shapes, half) for half in _halves(boxes, cells)))
