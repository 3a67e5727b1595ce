"""Invalid cells: planes, shapes, and where they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from casebuilder.assemble import Json
from casebuilder.edits import Edits, adding, edits, in_table, whole_table
from casebuilder.valid import STEP
from casebuilder.world import Cell, World, box_cell
from casebuilder.worlds import (
    EAST,
    RING,
    RING_PORTALS,
    UPPER,
    prism_with_tip,
    spare_box,
    with_segment,
    with_spare,
)


def _seventh(planes: np.ndarray) -> np.ndarray:
    return np.concatenate((planes, planes[:, :1]), axis=1)


PLANES: dict[str, Edits] = {
    "cell/exactly-six-planes/seven": edits(tables=whole_table("cells.planes", _seventh)),
    "cell/exactly-six-planes/five": edits(tables=whole_table("cells.planes", lambda t: t[:, :5].copy())),
    "cell/unit-normals/length-two": edits(tables=in_table("cells.planes", (0, 0), (-2, 0, 0, -8))),
    "cell/unit-normals/nan": edits(tables=in_table("cells.planes", (0, 0, 0), float("nan"))),
    "cell/unit-normals/infinite": edits(tables=in_table("cells.planes", (UPPER, 5, 3), float("-inf"))),
    "cell/unit-normals/zero": edits(tables=in_table("cells.planes", (UPPER, 5, 2), 0)),
    "cell/unit-normals/rounded-too-far": edits(tables=in_table("cells.planes", (0, 0, 0), -1 - 2.0**-39)),
    "cell/known-kind/kind-two": edits(tables=in_table("cells.kinds", 0, 2)),
}


def _flat_prism() -> Cell:
    """Triangular prism with a sixth plane that touches nothing."""
    planes = prism_with_tip(0.1).planes
    return Cell((*planes[:5], (0.0, 1.0, 0.0, -8.0)))


def _five_planes() -> Cell:
    prism = prism_with_tip(0.0)
    return Cell((*prism.planes[:5], prism.planes[3]))


SHAPES: dict[str, Edits] = {
    "cell/bounded/flipped-plane": edits(tables=in_table("cells.planes", (UPPER, 1), (-1, 0, 0, 3))),
    "cell/bounded/two-equal-planes": edits(tables=in_table("cells.planes", (UPPER, 5), (0, 0, -1, 3))),
    "cell/non-empty/too-thin": edits(world=spare_box((-5 - STEP, -7, 0.5))),
    "cell/non-empty/nothing-inside": edits(tables=in_table("cells.planes", (UPPER, 5), (0, 0, 1, -2))),
    "cell/no-redundant-plane/touches-nothing": edits(world=with_spare(_flat_prism())),
    "cell/no-redundant-plane/same-plane-twice": edits(world=with_spare(_five_planes())),
    "cell/no-redundant-plane/facet-too-small": edits(world=with_spare(prism_with_tip(STEP * 0.55))),
}


def _tilted() -> World:
    # The east side of the east cell is tilted about its lower edge and runs into the building at x = 4.
    cell = RING.cells[EAST]
    plane = (0.8, 0.0, -0.6, -0.8 * 3 + 0.6 * 0.5)
    tilted = Cell((cell.planes[0], plane, *cell.planes[2:]), cell.kind)
    return replace(RING, cells=(*RING.cells[:EAST], tilted, *RING.cells[UPPER:]), portals=RING_PORTALS[:4])


AROUND_POSTER = replace(RING, clearance=0.0, portals=(), cells=(box_cell((0.0625, -4, 0.25), (3, 4, 3)),))
VOLUME = ("sectors", 0, "boundingVolume", "box")


def _world_frame(entry: Json) -> None:
    box = entry["sectors"][0]["boundingVolume"]["box"]
    box[:3] = [100 - box[1], 200 + box[0], 10 + box[2]]
    box[3], box[7] = box[7], box[3]


PLACES: dict[str, Edits] = {
    "cell/clear-of-geometry/tilted-plane": edits(world=_tilted()),
    "cell/clear-of-geometry/clearance-too-large": edits(world=replace(RING, clearance=0.375 + STEP / 2)),
    "cell/clear-of-geometry/poster-inside": edits(world=AROUND_POSTER),
    "cell/clear-of-geometry/face-without-area": edits(world=with_segment(-2, (-1, 1), (1, 2))),
    "cell/disjoint-interiors/half-way-in": edits(world=spare_box((-7, -7, 0.5), (-3, 7, 3))),
    "cell/disjoint-interiors/same-cell": edits(world=with_spare(RING.cells[0])),
    "cell/disjoint-interiors/two-steps": edits(world=spare_box((-7, -7, 0.5), (-4 + 2 * STEP, 7, 3))),
    "cell/sector-volume-bounds/too-small": edits(entry=adding(*VOLUME, 3, amount=-1.0)),
    "cell/sector-volume-bounds/world-frame": edits(entry=_world_frame),
}

CASES = PLANES | SHAPES | PLACES
