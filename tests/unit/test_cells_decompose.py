"""Cells of small scenes whose free space is known."""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

from tilesnav_ref.cells import (
    KIND_AERIAL,
    KIND_GROUND,
    CellComplex,
    CellError,
    CellSettings,
    decompose,
    planes,
)
from tilesnav_ref.scene.model import Scene

STEP = 2.0**-4
QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def box_faces(low: tuple[float, float, float], high: tuple[float, float, float]) -> np.ndarray:
    """(12, 3, 3) triangles of a closed box, m."""
    corner = np.array([[(low, high)[(c >> k) & 1][k] for k in range(3)] for c in range(8)])
    return np.array([corner[list(t)] for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])


def ground(x0: float, y0: float, x1: float, y1: float, z: float = 0.0) -> np.ndarray:
    """(2, 3, 3) triangles of a horizontal rectangle, m."""
    a, b, c, d = (x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)
    return np.array([(a, b, c), (a, c, d)])


def make_scene(*parts: np.ndarray, exponent: int = -4) -> Scene:
    """A scene of one object from triangles in metres."""
    corners = np.round(np.concatenate(parts) / 2.0**exponent).astype(np.int64)
    faces = np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
    return Scene(
        corners.reshape(-1, 3),
        faces,
        np.zeros(len(faces), np.int32),
        np.zeros(1, np.int32),
        ("scene",),
        exponent,
    )


SMALL = CellSettings(min_size=1.0, max_size=8.0, clearance=0.25, coverage_points=4000)


def inside(cells: CellComplex, point: tuple[float, float, float], step: float = STEP) -> bool:
    """Whether a point (m) lies in the interior of a cell."""
    table = planes(cells, step)
    return bool(np.any(np.all(table[:, :, :3] @ np.array(point) + table[:, :, 3] < 0, axis=1)))


def polygon(cells: CellComplex, number: int) -> np.ndarray:
    """(K, 3) vertices of a portal's polygon, grid."""
    return cells.polygon_vertices[slice(*cells.polygon_offsets[number : number + 2])]


def test_flat_ground_leaves_everything_above_the_clearance() -> None:
    cells = decompose(make_scene(ground(0, 0, 20, 20)), SMALL)
    assert cells.lower[:, 2].min() == 4  # 0.25 m
    volume = np.prod(cells.upper - cells.lower, axis=1).sum()
    assert volume == 320 * 320 * (8 * 16 - 4)
    assert cells.coverage == 1.0
    assert cells.clearance == 4


def test_inside_of_a_closed_building_is_left_out_and_kept_on_demand() -> None:
    scene = make_scene(ground(0, 0, 30, 30), box_faces((10, 10, 0), (20, 20, 9)))
    cells = decompose(scene, SMALL)
    assert not inside(cells, (15.03, 15.03, 4.03))
    assert inside(cells, (5.03, 5.03, 4.03))
    assert inside(cells, (15.03, 15.03, 12.03))
    assert inside(decompose(scene, dataclasses.replace(SMALL, keep_interiors=True)), (15.03, 15.03, 4.03))


def test_building_without_a_bottom_is_closed_by_the_ground() -> None:
    building = box_faces((10, 10, 0), (20, 20, 9))
    walls_and_roof = building[~np.all(building[:, :, 2] == 0, axis=1)]
    assert len(walls_and_roof) == 10
    assert not inside(
        decompose(make_scene(ground(0, 0, 30, 30), walls_and_roof), SMALL), (15.03, 15.03, 4.03)
    )


def test_seed_selects_the_room_that_holds_it() -> None:
    scene = make_scene(ground(0, 0, 30, 30), box_faces((10, 10, 0), (20, 20, 9)))
    cells = decompose(scene, dataclasses.replace(SMALL, seeds=((15.0, 15.0, 4.0),)))
    assert inside(cells, (15.03, 15.03, 4.03))
    assert not inside(cells, (5.03, 5.03, 4.03))
    assert cells.coverage > 0.9


