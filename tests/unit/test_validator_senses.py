"""What is porous, one-sided or out of range: exact decisions, rays, and a tileset that says so."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from validator_fixture import FLOOR, WALL, Small, box_planes, failures

from tilesnav_validator import polyhedra, rays
from tilesnav_validator.exact import Candidate, Witness, decide
from tilesnav_validator.findings import Settings
from tilesnav_validator.runner import judge
from tilesnav_validator.subject import Faces
from tilesnav_validator.tables import Ragged

STEP = 2.0**-10
CELL = box_planes((-1, -1, -1), (1, 1, 1))
Triangle = list[tuple[float, float, float]]


def sheet(x: float) -> Triangle:
    """Triangle across the x axis, its front towards +x."""
    return [(x, -4, -4), (x, 4, -4), (x, 0, 4)]


def scene(triangles: list[Triangle], porous: tuple[int, ...] = (), sided: tuple[int, ...] = ()) -> Faces:
    """Faces that are an object each."""
    points = np.array(triangles, dtype=np.float64)
    grid = np.rint(points / STEP).astype(np.int64)
    flags = (np.array(numbers, dtype=np.int64) for numbers in (porous, sided))
    return Faces(grid, points, np.arange(len(points)), *flags)


def see(faces: Faces, face: int, towards: float = 9.0, max_range: float | None = None) -> Witness | None:
    candidate = Candidate(0, face, np.zeros(3), np.array([towards, 0.0, 0.0]))
    return decide(candidate, np.array(CELL), faces, STEP, max_range)


def test_a_porous_face_blocks_nothing_and_is_seen() -> None:
    triangles = [sheet(4), sheet(2)]
    assert see(scene(triangles), 0) is None
    assert see(scene(triangles, porous=(1,)), 0) is not None
    assert see(scene(triangles, porous=(1,)), 1) is not None
    assert see(scene(triangles, porous=(0,)), 0) is None


def test_a_one_sided_face_is_seen_from_its_front_only_and_blocks_from_both_sides() -> None:
    assert see(scene([sheet(4)], sided=(0,)), 0) is None
    assert see(scene([sheet(4)[::-1]], sided=(0,)), 0) is not None
    assert see(scene([sheet(-4)], sided=(0,)), 0, -9.0) is not None
    for between in (sheet(2), sheet(2)[::-1]):
        assert see(scene([sheet(4), between], sided=(1,)), 0) is None


@pytest.mark.parametrize(("reach", "seen"), [(4.0, False), (np.nextafter(4.0, 5), True), (3.0, False)])
def test_a_segment_must_be_shorter_than_the_range(reach: float, seen: bool) -> None:
    assert (see(scene([sheet(4)]), 0, 9.0, reach) is not None) == seen
    assert (see(scene([sheet(4)]), 0, 2.0**-9, reach) is not None) == seen


def caught(faces: Faces, max_range: float | None = None, aimed: bool = False) -> set[int]:
    """Faces that rays from a cell suggest when nothing is listed."""
    shapes = polyhedra.build(np.array([CELL]), 2.0**-16)
    nothing = Ragged(np.zeros(2, np.int64), np.zeros(0, np.uint32))
    shooter = rays.Caster(faces, shapes, nothing, STEP, 1, max_range)
    chunk = rays.Chunk(0, aimed, np.array([0]), np.array([4000]))
    return {candidate.face for candidate in shooter.cast(chunk).candidates}


@pytest.mark.parametrize("aimed", [False, True])
def test_rays_go_on_behind_what_is_porous(aimed: bool) -> None:
    rows = [sheet(x) for x in (2, 3, 4, 5, 6, 7)]
    assert caught(scene(rows), aimed=aimed) == {0}
    assert caught(scene(rows, porous=(0, 1, 3)), aimed=aimed) == {0, 1, 2}
    assert caught(scene(rows, porous=(0, 1, 2, 3, 4, 5)), aimed=aimed) == set(range(6))


def test_rays_that_do_not_count_suggest_nothing() -> None:
    rows = [sheet(2), sheet(-2)]
    assert caught(scene(rows, sided=(0,))) == {1}
    assert caught(scene(rows, sided=(0, 1), porous=(0, 1))) == {1}
    assert caught(scene([sheet(3), sheet(-2)]), max_range=1.5) == {1}
    assert caught(scene([sheet(3), sheet(-2)], porous=(0, 1)), max_range=1.5) == {1}
    assert caught(scene(rows), max_range=0.5) == set()


def flagged(member: str, indices: list[object], **entry: object) -> Small:
    small = Small()
    small.root["content"]["extensions"]["3DTILES_nav"][member] = indices
    small.extension.update(entry)
    return small


def test_flags_of_a_tileset_reach_the_search(tmp_path: Path) -> None:
    for member, indices in (("porous", [0, 2.0]), ("oneSided", [1])):
        result = judge(flagged(member, indices).write(tmp_path), Settings(rays=2000))
        faces = result.subject.faces
        assert result.subject.max_range is None
        opaque = member != "porous"
        assert faces.blocking.tolist() == [opaque, opaque, True, True, False]
        assert faces.one_sided.tolist() == [False, False, member == "oneSided", member == "oneSided", False]
        assert result.valid


def test_a_range_reaches_the_search(tmp_path: Path) -> None:
    small = flagged("porous", [], visibility={"maxRange": 7})
    assert judge(small.write(tmp_path), Settings(rays=100)).subject.max_range == 7.0


def test_indices_ascend_and_stay_within_the_content(tmp_path: Path) -> None:
    for indices, place in (([3], 0), ([1, 0], 1), ([0, 0], 1), ([2, 1, 2], 1)):
        result = judge(flagged("oneSided", list(indices)).write(tmp_path), Settings(rays=100))
        verdicts = {j.requirement.id: j for j in result.judgements}
        assert verdicts["core/object-flags"].verdict == "fail", indices
        assert verdicts["core/object-flags"].findings[0].where.endswith(f"/oneSided/{place}")
        assert verdicts["pvs/conservative"].verdict == "not run"
    assert failures(flagged("porous", [0, 1, 2]).write(tmp_path)) == []


def test_the_fixture_has_a_floor_and_a_wall() -> None:
    assert caught(scene([*FLOOR, *WALL], porous=(0, 1))) >= {2, 3}
