"""The ground of columns: what is ground, what is raised, and what holes take."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mission_scenes import STEP, box_faces, hill, mesh_heights, rectangle, surface, wall

from tilesnav_ref.cells.columns import EMPTY, column_heights
from tilesnav_ref.cells.terrain import Ground, find_ground, level_ground, level_patches


def ground_of(*parts: np.ndarray, size: float = 64.0, terrain: int | None = None) -> Ground:
    corners = np.round(np.concatenate(parts) / STEP).astype(np.int64)
    owner = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
    plan = np.array([[0, 0], [round(size / STEP)] * 2])
    return find_ground(corners, plan, STEP, None if terrain is None else owner == terrain)


def low_at(ground: Ground, x: float, y: float) -> float:
    return float(ground.at(np.array([[round(x / STEP), round(y / STEP), 0]]))[0]) * STEP


def test_low_bounds_a_hill_from_below_and_high_from_above() -> None:
    faces = surface(hill, 128.0)
    ground = ground_of(faces, size=128.0)
    rng = np.random.default_rng(0)
    points = rng.uniform(0, 128, (300, 2))
    below = mesh_heights(faces, points)
    place = (points / STEP).astype(int) // ground.size
    low, high = ground.low[tuple(place.T)] * STEP, ground.high[tuple(place.T)] * STEP
    assert np.all(low <= below)
    assert np.all(high >= below)
    assert np.all(below - low <= 3.6)  # the hill rises by 1.25 at most, a column has a diagonal of 2.83 m
    assert ground.own.all()


def test_roof_of_a_house_without_ground_below_is_raised() -> None:
    ring = [
        rectangle((0, 24), (0, 64), (0, 0)),
        rectangle((40, 64), (0, 64), (0, 0)),
        rectangle((24, 40), (0, 24), (0, 0)),
        rectangle((24, 40), (40, 64), (0, 0)),
    ]
    house = box_faces((24, 24, 0), (40, 40, 12))
    house = house[~np.all(house[:, :, 2] == 0, axis=1)]
    ground = ground_of(*ring, house)
    assert ground.low.max() == 0
    assert not ground.own[16, 16]


def test_terrace_is_ground_though_it_drops_on_one_side() -> None:
    ground = ground_of(
        rectangle((0, 32), (0, 64), (0, 0)), rectangle((32, 64), (0, 64), (6, 6)), wall(32, (0, 64), (0, 6))
    )
    assert low_at(ground, 50, 30) == 6.0
    assert low_at(ground, 10, 30) == 0.0
    assert low_at(ground, 33, 30) == 0.0  # the column of the wall


def test_well_does_not_raise_the_town_around_it() -> None:
    pit = box_faces((30, 30, -20), (34, 34, 0))
    pit = pit[~np.all(pit[:, :, 2] == 0, axis=1)]
    ground = ground_of(
        rectangle((0, 30), (0, 64), (0, 0)),
        rectangle((34, 64), (0, 64), (0, 0)),
        rectangle((30, 34), (0, 30), (0, 0)),
        rectangle((30, 34), (34, 64), (0, 0)),
        pit,
    )
    assert low_at(ground, 10, 10) == 0.0
    assert low_at(ground, 32, 32) == -20.0


def test_hole_takes_the_lowest_ground_beside_it() -> None:
    ground = ground_of(rectangle((0, 20), (0, 64), (4, 4)), rectangle((44, 64), (0, 64), (1, 1)))
    assert low_at(ground, 32, 32) == 1.0
    assert not ground.own[16, 16]
    assert low_at(ground, 10, 10) == 4.0


def test_named_terrain_is_ground_and_nothing_else_is() -> None:
    cliff, cellar = rectangle((0, 64), (0, 64), (10, 10)), rectangle((10, 20), (10, 20), (2, 2))
    assert low_at(ground_of(cliff, cellar, terrain=0), 15, 15) == 10.0
    assert low_at(ground_of(cliff, cellar), 15, 15) == 2.0


def test_without_ground_in_the_plan_the_lowest_face_counts() -> None:
    ground = ground_of(rectangle((100, 120), (0, 64), (7, 7)))
    assert np.all(ground.low == round(7 / STEP))
    assert not ground.own.any()


def test_level_ground_is_that_of_faces_in_the_plan() -> None:
    corners = np.round(
        np.concatenate((rectangle((0, 8), (0, 8), (3, 4)), rectangle((90, 99), (0, 8), (0, 0)))) / STEP
    )
    ground = level_ground(corners.astype(np.int64), np.array([[0, 0], [160, 160]]))
    assert low_at(ground, 5, 5) == 3.0


@pytest.mark.parametrize("shape", [(1, 1), (3, 3), (1, 9), (7, 2)])
def test_patch_that_drops_on_all_sides_is_raised_whatever_its_shape(shape: tuple[int, int]) -> None:
    low = np.zeros((12, 12), np.int64)
    low[1 : 1 + shape[0], 1 : 1 + shape[1]] = 50
    level = level_patches(low, low, np.ones_like(low, np.bool_), 10)
    assert np.array_equal(level, low == 0)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_heights_of_columns_hold_every_point_of_random_faces(seed: int) -> None:
    rng = np.random.default_rng(seed)
    corners = rng.integers(-50, 150, (4, 3, 3))
    low, high = column_heights(corners, np.zeros(2, np.int64), 16, (6, 6))
    weights = rng.dirichlet((1.0, 1.0, 1.0), 60)
    for triangle in corners:
        points = weights @ triangle
        place = np.floor(points[:, :2] / 16).astype(int)
        for point, (i, j) in zip(points, place, strict=True):
            if 0 <= i < 6 and 0 <= j < 6:
                assert low[i, j] <= point[2] + 1e-9
    assert np.all((low == EMPTY) | ((low <= high) & (low >= corners[:, :, 2].min())))
