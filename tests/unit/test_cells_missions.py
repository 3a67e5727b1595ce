"""Missions on hand-made grounds: what cells may never do, and what they must hold."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from mission_scenes import (
    STEP,
    box_faces,
    hill,
    holders,
    mesh_heights,
    rectangle,
    scene_of,
    surface,
    wall,
)

from tilesnav_ref.cells import KIND_GROUND, CellComplex, CellError, CellSettings, decompose

AIR = CellSettings(min_size=2.0, max_size=16.0, clearance=0.25, altitude_max=24.0, coverage_points=4000)
GROUND = CellSettings(
    mission="ground", min_size=1.0, max_size=8.0, clearance=0.0625, ground_height=3.0, coverage_points=4000
)


def heights_above(cells: CellComplex, ground: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Greatest height of each upper side above a height field (m), at a grid of points of its plan, and least
    of each lower side, at its corners."""
    shares = np.linspace(0.0, 1.0, 5)
    low, high = cells.lower * STEP, cells.upper * STEP
    tops, bottoms = np.full(cells.count, -np.inf), np.full(cells.count, np.inf)
    for a in shares:
        for b in shares:
            points = low[:, :2] + (high[:, :2] - low[:, :2]) * (a, b)
            below = mesh_heights(ground, points)
            tops = np.maximum(tops, high[:, 2] - below)
    for corner in range(4):  # of the lower side, which may slant
        place = cells.corners[:, corner] * STEP
        bottoms = np.minimum(bottoms, place[:, 2] - mesh_heights(ground, place[:, :2]))
    return tops, bottoms


def test_no_cell_is_above_the_ceiling_over_a_hill() -> None:
    ground = surface(hill, 128.0)
    cells = decompose(scene_of(ground), AIR)
    tops, bottoms = heights_above(cells, ground)
    assert tops.max() <= 24.0
    assert bottoms.min() >= 0.25  # the clearance
    assert cells.upper[:, 2].max() * STEP > 40.0 + 24.0 - 4.0  # and the band goes over the top
    assert cells.coverage > 0.8


def test_band_that_is_off_the_grid_is_rounded_inwards() -> None:
    ground = surface(lambda _x, _y: 0.0, 32.0)
    band = dataclasses.replace(AIR, altitude_min=8.02, altitude_max=24.05)  # 128.32 and 384.8 grid steps
    tops, bottoms = heights_above(decompose(scene_of(ground), band), ground)
    assert tops.max() == 24.0
    assert bottoms.min() == 8.0625


def test_upright_face_alone_has_no_space() -> None:
    with pytest.raises(CellError, match=r"the domain is 0.0 m along x"):
        decompose(scene_of(wall(4.0, (0.0, 30.0), (0.0, 30.0))), AIR)


def test_lower_end_of_the_band_follows_the_hill_too() -> None:
    ground = surface(hill, 128.0)
    cells = decompose(scene_of(ground), dataclasses.replace(AIR, altitude_min=8.0))
    tops, bottoms = heights_above(cells, ground)
    assert tops.max() <= 24.0
    assert bottoms.min() >= 8.0
    assert holders(cells, (64.03, 64.03, 55.03)).size == 1
    assert holders(cells, (4.03, 4.03, 15.03)).size == 1


def test_altitudes_above_the_lowest_point_do_not_follow_the_hill() -> None:
    cells = decompose(scene_of(surface(hill, 128.0)), dataclasses.replace(AIR, altitude_above="lowest"))
    assert cells.upper[:, 2].max() * STEP == 24.0


def test_voxels_over_a_hill_are_whole_and_below_the_ceiling() -> None:
    ground = surface(hill, 128.0, 8.0)
    settings = dataclasses.replace(AIR, method="voxel", voxel_size=4.0)
    cells = decompose(scene_of(ground), settings)
    assert np.all(cells.upper - cells.lower == round(4.0 / STEP))
    assert heights_above(cells, ground)[0].max() <= 24.0


@pytest.mark.parametrize("named", [False, True])
def test_ceiling_over_a_house_whose_ground_was_cut_out(named: bool) -> None:
    around = [
        rectangle((0, 24), (0, 64), (0, 0)),
        rectangle((40, 64), (0, 64), (0, 0)),
        rectangle((24, 40), (0, 24), (0, 0)),
        rectangle((24, 40), (40, 64), (0, 0)),
    ]
    house = box_faces((24, 24, 0), (40, 40, 12))
    house = house[~np.all(house[:, :, 2] == 0, axis=1)]
    cells = decompose(scene_of(np.concatenate(around), house, terrain=0 if named else None), AIR)
    assert cells.upper[:, 2].max() * STEP == 24.0
    assert holders(cells, (32.03, 32.03, 20.03)).size == 1


