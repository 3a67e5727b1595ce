"""Maps in memory that are brought up to date, and what must hold of the result."""

from __future__ import annotations

import random
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray
from visibility_reference import point, visible_by

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.cells.planes import planes
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.update import Previous, find_changes
from tilesnav_ref.visibility import PvsTable, VisibilitySettings, compute_pvs

WORK = VisibilitySettings(rays=300, attempts=64, depth=10, leaf_segments=4, threads=1)


def cells_of(boxes: Any) -> CellComplex:
    """Cells from (N, 2, 3) corners, without portals."""
    boxes = np.asarray(boxes, np.int64).reshape(-1, 2, 3)
    none = np.zeros(0, np.int64)
    return CellComplex(
        boxes[:, 0], boxes[:, 1], np.zeros(len(boxes), np.uint8), np.zeros(len(boxes) + 1, np.int64),
        none, none, 0, 1.0,
    )  # fmt: skip


def previous_of(scene: Scene, cells: CellComplex, table: PvsTable) -> Previous:
    """A map as `open_previous` gives it."""
    return Previous("memory", scene, planes(cells, scene.step), table.proven_counts, table.faces_of, "0")


def sets_of(table: PvsTable) -> list[set[int]]:
    return [set(table.faces_of(i).tolist()) for i in range(len(table.pvs_offsets) - 1)]


def proven_of(table: PvsTable) -> list[set[int]]:
    """Flagged faces of each cell."""
    bounds = zip(table.pvs_offsets[:-1], table.pvs_offsets[1:], strict=True)
    return [set(table.pvs_faces[a:b][table.pvs_proven[a:b]].tolist()) for a, b in bounds]


@dataclass(frozen=True)
class Updated:
    """Result of an update beside that of a run from the start."""

    kept: set[int]
    sets: list[set[int]]
    table: PvsTable
    full: list[set[int]]
    earlier: PvsTable


def seen_by_definition(scene: Scene, box: NDArray[Any], reach: Fraction | None, tries: int) -> set[int]:
    """Faces that some of a number of random rational segments from a box sees."""
    rng = random.Random(3)
    found = set()
    for target, own in enumerate(scene.corners()):
        for _ in range(tries):
            share = [Fraction(rng.randint(1, 31), 32) for _ in range(3)]
            c = point(int(lo) + s * int(up - lo) for (lo, up), s in zip(box.T, share, strict=True))
            w = np.array([rng.randint(1, 20) for _ in range(3)])
            t = point(Fraction(int(x), int(w.sum())) for x in w @ own)
            if visible_by(scene, c, t, target, reach):
                found.add(target)
                break
    return found


def update(
    old: Scene, new: Scene, boxes: Any, work: VisibilitySettings = WORK, old_boxes: Any = None
) -> Updated:
    """Bring the map of a scene up to date, and hold it against the definition and a run from the start."""
    cells = cells_of(boxes)
    old_cells = cells if old_boxes is None else cells_of(old_boxes)
    earlier = compute_pvs(old, old_cells, work)
    found = find_changes(previous_of(old, old_cells, earlier), new, cells, work)
    table = found.merge(compute_pvs(new, found.todo, work))
    full = compute_pvs(new, cells, work)
    reach = None if work.max_range is None else Fraction(work.max_range) / Fraction(new.step)
    sets, proven = sets_of(table), proven_of(full)
    for cell in range(cells.count):
        box = np.stack([cells.lower[cell], cells.upper[cell]])
        assert proven[cell] <= sets[cell], (cell, set(found.kept))
        assert seen_by_definition(new, box, reach, 12) <= sets[cell], (cell, set(found.kept))
        assert proven_of(table)[cell] <= sets_of(full)[cell]
        assert table.proven_counts[cell] <= len(sets_of(full)[cell])
    return Updated(set(found.kept), sets, table, sets_of(full), earlier)
