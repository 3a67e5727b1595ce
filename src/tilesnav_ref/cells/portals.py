"""Portals: the convex polygons in which flat sides of two cells touch.

Notes
-----
Sides across u and w, and flat sides across v, are normal to an axis. Two that lie in one plane and face each
other share a rectangle with corners on the grid, or, where one is a trapezoid, a polygon of up to eight
vertices that clipping finds in floating point: coordinates below 2**23 steps leave errors below 2**-20 steps.
Slanted sides of two cells never coincide in a decomposition into full tiles, and give no portal.

References
----------
The pairs come from a sweep over the planes of the cells' sides (H. Edelsbrunner, "A new approach to rectangle
intersections", 1983, in its plain sorted form).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.buckets import FaceBuckets
from tilesnav_ref.cells.prisms import prism_corners
from tilesnav_ref.cells.walls import blocked_rectangles
from tilesnav_ref.kernels import kernel

VERTICES = 8
"""Most vertices of two quadrilaterals' common part."""
LEAST_AREA = 1.0
"""Square grid steps; the format asks for more in a portal."""
LEAST_WIDTH = 0.5
"""Area over diameter in grid steps: thinner slivers are lines at the precision of portals."""
LEAST_EDGE = 0.25
"""Grid steps; of two vertices that are nearer only one is kept, a quarter of what the format allows."""