def test_hole_in_the_ground_takes_the_lowest_ground_beside_it() -> None:
    low, high = rectangle((0, 24), (0, 64), (0, 0)), rectangle((40, 64), (0, 64), (10, 10))
    cells = decompose(scene_of(low, high, terrain=None), dataclasses.replace(AIR, max_size=8.0))
    over_hole = (cells.lower[:, 0] * STEP >= 24.0) & (cells.upper[:, 0] * STEP <= 40.0)
    assert np.any(over_hole)
    assert cells.upper[over_hole, 2].max() * STEP <= 24.0
    named = decompose(
        scene_of(np.concatenate((low, high)), terrain=0), dataclasses.replace(AIR, max_size=8.0)
    )
    assert named.upper[:, 2].max() * STEP == 34.0  # the upper ground is ground when it is named


def test_bridge_does_not_lift_the_ceiling_and_both_storeys_are_flown() -> None:
    bridge = box_faces((24, 0, 8), (40, 64, 9))
    cells = decompose(scene_of(rectangle((0, 64), (0, 64), (0, 0)), bridge), AIR)
    assert cells.upper[:, 2].max() * STEP == 24.0
    assert holders(cells, (32.03, 32.03, 4.03)).size == 1
    assert holders(cells, (32.03, 32.03, 16.03)).size == 1


def test_scene_without_ground_counts_from_its_lowest_faces() -> None:
    cells = decompose(scene_of(box_faces((0, 0, 50), (32, 32, 52)), rectangle((0, 4), (0, 4), (50, 50))), AIR)
    assert cells.upper[:, 2].max() * STEP == 50.0 + 24.0
    assert cells.lower[:, 2].min() * STEP >= 50.0


def test_ground_cells_follow_a_slope_and_are_low() -> None:
    ground = rectangle((0, 48), (0, 32), (0, 6))
    cells = decompose(scene_of(ground), GROUND)
    tops, bottoms = heights_above(cells, ground)
    assert tops.max() <= 3.0
    assert bottoms.min() >= 0.0625
    assert np.all(cells.kinds == KIND_GROUND)
    assert cells.coverage > 0.7
    assert len(set(cells.upper[:, 2].tolist())) > 3


def test_slope_that_is_too_steep_splits_the_ground() -> None:
    parts = (
        rectangle((0, 16), (0, 32), (0, 0)),
        rectangle((16, 24), (0, 32), (0, 6)),
        rectangle((24, 40), (0, 32), (6, 6)),
    )
    scene = scene_of(*parts)
    settings = dataclasses.replace(GROUND, seeds=((4.0, 4.0, 1.0),))
    gentle = decompose(scene, dataclasses.replace(settings, ground_slope=0.8))
    steep = decompose(scene, dataclasses.replace(settings, ground_slope=0.5))
    assert holders(gentle, (32.03, 16.03, 8.03)).size == 1
    assert holders(steep, (32.03, 16.03, 8.03)).size == 0
    assert holders(steep, (8.03, 16.03, 1.53)).size == 1
    assert steep.upper[:, 0].max() * STEP <= 17.0


@pytest.mark.parametrize(("rise", "climbed"), [(0.25, True), (0.5, False)])
def test_step_that_is_too_high_splits_the_ground(rise: float, climbed: bool) -> None:
    scene = scene_of(
        rectangle((0, 16), (0, 32), (0, 0)),
        wall(16, (0, 32), (0, rise)),
        rectangle((16, 32), (0, 32), (rise, rise)),
    )
    cells = decompose(scene, dataclasses.replace(GROUND, seeds=((4.0, 4.0, 1.0),)))
    assert (holders(cells, (24.03, 16.03, 2.03)).size == 1) == climbed
    both = decompose(scene, GROUND)  # from the sky both are ground, in one part or in two
    assert holders(both, (24.03, 16.03, 2.03)).size == 1
    sources = np.repeat(np.arange(both.count), np.diff(both.portal_offsets))
    left = both.upper[:, 0] * STEP <= 16.0
    assert np.any(left[sources] != left[both.portal_targets]) == climbed


def test_roof_and_platform_are_not_come_to_but_a_ramp_is() -> None:
    floor, house = rectangle((0, 48), (0, 32), (0, 0)), box_faces((8, 8, 0), (20, 24, 6))
    platform = box_faces((28, 8, 0), (36, 16, 1))
    cells = decompose(scene_of(floor, house, platform), GROUND)
    assert holders(cells, (4.03, 4.03, 1.53)).size == 1
    assert holders(cells, (14.03, 16.03, 7.53)).size == 0
    assert holders(cells, (14.03, 16.03, 1.53)).size == 0  # nor the inside of the house
    assert holders(cells, (32.03, 12.03, 2.53)).size == 0
    ramp = rectangle((36, 44), (8, 16), (1, 0))
    with_ramp = decompose(scene_of(floor, house, platform, ramp), GROUND)
    assert holders(with_ramp, (32.03, 12.03, 2.53)).size == 1


