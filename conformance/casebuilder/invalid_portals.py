"""Invalid portals: the graph, and the polygons."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from casebuilder.edits import Edits, edits, in_table, setting
from casebuilder.state import Tables
from casebuilder.valid import STEP
from casebuilder.world import Portal, World
from casebuilder.worlds import (
    RING,
    RING_PORTALS,
    TOUCHING,
    UPPER,
    small_window,
    with_segment,
    x_portal,
    z_portal,
)

DELTA_OFFSETS = ("deltas.enteredOffsets", "deltas.leftOffsets", "deltas.switchOffsets")
DELTA_LISTS = (("deltas.entered",), ("deltas.left",), ("deltas.switchObjects", "deltas.switchCodes"))


def _delta_of(table: Tables, portal: int) -> list[list[np.ndarray]]:
    parts = []
    for offsets, lists in zip(DELTA_OFFSETS, DELTA_LISTS, strict=True):
        begin, end = (int(v) for v in table[offsets][portal : portal + 2])
        parts.append([table[name][begin:end].copy() for name in lists])
    return parts


def _swap_portals(sectors: list[Tables]) -> None:
    table = sectors[0]
    first = _delta_of(table, 0), _delta_of(table, 1)
    for name in ("portals.targets", "portals.polygons"):
        table[name][[0, 1]] = table[name][[1, 0]]
    for offsets, lists, swapped in zip(DELTA_OFFSETS, DELTA_LISTS, zip(*first, strict=True), strict=True):
        a, b = swapped
        middle = int(table[offsets][0]) + len(b[0])
        table[offsets][1] = middle
        for name, x, y in zip(lists, a, b, strict=True):
            table[name][: len(x) + len(y)] = np.concatenate((y, x))


def _drop_last(sectors: list[Tables]) -> None:
    table = sectors[0]
    last = len(table["portals.targets"]) - 1
    for offsets, lists in zip(DELTA_OFFSETS, DELTA_LISTS, strict=True):
        begin = int(table[offsets][last])
        table[offsets] = table[offsets][:-1].copy()
        for name in lists:
            table[name] = table[name][:begin].copy()
    for name in ("portals.targets", "portals.polygons"):
        table[name] = table[name][:-1].copy()
    table["portals.offsets"][-1] -= 1


GRAPH: dict[str, Edits] = {
    "portal/target-exists/no-such-cell": edits(tables=in_table("portals.targets", -1, 5)),
    "portal/target-exists/to-itself": edits(tables=in_table("portals.targets", -1, UPPER)),
    "portal/target-exists/not-ascending": edits(tables=_swap_portals),
    "portal/target-exists/no-such-polygon": edits(tables=in_table("portals.polygons", -1, 5)),
    "portal/symmetric/one-way": edits(tables=_drop_last, entry=setting("portalCount", value=9)),
    "portal/symmetric/other-polygon": edits(tables=in_table("portals.polygons", -1, 0)),
}

NAN = float("nan")
RAISED = tuple((x, y, z + 10 * STEP) for x, y, z in RING_PORTALS[UPPER].polygon)
FAR_PORTAL = z_portal((0, UPPER), 3, (0.5, 3), (-4, 4))


def _with_polygon(*vertices: tuple[float, float, float]) -> World:
    portals = (*RING_PORTALS[:UPPER], Portal(RING_PORTALS[UPPER].cells, vertices))
    return replace(RING, portals=portals)


POLYGONS: dict[str, Edits] = {
    "portal/shared-polygon/too-large": edits(
        world=_with_polygon((0.5, -5, 3), (3, -5, 3), (3, 4, 3), (0.5, 4, 3))
    ),
    "portal/shared-polygon/too-small": edits(
        world=_with_polygon((0.5, -3, 3), (3, -3, 3), (3, 4, 3), (0.5, 4, 3))
    ),
    "portal/shared-polygon/crossed": edits(
        world=_with_polygon((0.5, -4, 3), (3, 4, 3), (3, -4, 3), (0.5, 4, 3))
    ),
    "portal/shared-polygon/nan": edits(world=_with_polygon((NAN, -4, 3), (3, -4, 3), (3, 4, 3), (0.5, 4, 3))),
    "portal/shared-polygon/off-the-plane": edits(world=_with_polygon(*RAISED)),
    "portal/shared-polygon/two-vertices": edits(world=_with_polygon((0.5, -4, 3), (3, 4, 3))),
    "portal/shared-polygon/area-too-small": edits(world=small_window(STEP, STEP * 0.8125)),
    "portal/shared-polygon/not-neighbours": edits(world=replace(RING, portals=(*RING_PORTALS, FAR_PORTAL))),
    "portal/clear-of-geometry/wall-between": edits(
        world=replace(TOUCHING, portals=(x_portal((0, 1), 0, (-4, 4), (0.5, 3)),))
    ),
    "portal/clear-of-geometry/face-without-area": edits(
        world=replace(with_segment(-0.5, (-3.5, 1), (-3, 2)), clearance=0.0)
    ),
}

CASES = GRAPH | POLYGONS
