"""Codes of objects in cells against the largest bound over all their faces."""

from __future__ import annotations

import dataclasses
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from tilesnav_ref.cells.model import CellComplex, box_corners
from tilesnav_ref.lod import LodSettings, LodTable, choose_levels, level_codes, levels, region_maximum
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.visibility.model import PvsTable
from tilesnav_validator import lodjudge
from tilesnav_validator.tables import Ragged, Tables

STEP = 2.0**-6


def slant(corners: np.ndarray, u: int, v: int, rng: np.random.Generator) -> None:
    """Turn the box (8, 3) into a prism whose sides across v slant along u; it keeps its bounds."""
    size = int(np.ptp(corners[:, v]))
    for side in range(2):
        cut, end = int(rng.integers(1, size // 2)), int(rng.integers(0, 2))
        for i in range(8):
            if (i >> v) & 1 == side and (i >> u) & 1 == end:
                corners[i, v] += -cut if side else cut


def make_case(seed: int, cell_count: int = 12, face_count: int = 60) -> tuple[Scene, CellComplex, PvsTable]:
    """Random triangles of seven objects and random cells, some of them in contact; random PVS.

    Every other cell is a box; of the rest, sides slant along each of the six pairs of axes."""
    rng = np.random.default_rng(seed)
    place = rng.integers(-2000, 2000, (face_count, 1, 3))
    vertices = (place + rng.integers(-300, 300, (face_count, 3, 3))).reshape(-1, 3)
    objects = np.sort(rng.integers(0, 7, face_count)).astype(np.int32)
    scene = Scene(
        vertices,
        np.arange(3 * face_count, dtype=np.int32).reshape(-1, 3),
        objects,
        np.zeros(7, np.int32),
        ("",) * 7,
        -6,
    )
    lower = rng.integers(-2000, 2000, (cell_count, 3))
    empty = np.zeros(0, np.int64)
    upper = lower + rng.integers(64, 600, (cell_count, 3))
    corners = box_corners(lower, upper)
    for cell in range(0, cell_count, 2):
        v, u = divmod(cell // 2 % 6, 2)
        slant(corners[cell], (v + 1 + u) % 3, v, rng)
    cells = CellComplex(
        lower=lower,
        upper=upper,
        corners=corners,
        kinds=np.zeros(cell_count, np.uint8),
        portal_offsets=np.zeros(cell_count + 1, np.int64),
        portal_targets=empty,
        portal_polygons=empty,
        clearance=0,
        coverage=1.0,
    )
    rows = [np.flatnonzero(rng.random(face_count) < share) for share in np.linspace(0.0, 1.0, cell_count)]
    offsets = np.concatenate(([0], np.cumsum([len(row) for row in rows]))).astype(np.int64)
    faces = np.concatenate(rows).astype(np.uint32)
    return scene, cells, PvsTable(offsets, faces, np.zeros(len(faces), np.bool_))


def expected_levels(scene: Scene, cells: CellComplex, pvs: PvsTable, cell: int) -> dict[int, float]:
    """Largest bound of every object in a cell, one face at a time."""
    levels: dict[int, float] = {}
    for face in pvs.faces_of(cell):
        value = region_maximum(cells.corners[cell] * scene.step, scene.corners()[face] * scene.step)
        member = int(scene.face_object[face])
        levels[member] = max(levels.get(member, 0.0), value)
    return levels


@pytest.mark.parametrize("settings", [LodSettings(), LodSettings(reference=0.3, base=1.05, level_count=200)])
def test_codes_are_those_of_the_largest_bound(settings: LodSettings) -> None:
    for seed in range(4):
        scene, cells, pvs = make_case(seed)
        table = choose_levels(scene, cells, pvs, settings)
        for cell in range(cells.count):
            span = slice(table.lod_offsets[cell], table.lod_offsets[cell + 1])
            levels = expected_levels(scene, cells, pvs, cell)
            assert table.lod_objects[span].tolist() == sorted(levels)
            codes = level_codes(np.array([levels[member] for member in sorted(levels)]), settings)
            assert table.lod_codes[span].tolist() == codes.tolist()
        assert len(set(table.lod_codes.tolist())) > 3


def judged(
    case: tuple[Scene, CellComplex, PvsTable], table: LodTable, codes: np.ndarray
) -> tuple[list[lodjudge.Fault], list[lodjudge.Fault], int, int]:
    """What the validator says of codes: faults too coarse and too fine, and how many it leaves open."""
    scene, cells, pvs = case
    nothing, none = np.zeros(0, np.int64), Ragged(np.zeros(1, np.int64), np.zeros(0))
    tables = Tables(
        planes=np.zeros((cells.count, 6, 4)),
        kinds=cells.kinds,
        targets=none,
        polygons=nothing,
        polygon_range=nothing,
        vertices=none,
        faces=Ragged(pvs.pvs_offsets, pvs.pvs_faces),
        proven=nothing,
        digests=np.zeros((0, 32), np.uint8),
        objects=Ragged(table.lod_offsets, table.lod_objects),
        codes=Ragged(table.lod_offsets, codes),
        entered=none,
        left=none,
        switch_objects=none,
        switch_codes=none,
    )
    triangles = scene.corners() * scene.step
    sound = np.ones(scene.face_count, np.bool_)
    subject = lodjudge.Scene(cells.corners * scene.step, triangles, scene.face_object.astype(np.int64), sound)
    scale = lodjudge.Scale(table.settings.reference, table.settings.base, table.settings.level_count)
    return lodjudge.judge(tables, subject, scale, np.arange(cells.count))


def test_the_judge_of_levels_agrees_on_boxes_and_slanted_cells() -> None:
    fine = LodSettings(reference=0.3, base=1.05, level_count=200)
    for seed in range(3):
        case = make_case(seed)
        table = choose_levels(*case, fine)
        coarse, wasteful, *left_open = judged(case, table, table.lod_codes)
        assert coarse == wasteful == []
        assert sum(left_open) <= 0.05 * len(table.lod_codes)
        between = (table.lod_codes > 2) & (table.lod_codes < 197)
        for change, which in ((1, 0), (-2, 1)):
            codes = np.where(between, table.lod_codes.astype(np.int64) + change, table.lod_codes)
            faults = judged(case, table, codes.astype(np.uint8))[which]
            assert len(faults) > 0.9 * between.sum()
            assert any(fault.cell % 2 == 0 for fault in faults)  # the slanted ones


def test_contact_gives_the_finest_code() -> None:
    scene, cells, pvs = make_case(0)
    corner = scene.corners()[5, 0]
    lower, upper = np.tile(corner, (12, 1)), np.tile(corner + 100, (12, 1))
    cells = dataclasses.replace(cells, lower=lower, upper=upper, corners=box_corners(lower, upper))
    table = choose_levels(scene, cells, pvs)
    last = slice(table.lod_offsets[11], table.lod_offsets[12])
    owner = table.lod_objects[last].tolist().index(int(scene.face_object[5]))
    assert table.lod_codes[last][owner] == 0


def test_nothing_visible_gives_empty_rows() -> None:
    scene, cells, _ = make_case(0)
    nothing = PvsTable(np.zeros(13, np.int64), np.zeros(0, np.uint32), np.zeros(0, np.bool_))
    table = choose_levels(scene, cells, nothing)
    assert table.lod_offsets.tolist() == [0] * 13
    assert len(table.lod_objects) == len(table.lod_codes) == 0


def test_types_are_those_of_the_file() -> None:
    table = choose_levels(*make_case(1))
    kinds = (table.lod_offsets.dtype, table.lod_objects.dtype, table.lod_codes.dtype)
    assert kinds == (np.int64, np.uint32, np.uint8)


def test_tables_that_do_not_belong_together_are_refused() -> None:
    scene, cells, pvs = make_case(0)
    with pytest.raises(ValueError, match="allowed: as many as there are"):
        choose_levels(scene, cells, dataclasses.replace(pvs, pvs_offsets=pvs.pvs_offsets[:-1]))
    far = pvs.pvs_faces.copy()
    far[3] = scene.face_count
    with pytest.raises(ValueError, match="lists face 60"):
        choose_levels(scene, cells, dataclasses.replace(pvs, pvs_faces=far))
    with pytest.raises(ValueError, match="base"):
        choose_levels(scene, cells, pvs, LodSettings(base=0.5))


def test_progress_ends_at_the_number_of_tasks() -> None:
    seen: list[tuple[int, int]] = []
    choose_levels(*make_case(0), progress=lambda done, tasks: seen.append((done, tasks)))
    assert seen == [(1, 1)]


def test_threads_are_as_many_as_asked_for_and_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    def pool(count: int) -> ThreadPoolExecutor:
        asked.append(count)
        return ThreadPoolExecutor(count)

    monkeypatch.setattr(levels, "ThreadPoolExecutor", pool)
    monkeypatch.setattr(levels, "_GROUPS_A_TASK", 5)
    one, three = (choose_levels(*make_case(0), threads=threads) for threads in (1, 3))
    assert asked == [1, 3]
    assert np.array_equal(one.lod_codes, three.lod_codes)
    with pytest.raises(ValueError, match="threads is -1"):
        choose_levels(*make_case(0), threads=-1)