def test_roof_over_the_domain_is_no_sky() -> None:
    scene = make_scene(ground(0, 0, 16, 16), ground(-1, -1, 17, 17, 30.0))
    settings = dataclasses.replace(SMALL, altitude_max=16.0, region=(0.0, 0.0, 16.0, 16.0))
    with pytest.raises(CellError, match=r"no cell of .* is connected to the sky"):
        decompose(scene, settings)
    with pytest.raises(CellError, match=r"none of \d+ free cells touches the open sky"):
        decompose(scene, dataclasses.replace(settings, method="boxes"))
    assert decompose(scene, dataclasses.replace(settings, keep_interiors=True)).count > 0


def test_kinds_follow_the_height_above_a_carrying_face() -> None:
    scene = make_scene(ground(0, 0, 16, 16))
    cells = decompose(scene, dataclasses.replace(SMALL, max_size=4.0, altitude_max=16.0))
    near = cells.lower[:, 2] < round(3.0 / STEP)
    assert np.all((cells.kinds == KIND_GROUND) == near)
    assert np.any(cells.kinds == KIND_AERIAL)
    assert np.any(near)


def test_wall_does_not_carry_a_ground_vehicle() -> None:
    wall = np.array([[(0.0, 0, 0), (16, 0, 0), (16, 0, 8)], [(0, 0, 0), (16, 0, 8), (0, 0, 8)]])
    scene = make_scene(wall, wall + np.array((0, 16, 0)))
    assert np.all(decompose(scene, SMALL).kinds == KIND_AERIAL)


@pytest.mark.parametrize("clearance", [0.0, 0.25])
def test_thin_wall_with_a_door_separates_except_at_the_door(clearance: float) -> None:
    left = np.array([[(8.0, 0, 0), (8, 6, 0), (8, 6, 8)], [(8, 0, 0), (8, 6, 8), (8, 0, 8)]])
    right = np.array([[(8.0, 10, 0), (8, 16, 0), (8, 16, 8)], [(8, 10, 0), (8, 16, 8), (8, 10, 8)]])
    room = box_faces((0, 0, 0), (16, 16, 8))
    settings = dataclasses.replace(
        SMALL,
        clearance=clearance,
        keep_interiors=True,
        max_size=8.0,
        region=(0.0, 0.0, 16.0, 16.0),
        altitude_max=8.0,
    )
    cells = decompose(make_scene(room, left, right), settings)
    sources = np.repeat(np.arange(cells.count), np.diff(cells.portal_offsets))
    for source, target, number in zip(sources, cells.portal_targets, cells.portal_polygons, strict=True):
        low, high = polygon(cells, number).min(axis=0), polygon(cells, number).max(axis=0)
        if low[0] == high[0] == 128:
            assert low[1] >= 96
            assert high[1] <= 160
        assert source != target
    crossing = (cells.lower[:, 0] < 128) & (cells.upper[:, 0] > 128)
    assert np.all(cells.lower[crossing, 1] >= 96)
    assert np.all(cells.upper[crossing, 1] <= 160)


def test_voxels_are_uniform() -> None:
    scene = make_scene(ground(0, 0, 16, 16))
    cells = decompose(scene, dataclasses.replace(SMALL, method="voxel", voxel_size=2.0, altitude_max=8.0))
    assert np.all(cells.upper - cells.lower == 32)
    assert cells.count == 8 * 8 * 3  # the lowest layer touches the ground


def test_planes_are_exact_and_in_order() -> None:
    cells = decompose(make_scene(ground(0, 0, 16, 16)), SMALL)
    table = planes(cells, STEP)
    assert table.shape == (cells.count, 6, 4)
    for axis in range(3):
        assert np.array_equal(table[:, 2 * axis, 3] / STEP, cells.lower[:, axis])
        assert np.array_equal(-table[:, 2 * axis + 1, 3] / STEP, cells.upper[:, axis])
    centre = (cells.lower + cells.upper) * (STEP / 2)
    values = np.einsum("nij,nj->ni", table[:, :, :3], centre) + table[:, :, 3]
    assert np.all(values < 0)
    assert not np.any(np.signbit(table) & (table == 0))