def test_street_under_a_bridge_and_the_bridge_are_two_storeys() -> None:
    bridge = box_faces((12, 0, 6), (20, 32, 7))
    cells = decompose(scene_of(rectangle((0, 32), (0, 32), (0, 0)), bridge), GROUND)
    assert holders(cells, (16.03, 16.03, 1.53)).size == 1
    assert holders(cells, (16.03, 16.03, 8.53)).size == 0
    up = decompose(
        scene_of(rectangle((0, 32), (0, 32), (0, 0)), bridge),
        dataclasses.replace(GROUND, seeds=((16.0, 16.0, 8.5),)),
    )
    assert holders(up, (16.03, 16.03, 8.53)).size == 1
    assert holders(up, (16.03, 16.03, 1.53)).size == 0


def test_corridor_cells_meet_the_tube_and_cover_it() -> None:
    line = ((8.0, 8.0, 12.0), (56.0, 8.0, 12.0), (56.0, 56.0, 16.0))
    settings = dataclasses.replace(
        AIR, mission="corridor", corridor=line, corridor_radius=5.0, max_size=8.0, altitude_max=None
    )
    house = box_faces((20, 0, 0), (28, 20, 14))
    cells = decompose(scene_of(rectangle((0, 64), (0, 64), (0, 0)), house), settings)
    whole = decompose(scene_of(rectangle((0, 64), (0, 64), (0, 0)), house), AIR)
    rng = np.random.default_rng(0)
    low, high = cells.lower * STEP, cells.upper * STEP
    nearest = np.full(cells.count, np.inf)
    free = 0
    for start, end in zip(np.array(line)[:-1], np.array(line)[1:], strict=True):
        for share in np.linspace(0, 1, 400):
            place = start + share * (end - start)
            gap = np.linalg.norm(np.maximum(np.maximum(low - place, place - high), 0), axis=1)
            nearest = np.minimum(nearest, gap)
            point = place + rng.normal(size=3) * 1.5
            if np.linalg.norm(point - place) < 5.0 and not (
                18 < point[0] < 30 and point[1] < 22 and point[2] < 16
            ):
                free += 1
                inside = np.any(np.all((low <= point) & (point <= high), axis=1))
                assert inside, point
    assert free > 400
    assert nearest.max() <= 5.0 + 0.1  # the samples of the line are 0.12 m apart
    assert cells.count < whole.count * 8
    assert cells.coverage > 0.9
    assert holders(cells, (24.03, 10.03, 8.03)).size == 0  # the line goes through the house, no cell does


def test_corridor_with_no_free_start_is_refused() -> None:
    room = box_faces((0, 0, 0), (32, 32, 12))
    roof = box_faces((-8, -8, 20), (40, 40, 21))
    settings = dataclasses.replace(
        AIR, mission="corridor", corridor=((40.0, 100.0, 4.0), (80.0, 100.0, 4.0)), altitude_max=None
    )
    with pytest.raises(CellError, match="tube of the corridor"):
        decompose(scene_of(room, roof), settings)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mission": "space"}, "allowed: 'aerial', 'ground', 'corridor'"),
        ({"mission": "corridor"}, "2 or more points"),
        ({"corridor": ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))}, "none without"),
        ({"mission": "corridor", "corridor": ((0.0, 0.0, 0.0),)}, "2 or more points"),
        ({"mission": "corridor", "corridor": ((0.0, 0.0, 0.0), (1.0, 0.0, float("nan")))}, "finite"),
        ({"corridor_radius": 0.0}, "corridor_radius is 0.0"),
        ({"altitude_above": "sea"}, "'ground', 'lowest'"),
        ({"mission": "ground", "altitude_max": 10.0}, "ground_height alone"),
        ({"mission": "ground", "ground_height": 0.0}, "more than 0"),
        ({"ground_step": -1.0}, "ground_step"),
        ({"sector": (0, 0)}, "without sector_size"),
        ({"sector_size": 8.0}, "at least 16"),
        ({"sector_size": float("inf")}, "finite"),
    ],
)
def test_missions_out_of_range_are_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(CellError, match=message):
        CellSettings(**change)  # type: ignore[arg-type]


def test_ground_cells_that_do_not_fit_below_the_height_are_refused() -> None:
    with pytest.raises(CellError, match="min_size and clearance at least"):
        decompose(scene_of(rectangle((0, 32), (0, 32), (0, 0))), dataclasses.replace(GROUND, min_size=4.0))


def test_ground_without_a_face_that_carries_is_refused() -> None:
    with pytest.raises(CellError, match="no face of slope"):
        decompose(scene_of(wall(0, (0, 32), (0, 8)), wall(32, (0, 32), (0, 8))), GROUND)
