"""Changes whose effect is known by reasoning: what is taken over, and what must not be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from update_reference import WORK, cells_of, previous_of, sets_of, update
from visibility_reference import make_flagged, make_scene

from tilesnav_ref.scene.model import Scene
from tilesnav_ref.update import UpdateError, find_changes
from tilesnav_ref.visibility import compute_pvs

CELL = [[-4, -4, -4], [4, 4, 4]]
FAR = 95
Faces = list[list[tuple[int, int, int]]]


def wall(x: int, half: int = FAR) -> Faces:
    """A square across the view along x; its corners run so that its front is towards -x."""
    a, b, c, d = (x, -half, -half), (x, half, -half), (x, half, half), (x, -half, half)
    return [[a, c, b], [a, d, c]]


def box(x: int, half: int = 5) -> Faces:
    """Six sides about (x, 0, 0)."""
    corners = [(x + i, j, k) for i in (-half, half) for j in (-half, half) for k in (-half, half)]
    quads = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
    return [[corners[q[0]], corners[q[i]], corners[q[i + 1]]] for q in quads for i in (1, 2)]


GROUND = [[(-50, -50, -90), (50, -50, -90), (0, 60, -90)]]
TARGET = wall(40, 6)


def test_a_wall_that_hid_a_face_is_removed() -> None:
    old, new = make_scene(GROUND + TARGET + wall(20)), make_scene(GROUND + TARGET)
    found = update(old, new, [CELL])
    assert sets_of(found.earlier) == [{0, 3, 4}]
    assert found.kept == set()
    assert found.sets == found.full == [{0, 1, 2}]


def test_a_box_behind_a_wall_is_not_seen() -> None:
    old, new = make_scene(GROUND + wall(20)), make_scene(box(40) + GROUND + wall(20))
    found = update(old, new, [CELL])
    assert found.kept == {0}
    assert found.sets == found.full == [{12, 13, 14}]
    assert found.table.proven_counts.tolist() == found.earlier.proven_counts.tolist() == [3]


def test_a_box_in_view_is_seen() -> None:
    old, new = make_scene(GROUND + wall(20)), make_scene(box(12) + GROUND + wall(20))
    found = update(old, new, [CELL])
    assert found.kept == set()
    assert found.sets == found.full
    assert {12, 13, 14} < found.sets[0]


def test_a_wall_that_hides_is_added() -> None:
    old, new = make_scene(GROUND + TARGET), make_scene(GROUND + TARGET + wall(20))
    found = update(old, new, [CELL])
    assert found.kept == set()
    assert found.sets == found.full == [{0, 3, 4}]


@pytest.mark.parametrize("side", [CELL, [[24, -4, -4], [28, 4, 4]]])
def test_a_wall_turns_porous_and_back(side: list[list[int]]) -> None:
    faces = GROUND + TARGET + wall(20) + wall(8, 1)
    opaque, porous = make_flagged(faces), make_flagged(faces, porous=[3, 4])
    thinner = update(opaque, porous, [side])
    thicker = update(porous, opaque, [side])
    assert thinner.kept == thicker.kept == set()
    assert thinner.sets == thinner.full
    assert thicker.sets == thicker.full
    assert thicker.sets[0] < thinner.sets[0]


def test_a_porous_face_that_is_hidden_is_removed() -> None:
    faces = GROUND + wall(20)
    old, new = make_flagged(faces + TARGET, porous=[3, 4]), make_flagged(faces)
    assert update(old, new, [CELL]).kept == {0}
    assert update(new, old, [CELL]).kept == {0}


def test_a_hidden_wall_that_hides_is_removed() -> None:
    """Nothing of it was seen, though a proof may have rested on it."""
    old = make_scene(GROUND + TARGET + wall(30) + wall(20))
    found = update(old, make_scene(GROUND + TARGET + wall(20)), [CELL])
    assert found.kept == {0}
    assert found.sets == found.full == [{0, 3, 4}]


def test_of_two_cells_only_the_one_that_sees_the_change_is_recomputed() -> None:
    behind = [[60, -4, -4], [68, 4, 4]]
    faces = GROUND + wall(30)
    old, new = make_scene(box(14) + faces), make_scene(faces)
    for boxes in ([CELL, behind], [behind, CELL]):
        found = update(old, new, boxes)
        assert found.kept == {boxes.index(behind)}
        assert found.sets == found.full


def test_a_one_sided_wall_hides_from_behind_though_it_is_not_listed() -> None:
    behind = [[24, -4, -4], [28, 4, 4]]
    faces = GROUND + wall(20) + wall(10, 6)
    old = make_flagged(faces, one_sided=[1, 2])
    new = make_flagged(faces[:1] + faces[3:])
    found = update(old, new, [behind])
    assert not sets_of(found.earlier)[0] & {1, 2, 3, 4}
    assert found.kept == set()
    assert found.sets == found.full
    assert {1, 2} <= found.sets[0]
    reverse = update(new, old, [behind])
    assert reverse.kept == set()
    assert reverse.sets == reverse.full


def test_a_one_sided_wall_behind_another_is_no_reason() -> None:
    faces = GROUND + wall(20) + wall(30)
    old, new = make_flagged(faces, one_sided=[3, 4]), make_flagged(faces[:3])
    assert update(old, new, [CELL]).kept == {0}
    assert update(new, old, [CELL]).kept == {0}


def test_what_is_out_of_range_is_no_reason() -> None:
    old, new = make_scene(GROUND + TARGET), make_scene(GROUND + box(14))
    near = replace(WORK, max_range=30 * old.step)
    gone = update(make_scene(GROUND + box(14) + TARGET), new, [CELL], near)
    assert gone.kept == {0}
    come = update(new, make_scene(TARGET + box(14) + GROUND), [CELL], near)
    assert come.kept == {0}
    assert come.sets == come.full
    assert update(old, new, [CELL], near).kept == set()


def test_one_copy_of_a_doubled_wall_is_removed() -> None:
    once, twice = make_scene(GROUND + TARGET + wall(20)), make_scene(GROUND + TARGET + wall(20) + wall(20))
    for old, new in ((twice, once), (once, twice)):
        found = update(old, new, [CELL])
        assert found.kept == set()
        assert found.sets == found.full


def test_new_numbers_are_no_change() -> None:
    faces = GROUND + TARGET + wall(20) + box(12)
    order = np.random.default_rng(4).permutation(len(faces))
    found = update(make_scene(faces), make_scene([faces[i] for i in order]), [CELL])
    assert found.kept == {0}
    assert [{int(order[f]) for f in found.sets[0]}] == sets_of(found.earlier)
    assert found.table.faces_of(0).tolist() == sorted(found.sets[0])


def test_a_cell_of_another_box_is_recomputed() -> None:
    scene = make_scene(GROUND + wall(20))
    larger = [[-4, -4, -4], [4, 4, 5]]
    found = update(scene, scene, [CELL, larger], old_boxes=[[[-9, -9, -9], [9, 9, 9]], CELL])
    assert found.kept == {0}
    assert found.sets == found.full


def test_undecided_faces_are_counted_as_kept() -> None:
    # No effort: what no line sees stays undecided.
    lazy = replace(WORK, rays=0, aimed_rounds=0, attempts=0, leaf_segments=0)
    scene, cells = make_scene(GROUND + wall(20) + wall(30)), cells_of([CELL])
    table = compute_pvs(scene, cells, lazy)
    open_faces = len(table.pvs_faces) - int(table.proven_counts.sum())
    assert open_faces > 0
    merged = find_changes(previous_of(scene, cells, table), scene, cells, lazy).merge(
        compute_pvs(scene, cells_of([]), lazy)
    )
    assert merged.undecided == {"kept": open_faces}
    assert merged.proven_counts.tolist() == table.proven_counts.tolist()


def test_findings_count_what_was_found() -> None:
    old, new = make_scene(GROUND + wall(20) + TARGET), make_scene(GROUND + wall(20) + box(40))
    cells = cells_of([CELL, [[-4, 4, -4], [4, 8, 4]]])
    earlier = previous_of(old, cells_of([CELL]), compute_pvs(old, cells_of([CELL]), WORK))
    found = find_changes(earlier, new, cells, WORK)
    assert found.findings == {"facesRemoved": 2, "facesAdded": 12, "cellsMatched": 1, "cellsKept": 1}
    assert found.anew.tolist() == [1]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"grid_exponent": -9}, "grid.exponent: found -10; allowed: -9"),
        ({"tileset_from_nav": np.diag([-1.0, -1.0, 1.0, 1.0])}, "transform: found .*--origin"),
    ],
)
def test_coordinates_that_mean_something_else_are_refused(changed: dict[str, object], message: str) -> None:
    scene, cells = make_scene(GROUND + wall(20)), cells_of([CELL])
    earlier = previous_of(scene, cells, compute_pvs(scene, cells, WORK))
    moved: Scene = replace(scene, **changed)  # type: ignore[arg-type]
    with pytest.raises(UpdateError, match=message):
        find_changes(earlier, moved, cells, WORK)


def test_a_part_of_a_complex_keeps_the_portals_within_it() -> None:
    row = replace(
        cells_of([[[x, 0, 0], [x + 2, 2, 2]] for x in (0, 2, 4, 6)]),
        portal_offsets=np.array([0, 1, 3, 5, 6]),
        portal_targets=np.array([1, 0, 2, 1, 3, 2]),
        portal_polygons=np.array([0, 0, 1, 1, 2, 2]),
    )
    part = row.select(np.array([0, 2, 3]))
    assert part.lower[:, 0].tolist() == [0, 4, 6]
    assert part.portal_offsets.tolist() == [0, 0, 1, 2]
    assert part.portal_targets.tolist() == [2, 1]
    assert part.portal_polygons.tolist() == [2, 2]


def _street() -> tuple[Scene, Scene, list[list[list[int]]]]:
    """Cells in a row along a wall, which ends behind them; the change is beyond the wall."""
    boxes = [[[-4, 10 * i, -4], [4, 10 * i + 8, 4]] for i in range(-6, 6)]
    barrier: Faces = [
        [(20, -300, -90), (20, 20, -90), (20, 20, 90)],
        [(20, -300, -90), (20, 20, 90), (20, -300, 90)],
    ]
    return make_scene(GROUND + barrier), make_scene(GROUND + barrier + box(40)), boxes


def test_what_is_kept_does_not_depend_on_threads_and_blocks() -> None:
    old, new, boxes = _street()
    runs = [
        update(old, new, boxes, replace(WORK, threads=threads, block_cells=block))
        for threads, block in ((1, 4), (3, 4), (1, 1))
    ]
    assert runs[0].kept == runs[1].kept
    assert runs[0].sets == runs[1].sets
    # From the south end the wall hides the box, from the north end it does not.
    for run in runs:
        assert run.kept
        assert run.kept == set(range(len(run.kept))) != set(range(len(boxes)))


def test_progress_ends_with_all_steps_and_may_stop_the_work() -> None:
    old, new, boxes = _street()
    cells = cells_of(boxes)
    earlier = previous_of(old, cells, compute_pvs(old, cells, WORK))
    steps: list[tuple[int, int]] = []
    find_changes(earlier, new, cells, replace(WORK, block_cells=2), lambda *step: steps.append(step))
    shares = [done / total for done, total in steps]
    assert shares == sorted(shares)
    assert shares[-1] == 1

    def stop(*_: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        find_changes(earlier, new, cells, replace(WORK, block_cells=2), stop)