def test_portal_table_is_sorted_and_symmetric() -> None:
    cells = decompose(make_scene(ground(0, 0, 30, 30), box_faces((10, 10, 0), (20, 20, 9))), SMALL)
    directed = {}
    for i, (start, end) in enumerate(pairwise(cells.portal_offsets)):
        targets = cells.portal_targets[start:end]
        assert np.all(np.diff(targets) > 0)
        directed.update(
            {(i, int(t)): int(p) for t, p in zip(targets, cells.portal_polygons[start:end], strict=True)}
        )
    assert directed
    assert all(directed[b, a] == number for (a, b), number in directed.items())
    assert sorted(set(directed.values())) == list(range(cells.polygon_count))


def test_neighbours_in_the_list_are_near_in_space() -> None:
    cells = decompose(make_scene(ground(0, 0, 64, 64)), dataclasses.replace(SMALL, max_size=4.0))
    centres = (cells.lower + cells.upper) / 2
    steps = np.abs(np.diff(centres, axis=0)).sum(axis=1)
    shuffled = np.abs(np.diff(np.random.default_rng(0).permutation(centres), axis=0)).sum(axis=1)
    assert steps.mean() < 0.3 * shuffled.mean()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"region": (100.0, 100.0, 110.0, 110.0)}, "outside the scene; allowed"),
        ({"region": (5.0, 0.0, 5.0, 10.0)}, "x0 < x1"),
        ({"region": (0.0, 0.0, float("nan"), 10.0)}, "finite"),
        ({"seeds": ((15.0, 15.0, 0.1),)}, "a face is within"),
        ({"seeds": ((15.0, 15.0, 1000.0),)}, "outside the domain"),
        ({"seeds": ()}, "seeds is empty"),
        ({"max_cells": 10}, "too many cells"),
        ({"threads": -1}, "threads is -1"),
        ({"altitude_min": 50.0}, "altitude_min"),
        ({"altitude_max": 0.5}, "at least one cell"),
        ({"max_size": 1.0, "min_size": 1.0, "altitude_max": 1.0}, "no free space"),
        ({"min_size": 0.01}, "2 or more"),
    ],
)
def test_what_cannot_be_done_is_refused(change: dict[str, object], message: str) -> None:
    scene = make_scene(ground(0, 0, 30, 30))
    with pytest.raises(CellError, match=message):
        decompose(scene, dataclasses.replace(SMALL, **change))


@pytest.mark.parametrize(
    "change",
    [
        {"min_size": 0.0},
        {"min_size": float("nan")},
        {"clearance": -1.0},
        {"max_size": 1.0},
        {"method": "tree"},
        {"coverage_points": 0},
    ],
)
def test_settings_out_of_range_are_refused(change: dict[str, object]) -> None:
    with pytest.raises(CellError, match="allowed"):
        CellSettings(**change)  # type: ignore[arg-type]


def test_scene_without_faces_is_refused() -> None:
    empty = Scene(
        np.zeros((0, 3), np.int64),
        np.zeros((0, 3), np.int32),
        np.zeros(0, np.int32),
        np.zeros(0, np.int32),
        (),
        -4,
    )
    with pytest.raises(CellError, match="no face"):
        decompose(empty, SMALL)


def test_progress_ends_at_the_number_of_tasks() -> None:
    seen: list[tuple[int, int]] = []
    decompose(make_scene(ground(0, 0, 30, 30)), SMALL, lambda done, tasks: seen.append((done, tasks)))
    assert seen[-1][0] == seen[-1][1] == len(seen)


def test_strip_too_thin_for_a_voxel_does_not_hide_the_sky() -> None:
    scene = make_scene(ground(0, 0, 17, 17))
    cells = decompose(scene, dataclasses.replace(SMALL, method="voxel", voxel_size=2.0, altitude_max=8.5))
    assert cells.count == 8 * 8 * 3
    assert cells.upper.max(axis=0).tolist() == [256, 256, 128]
    assert 0.7 < cells.coverage < 0.85  # the lowest layer touches the ground: 6 of 7.75 m are left
