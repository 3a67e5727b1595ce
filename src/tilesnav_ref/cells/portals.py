"""Portals: the rectangles in which two cells touch.

References
----------
The pairs come from a sweep over the planes of the cells' sides (H. Edelsbrunner, "A new approach to rectangle
intersections", 1983, in its plain sorted form).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.buckets import FaceBuckets
from tilesnav_ref.cells.walls import blocked_rectangles
from tilesnav_ref.kernels import kernel


@dataclass(frozen=True)
class Contacts:
    """Pairs of boxes that touch in a rectangle of positive area."""

    pairs: NDArray[np.int64]
    """(Q, 2) first and second box; the second lies behind the upper side of the first."""
    rectangles: NDArray[np.int64]
    """(Q, 2, 3) opposite corners, grid."""
    axes: NDArray[np.int64]
    """(Q,) normal axis."""

    def select(self, keep: NDArray[np.bool_]) -> Contacts:
        """The contacts that are kept."""
        return Contacts(self.pairs[keep], self.rectangles[keep], self.axes[keep])

    def renumbered(self, order: NDArray[np.int64], count: int) -> Contacts:
        """The contacts between the boxes (N,) of an order, with their places in it; count is that of all."""
        place = np.full(count, -1, np.int64)
        place[order] = np.arange(len(order))
        pairs = place[self.pairs]
        keep = np.all(pairs >= 0, axis=1)
        return Contacts(pairs[keep], self.rectangles[keep], self.axes[keep])


@kernel
def _sweep(
    boxes: NDArray[np.int64],
    uppers: NDArray[np.int64],
    lowers: NDArray[np.int64],
    axis: int,
    pairs: NDArray[np.int64],
) -> int:
    """Write (or only count, pairs empty) the contacts along an axis.

    ``uppers`` and ``lowers`` hold the boxes sorted by (upper[axis], lower[i]) and (lower[axis], lower[i]).
    """
    i, j = (axis + 1) % 3, (axis + 2) % 3
    count, start, n = 0, 0, len(boxes)
    store = len(pairs) > 0
    reach = 0  # widest box along i: how far back an overlap can begin
    for b in range(n):
        reach = max(reach, boxes[b, 1, i] - boxes[b, 0, i])
    for u in range(n):
        first = uppers[u]
        plane, low, high = boxes[first, 1, axis], boxes[first, 0, i], boxes[first, 1, i]
        while start < n and (
            boxes[lowers[start], 0, axis] < plane
            or (boxes[lowers[start], 0, axis] == plane and boxes[lowers[start], 0, i] + reach <= low)
        ):
            start += 1
        s = start
        while s < n and boxes[lowers[s], 0, axis] == plane and boxes[lowers[s], 0, i] < high:
            second = lowers[s]
            if boxes[second, 1, i] > low and (
                min(boxes[first, 1, j], boxes[second, 1, j]) > max(boxes[first, 0, j], boxes[second, 0, j])
            ):
                if store:
                    pairs[count, 0], pairs[count, 1] = first, second
                count += 1
            s += 1
    return count


def find_contacts(boxes: NDArray[np.int64]) -> Contacts:
    """All pairs of boxes (B, 2, 3) with disjoint interiors that share a rectangle of positive area."""
    found, axes = [], []
    for axis in range(3):
        i = (axis + 1) % 3
        uppers = np.lexsort((boxes[:, 0, i], boxes[:, 1, axis]))
        lowers = np.lexsort((boxes[:, 0, i], boxes[:, 0, axis]))
        count = _sweep(boxes, uppers, lowers, axis, np.empty((0, 2), np.int64))
        pairs = np.empty((count, 2), np.int64)
        if count:
            _sweep(boxes, uppers, lowers, axis, pairs)
        found.append(pairs)
        axes.append(np.full(count, axis, np.int64))
    pairs, axis_of = np.concatenate(found), np.concatenate(axes)
    first, second = boxes[pairs[:, 0]], boxes[pairs[:, 1]]
    rectangles = np.stack(
        (np.maximum(first[:, 0], second[:, 0]), np.minimum(first[:, 1], second[:, 1])), axis=1
    )
    return Contacts(pairs, rectangles, axis_of)


def open_contacts(contacts: Contacts, walls: FaceBuckets | None) -> Contacts:
    """The contacts whose rectangle no face meets in its relative interior; all of them when walls is None."""
    if walls is None:
        return contacts
    return contacts.select(~blocked_rectangles(walls, contacts.rectangles, contacts.axes))


def rectangle_polygons(contacts: Contacts) -> NDArray[np.int64]:
    """Vertices of the rectangles in order, counter-clockwise about the positive axis; (Q, 4, 3) int64."""
    polygons = np.repeat(contacts.rectangles[:, :1], 4, axis=1)
    rows = np.arange(len(polygons))
    i, j = (contacts.axes + 1) % 3, (contacts.axes + 2) % 3
    high = contacts.rectangles[:, 1]
    for corner in (1, 2):
        polygons[rows, corner, i] = high[rows, i]
    for corner in (2, 3):
        polygons[rows, corner, j] = high[rows, j]
    return polygons


def portal_table(
    contacts: Contacts, count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Directed portals as offsets (N + 1,), targets (M,) ascending for each cell, and polygon indices
    (M,)."""
    sources = np.concatenate((contacts.pairs[:, 0], contacts.pairs[:, 1]))
    targets = np.concatenate((contacts.pairs[:, 1], contacts.pairs[:, 0]))
    polygons = np.tile(np.arange(len(contacts.pairs), dtype=np.int64), 2)
    order = np.lexsort((targets, sources))
    degrees = np.bincount(sources, minlength=count)
    offsets = np.concatenate((np.zeros(1, np.int64), np.cumsum(degrees, dtype=np.int64)))
    return offsets, targets[order], polygons[order]