@dataclass(frozen=True)
class Contacts:
    """Pairs of cells that touch in a polygon of positive area."""

    pairs: NDArray[np.int64]
    """(Q, 2) first and second cell; the second lies behind the upper side of the first."""
    rectangles: NDArray[np.int64]
    """(Q, 2, 3) corners of a rectangle that holds the polygon, grid."""
    axes: NDArray[np.int64]
    """(Q,) normal axis."""
    vertices: NDArray[np.float64]
    """(Q, 8, 3) grid, counter-clockwise about the positive axis."""
    counts: NDArray[np.int64]
    """(Q,) number of vertices."""

    def select(self, keep: NDArray[np.bool_]) -> Contacts:
        """The contacts that are kept."""
        return Contacts(
            self.pairs[keep], self.rectangles[keep], self.axes[keep], self.vertices[keep], self.counts[keep]
        )

    def renumbered(self, order: NDArray[np.int64], count: int) -> Contacts:
        """Contacts between the cells order (N',) of ``count``, which become 0 to N' - 1."""
        number = np.full(count, -1, np.int64)
        number[order] = np.arange(len(order))
        pairs = number[self.pairs]
        return replace(self, pairs=pairs).select(np.all(pairs >= 0, axis=1))

    def polygons(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Offsets (Q + 1,) and vertices (K, 3) of the polygons."""
        offsets = np.concatenate((np.zeros(1, np.int64), np.cumsum(self.counts, dtype=np.int64)))
        return offsets, self.vertices[np.arange(VERTICES) < self.counts[:, None]]


@dataclass(frozen=True)
class _Sides:
    """Flat sides across one axis, all upper or all lower ones, sorted by (plane, least coordinate i)."""

    cells: NDArray[np.int64]
    """(S,) cell of each side."""
    bounds: NDArray[np.int64]
    """(S, 5) coordinate of the plane, least and greatest i, least and greatest j."""
    quads: NDArray[np.int64]
    """(S, 4, 2) corners (i, j), counter-clockwise."""


def _flat_sides(corners: NDArray[np.int64], axis: int, upper: bool) -> _Sides:
    i, j = (axis + 1) % 3, (axis + 2) % 3
    base = (1 << axis) if upper else 0
    around = np.array([base, base | 1 << i, base | 1 << i | 1 << j, base | 1 << j])
    side = corners[:, around]
    cells = np.flatnonzero(np.all(side[:, :, axis] == side[:, :1, axis], axis=1))
    side = side[cells]
    quads = side[:, :, [i, j]]
    low, high = quads.min(axis=1), quads.max(axis=1)
    bounds = np.column_stack((side[:, 0, axis], low[:, 0], high[:, 0], low[:, 1], high[:, 1]))
    order = np.lexsort((bounds[:, 1], bounds[:, 0]))
    return _Sides(cells[order], np.ascontiguousarray(bounds[order]), quads[order])


@kernel
def _sweep(uppers: NDArray[np.int64], lowers: NDArray[np.int64], pairs: NDArray[np.int64]) -> int:
    """Write (or only count, pairs empty) the sides whose bounds (S, 5) overlap in one plane."""
    count, start, n = 0, 0, len(lowers)
    store = len(pairs) > 0
    reach = 0  # widest side along i: how far back an overlap can begin
    for b in range(n):
        reach = max(reach, lowers[b, 2] - lowers[b, 1])
    for u in range(len(uppers)):
        plane, low, high = uppers[u, 0], uppers[u, 1], uppers[u, 2]
        while start < n and (
            lowers[start, 0] < plane or (lowers[start, 0] == plane and lowers[start, 1] + reach <= low)
        ):
            start += 1
        s = start
        while s < n and lowers[s, 0] == plane and lowers[s, 1] < high:
            overlap = min(uppers[u, 4], lowers[s, 4]) > max(uppers[u, 3], lowers[s, 3])
            if lowers[s, 2] > low and overlap:
                if store:
                    pairs[count, 0], pairs[count, 1] = u, s
                count += 1
            s += 1
    return count


@kernel
def _cut(
    polygon: NDArray[np.float64], count: int, edge: NDArray[np.float64], result: NDArray[np.float64]
) -> int:
    """Write the part of a polygon on the left of an edge (2, 2); returns its vertices."""
    ei, ej = edge[1, 0] - edge[0, 0], edge[1, 1] - edge[0, 1]
    kept = 0
    for a in range(count):
        b = a + 1 if a + 1 < count else 0
        one = ei * (polygon[a, 1] - edge[0, 1]) - ej * (polygon[a, 0] - edge[0, 0])
        two = ei * (polygon[b, 1] - edge[0, 1]) - ej * (polygon[b, 0] - edge[0, 0])
        if one >= 0.0 and kept < VERTICES:
            result[kept] = polygon[a]
            kept += 1
        if ((one > 0.0 > two) or (one < 0.0 < two)) and kept < VERTICES:
            result[kept] = polygon[a] + one / (one - two) * (polygon[b] - polygon[a])
            kept += 1
    return kept


@kernel
def _without_short_edges(polygon: NDArray[np.float64], count: int) -> int:
    kept = 0
    for a in range(count):
        last = polygon[kept - 1] if kept > 0 else polygon[count - 1]
        if kept == 0 or abs(polygon[a, 0] - last[0]) + abs(polygon[a, 1] - last[1]) > LEAST_EDGE:
            polygon[kept] = polygon[a]
            kept += 1
    while kept > 1 and (
        abs(polygon[kept - 1, 0] - polygon[0, 0]) + abs(polygon[kept - 1, 1] - polygon[0, 1]) <= LEAST_EDGE
    ):
        kept -= 1
    return kept


@kernel
def _common_parts(
    first: NDArray[np.int64], second: NDArray[np.int64], parts: NDArray[np.float64], counts: NDArray[np.int64]
) -> None:
    """Write the common part of each pair of quadrilaterals (Q, 4, 2) to parts (Q, 8, 2) and counts (Q,)."""
    edge, room = np.empty((2, 2)), np.empty((2, VERTICES, 2))
    for q in range(len(first)):
        count, turn = 4, 0
        room[0, :4] = first[q].astype(np.float64)
        for a in range(4):
            edge[0], edge[1] = second[q, a], second[q, (a + 1) % 4]
            count = _cut(room[turn], count, edge, room[1 - turn])
            turn = 1 - turn
        counts[q] = _without_short_edges(room[turn], count)
        parts[q] = room[turn]


@kernel
def _are_wide(parts: NDArray[np.float64], counts: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which polygons (Q, 8, 2) have the area and width of a portal."""
    wide = np.zeros(len(parts), np.bool_)
    for q in range(len(parts)):
        twice, diameter = 0.0, 0.0
        for a in range(1, counts[q]):
            i, j = parts[q, a, 0] - parts[q, 0, 0], parts[q, a, 1] - parts[q, 0, 1]
            diameter = max(diameter, i * i + j * j)
            if a + 1 < counts[q]:
                twice += i * (parts[q, a + 1, 1] - parts[q, 0, 1]) - j * (parts[q, a + 1, 0] - parts[q, 0, 0])
        wide[q] = twice / 2.0 > LEAST_AREA and twice / 2.0 > LEAST_WIDTH * np.sqrt(diameter)
    return wide


def _contacts_across(corners: NDArray[np.int64], axis: int) -> Contacts:
    uppers, lowers = _flat_sides(corners, axis, True), _flat_sides(corners, axis, False)
    count = _sweep(uppers.bounds, lowers.bounds, np.empty((0, 2), np.int64))
    found = np.empty((count, 2), np.int64)
    if count:
        _sweep(uppers.bounds, lowers.bounds, found)
    first, second = uppers.bounds[found[:, 0]], lowers.bounds[found[:, 1]]
    low, high = (
        np.maximum(first[:, [1, 3]], second[:, [1, 3]]),
        np.minimum(first[:, [2, 4]], second[:, [2, 4]]),
    )
    parts, counts = np.zeros((count, VERTICES, 2)), np.full(count, 4, np.int64)
    parts[:, 0], parts[:, 2] = low, high
    parts[:, 1, 0], parts[:, 1, 1], parts[:, 3, 0], parts[:, 3, 1] = (
        high[:, 0],
        low[:, 1],
        low[:, 0],
        high[:, 1],
    )
    slanted = np.flatnonzero(~(_is_rectangle(uppers)[found[:, 0]] & _is_rectangle(lowers)[found[:, 1]]))
    if len(slanted):
        some, numbers = np.zeros((len(slanted), VERTICES, 2)), np.empty(len(slanted), np.int64)
        _common_parts(uppers.quads[found[slanted, 0]], lowers.quads[found[slanted, 1]], some, numbers)
        parts[slanted], counts[slanted] = some, numbers
    rectangles, vertices = np.empty((count, 2, 3), np.int64), np.empty((count, VERTICES, 3))
    rectangles[:, :, axis], vertices[:, :, axis] = first[:, :1], first[:, :1]
    for place, k in enumerate(((axis + 1) % 3, (axis + 2) % 3)):
        rectangles[:, 0, k], rectangles[:, 1, k] = low[:, place], high[:, place]
        vertices[:, :, k] = parts[:, :, place]
    pairs = np.column_stack((uppers.cells[found[:, 0]], lowers.cells[found[:, 1]]))
    contacts = Contacts(pairs, rectangles, np.full(count, axis, np.int64), vertices, counts)
    return contacts.select(_are_wide(parts, counts))


def _is_rectangle(sides: _Sides) -> NDArray[np.bool_]:
    low, high = sides.quads.min(axis=1, keepdims=True), sides.quads.max(axis=1, keepdims=True)
    return np.asarray(np.all((sides.quads == low) | (sides.quads == high), axis=(1, 2)))


def find_contacts(prisms: NDArray[np.int64]) -> Contacts:
    """All pairs of prisms (P, 11) with disjoint interiors whose flat sides share a polygon."""
    corners = prism_corners(prisms)
    parts = [_contacts_across(corners, axis) for axis in range(3)]
    return Contacts(
        np.concatenate([part.pairs for part in parts]),
        np.concatenate([part.rectangles for part in parts]),
        np.concatenate([part.axes for part in parts]),
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.counts for part in parts]),
    )


def open_contacts(contacts: Contacts, walls: FaceBuckets | None) -> Contacts:
    """The contacts whose rectangle no face meets in its relative interior; all of them when walls is None.

    A face that meets the rectangle beside a polygon that is smaller takes the contact away too.
    """
    if walls is None:
        return contacts
    return contacts.select(~blocked_rectangles(walls, contacts.rectangles, contacts.axes))


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
