"""Small changes of scenes, each of which one condition on taking sets over decides; prints JSON.

Run as a program so that a changed copy of the package can be asked.
"""

from __future__ import annotations

import json

import numpy as np

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.cells.planes import planes
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.update import Previous, find_changes
from tilesnav_ref.update.matching import match_rows
from tilesnav_ref.visibility import VisibilitySettings, compute_pvs

WORK = VisibilitySettings(rays=1, aimed_rounds=1, attempts=8, depth=4, leaf_segments=0, threads=1)
IDLE = VisibilitySettings(rays=0, aimed_rounds=0, attempts=0, depth=0, leaf_segments=0, threads=1)
CELL = [[-4, -4, -4], [4, 4, 4]]
Faces = list[list[tuple[int, int, int]]]


def scene_of(faces: Faces, porous: tuple[int, ...] = (), one_sided: tuple[int, ...] = ()) -> Scene:
    vertices, inverse = np.unique(np.asarray(faces, np.int64).reshape(-1, 3), axis=0, return_inverse=True)
    numbers = np.arange(len(faces), dtype=np.int32)
    return Scene(
        vertices, inverse.reshape(-1, 3).astype(np.int32), numbers, np.zeros(len(faces), np.int32),
        tuple(str(i) for i in numbers),
        object_porous=np.isin(numbers, porous), object_one_sided=np.isin(numbers, one_sided),
    )  # fmt: skip


def cells_of(box: list[list[int]]) -> CellComplex:
    corners = np.asarray([box], np.int64)
    none = np.zeros(0, np.int64)
    return CellComplex(
        corners[:, 0], corners[:, 1], np.zeros(1, np.uint8), np.zeros(2, np.int64),
        none, none, 0, 1.0,
    )  # fmt: skip


def updated(
    old: Scene, new: Scene, work: VisibilitySettings = WORK, boxes: tuple[list[list[int]], ...] = (CELL, CELL)
) -> set[int]:
    """The set of a cell after an update."""
    before, now = cells_of(boxes[0]), cells_of(boxes[1])
    table = compute_pvs(old, before, work)
    counts = table.proven_counts
    previous = Previous("probe", old, planes(before, old.step), counts, table.faces_of, "")
    found = find_changes(previous, new, now, work)
    return set(found.merge(compute_pvs(new, found.todo, work)).faces_of(0).tolist())


def across(x: int, y: tuple[int, int], z: tuple[int, int]) -> Faces:
    """A rectangle across the view along x, front towards -x."""
    a, b, c, d = (x, y[0], z[0]), (x, y[1], z[0]), (x, y[1], z[1]), (x, y[0], z[1])
    return [[a, c, b], [a, d, c]]


WALL = across(20, (-95, 95), (-95, 95))
TARGET = across(36, (-4, 4), (-4, 4))
BACK: Faces = [[(-20, -9, -9), (-20, 9, -9), (-20, 0, 9)]]


def wall_is_removed() -> bool:
    """What it hid is seen."""
    return {1, 2} <= updated(scene_of(BACK + TARGET + WALL), scene_of(BACK + TARGET))


def box_is_added() -> bool:
    """What is new in front of a wall is seen."""
    return {3, 4} <= updated(scene_of(BACK + WALL), scene_of(BACK + WALL + across(12, (-4, 4), (-4, 4))))


def face_is_added_behind_a_hole() -> bool:
    """Neither proven visible nor proven hidden: no segment from corner to corner passes the hole."""
    frame = [
        *across(20, (-95, 95), (-95, 1)),
        *across(20, (-95, 95), (3, 95)),
        *across(20, (-95, 1), (1, 3)),
        *across(20, (3, 95), (1, 3)),
    ]
    target = across(36, (-4, 4), (-4, 4))
    return {9, 10} <= updated(scene_of(BACK + frame), scene_of(BACK + frame + target), IDLE)


def one_sided_wall_is_removed() -> bool:
    """From behind it was not listed, and it hid."""
    turned = [[a, c, b] for a, b, c in WALL]
    return {1, 2} <= updated(scene_of(BACK + TARGET + turned, one_sided=(3, 4)), scene_of(BACK + TARGET))


def wall_turns_porous() -> bool:
    """What is behind it is seen through it."""
    faces = BACK + TARGET + WALL
    return {1, 2} <= updated(scene_of(faces), scene_of(faces, porous=(3, 4)))


def wall_becomes_two_sided() -> bool:
    """A face that was seen from its front only is seen from behind; its corners ascend in both senses."""
    faces = [*BACK, [(20, -95, 95), (20, 0, -95), (20, 95, 95)]]
    return 1 in updated(scene_of(faces, one_sided=(1,)), scene_of(faces))


def one_sided_wall_is_turned() -> bool:
    """Its front comes into view."""
    turned = [[a, c, b] for a, b, c in WALL]
    return {1, 2} <= updated(
        scene_of(BACK + turned, one_sided=(1, 2)), scene_of(BACK + WALL, one_sided=(1, 2))
    )


def number_of_copies() -> bool:
    """Of two copies one is left over."""
    row = np.array([[1, 2, 3]])
    try:
        return match_rows(np.repeat(row, 2, axis=0), row).tolist() == [0, -1]
    except ValueError:
        return False


def cell_grows() -> bool:
    """From the larger cell, a face behind the edge of a wall is seen."""
    faces = BACK + across(20, (-95, 12), (-95, 95)) + across(36, (-4, 4), (-4, 4))
    larger = [CELL[0], [4, 90, 4]]
    return {3, 4} <= updated(scene_of(faces), scene_of(faces), boxes=(CELL, larger))


def faces_are_renumbered() -> bool:
    """The same faces in another order."""
    old, new = scene_of(BACK + TARGET + WALL), scene_of(TARGET + WALL + BACK)
    return updated(old, new) == {2, 3, 4}


PROBES = (
    wall_is_removed,
    box_is_added,
    face_is_added_behind_a_hole,
    one_sided_wall_is_removed,
    wall_turns_porous,
    wall_becomes_two_sided,
    one_sided_wall_is_turned,
    number_of_copies,
    cell_grows,
    faces_are_renumbered,
)


def main() -> dict[str, bool]:
    """Name of each probe and whether its answer is right."""
    return {probe.__name__: bool(probe()) for probe in PROBES}


if __name__ == "__main__":
    print(json.dumps(main()))  # noqa: T201
