"""The search for missing faces: spreading of rays, uniformity, independence of threads, what it finds and
claims."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from validator_fixture import FLAT, FLOOR, WALL, Small, box_planes

from tilesnav_validator import polyhedra, rays
from tilesnav_validator.findings import Settings
from tilesnav_validator.runner import Judgement, Result, judge
from tilesnav_validator.subject import Faces
from tilesnav_validator.tables import Ragged


@pytest.mark.parametrize(("cells", "count"), [(3, 10), (7, 200_000), (1, 150_001), (5, 1), (40, 39)])
def test_rays_are_spread_evenly(cells: int, count: int) -> None:
    numbers = np.arange(cells, dtype=np.int64) * 2
    chunks = list(rays.plan(numbers, count, 100, 1))
    assert [chunk.number for chunk in chunks] == list(range(len(chunks)))
    for aimed, total in ((False, count - count // 2), (True, count // 2)):
        sums = dict.fromkeys(numbers.tolist(), 0)
        for chunk in chunks:
            assert chunk.counts.sum() <= rays.CHUNK
            assert (chunk.counts > 0).all()
            for cell, part in zip(chunk.cells.tolist(), chunk.counts.tolist(), strict=True):
                sums[cell] += part if chunk.aimed == aimed else 0
        assert sum(sums.values()) == total
        assert max(sums.values()) - min(sums.values()) <= 1


def test_marks_bound_the_cells_of_a_chunk() -> None:
    chunks = list(rays.plan(np.arange(100, dtype=np.int64), 1000, rays._MARKS // 3, 0))
    assert max(len(chunk.cells) for chunk in chunks) <= 3
    assert sum(int(chunk.counts.sum()) for chunk in chunks) == 1000


def caster(planes: list[list[list[float]]], triangles: list[list[tuple[float, ...]]]) -> rays.Caster:
    points = np.array(triangles, dtype=float).reshape(-1, 3, 3)
    faces = Faces(np.rint(points * 1024).astype(np.int64), points, np.zeros(len(points), np.int64))
    listed = Ragged(np.zeros(len(planes) + 1, np.int64), np.zeros(0, np.uint32))
    shapes = polyhedra.build(np.array(planes), 2.0**-16)
    return rays.Caster(faces, shapes, listed, 2.0**-10, 5)


def test_directions_are_uniform_on_the_sphere() -> None:
    directions = rays._directions(np.random.Generator(np.random.SFC64(1)), 200_000).astype(float)
    assert np.abs(np.linalg.norm(directions, axis=1) - 1).max() < 1e-6
    assert np.abs(directions.mean(axis=0)).max() < 5 / math.sqrt(3 * 200_000)
    assert np.abs((directions.T @ directions) / 200_000 - np.eye(3) / 3).max() < 0.003


def test_positions_are_uniform_in_slanted_cells() -> None:
    root = math.sqrt(0.5)
    wedge = box_planes((0, 0, 0), (2, 1, 2))
    wedge[1] = [
        root,
        0.0,
        root,
        -2 * root,
    ]  # x + z <= 2, below z = 2: a prism over a triangle, its top an edge
    wedge[5] = [0.0, 0.0, 1.0, -1.0]  # cut at z = 1: a trapezoid of area 1.5
    shooter = caster([wedge], WALL)
    assert shooter.is_box.tolist() == [False]
    found = shooter._in_polyhedron(np.random.Generator(np.random.SFC64(2)), 0, 100_000) + shooter.centre
    assert (np.array(wedge)[:, :3] @ found.T).T.max() <= 2
    assert np.mean(found[:, 0] + found[:, 2] <= 1) == pytest.approx(0.5 / 1.5, abs=0.01)
    assert np.mean(found[:, 2] <= 0.5) == pytest.approx(0.875 / 1.5, abs=0.01)
    assert np.mean(found[:, 1]) == pytest.approx(0.5, abs=0.01)


def test_positions_in_boxes() -> None:
    shooter = caster([box_planes((0, 0, 0), (1, 2, 3)), box_planes((5, 5, 5), (6, 6, 6))], WALL)
    assert shooter.is_box.all()
    chunk = rays.Chunk(0, False, np.array([1, 0]), np.array([1000, 5000]))
    rows = np.repeat([0, 1], [1000, 5000])
    found = shooter._origins(np.random.Generator(np.random.SFC64(3)), chunk, rows) + shooter.centre
    assert found[:1000].min() >= 5
    assert found[:1000].max() <= 6
    assert found[1000:].mean(axis=0) == pytest.approx([0.5, 1, 1.5], abs=0.05)


def test_a_map_without_faces_has_nothing_to_miss() -> None:
    shooter = caster([box_planes((0, 0, 0), (1, 2, 3))], [])
    assert shooter.cast(rays.Chunk(0, False, np.array([0]), np.array([10]))).candidates == []


def test_neighbours_share_a_corner() -> None:
    far = [(50.0, 0.0, 0.0), (51.0, 0.0, 0.0), (50.0, 1.0, 0.0)]
    shooter = caster([box_planes((0, 0, 0), (1, 2, 3))], [*FLOOR, far, *WALL])
    assert shooter.corner_of.shape == (5, 3)
    assert len(shooter.around.offsets) == 1 + 4 + 3 + 4
    shooter.listed = Ragged(np.array([0, 1]), np.array([0], dtype=np.uint32))
    found = shooter._neighbours(np.random.Generator(np.random.SFC64(4)), np.zeros(500, np.int64))
    assert set(found.tolist()) == {0, 1}


def verdict(result: Result) -> Judgement:
    return next(j for j in result.judgements if j.requirement.id == "pvs/conservative")


def without(
    face: int, seed: int = 0, count: int = 20_000, threads: int = 2, folder: Path | None = None
) -> Result:
    """Judge the small tileset after a face has been taken from the PVS of cell 1."""
    assert folder is not None
    small = Small()
    small.groups["pvs"]["faces"].remove(face)
    small.groups["pvs"]["faces"] = [0, 1, 2, 3, 4, *(f for f in (0, 1, 2, 3) if f != face)]
    small.groups["pvs"]["offsets"] = [0, 5, 8]
    return judge(small.write(folder), Settings(rays=count, seed=seed, threads=threads))


@pytest.mark.parametrize("face", range(4))
def test_a_missing_face_is_found_and_its_witness_holds(tmp_path: Path, face: int) -> None:
    found = verdict(without(face, folder=tmp_path))
    assert found.verdict == "fail"
    assert [finding.witness["face"] for finding in found.findings if finding.witness] == [face]
    assert found.findings[0].where == f"cell 1 face {face}"


def test_a_candidate_that_exact_arithmetic_refutes_is_no_finding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tilesnav_validator.exact.decide", lambda *_: None)
    result = without(2, folder=tmp_path)
    assert verdict(result).verdict == "not refuted"
    assert result.subject.search["candidates"] > 0
    assert result.subject.search["confirmed"] == 0


def test_rays_see_every_face_of_a_map_without_degenerate_ones() -> None:
    shooter = caster([box_planes((0, -2, 1), (3, 2, 3))], [*FLOOR, *WALL])
    shooter.listed = Ragged(np.array([0, 2]), np.array([0, 3], dtype=np.uint32))
    for aimed in (False, True):
        chunk = rays.Chunk(0, aimed, np.array([0]), np.array([5000]))
        assert {found.face for found in shooter.cast(chunk).candidates} == {1, 2}


def test_results_depend_on_the_seed_and_not_on_threads(tmp_path: Path) -> None:
    one, two = (verdict(without(2, threads=threads, folder=tmp_path)) for threads in (1, 3))
    assert one.findings == two.findings
    other = verdict(without(2, seed=1, folder=tmp_path))
    assert other.findings != one.findings


def test_a_missing_degenerate_face_is_no_fault(tmp_path: Path) -> None:
    small = Small(objects=[FLOOR, FLAT, WALL])
    assert verdict(judge(small.write(tmp_path), Settings(rays=0))).verdict == "not run"
    result = judge(
        Small().write(tmp_path), Settings(rays=20_000)
    )  # cell 1 does not list the degenerate face 4
    assert verdict(result).verdict == "not refuted"


def test_statements(tmp_path: Path) -> None:
    search = judge(Small().write(tmp_path), Settings(rays=9001, seed=3)).subject.search
    assert (search["uniformRays"], search["aimedRays"], search["cells"], search["confirmed"]) == (
        4501,
        4500,
        2,
        0,
    )
    assert search["missedShareAtMost"] == 3 / 4501
    assert "95 %" in search["statement"]
    refuted = without(2, folder=tmp_path).subject.search
    assert "missedShareAtMost" not in refuted
    assert refuted["confirmed"] == 1


def test_without_rays_the_search_is_not_run(tmp_path: Path) -> None:
    result = judge(Small().write(tmp_path), Settings(rays=0))
    assert (verdict(result).verdict, verdict(result).note) == ("not run", "no rays asked for")
    assert result.valid
    assert result.subject.search == {}


def test_the_search_ends_after_enough_witnesses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tilesnav_validator.checks.conservative.ENOUGH", 1)
    search = without(2, count=2_000_000, folder=tmp_path).subject.search
    assert search["uniformRays"] == 8 * rays.CHUNK  # the chunk in which the rays of cell 1 begin
    assert search["aimedRays"] == 0


def test_cells_with_findings_are_left_out(tmp_path: Path) -> None:
    small = Small()
    small.groups["cells"]["planes"] = [
        [[-x for x in p] for p in box] for box in small.groups["cells"]["planes"]
    ]
    result = judge(small.write(tmp_path), Settings(rays=100))
    verdicts = {j.requirement.id: j.verdict for j in result.judgements}
    assert verdicts["cell/non-empty"] == "fail" or verdicts["cell/bounded"] == "fail"
    assert verdicts["pvs/conservative"] == "not run"
    assert verdicts["lod/fine-enough"] == "not run"
    assert verdicts["cell/clear-of-geometry"] == "not run"
