"""Porous faces hide nothing, one-sided faces are seen from their front, and the range ends where it says."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from visibility_reference import make_flagged

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.visibility import VisibilitySettings, compute_pvs
from tilesnav_ref.visibility.geometry import UNLIMITED, FineFrame, build_geometry
from tilesnav_ref.visibility.limits import is_out
from tilesnav_ref.visibility.prisms import box_prism
from tilesnav_ref.visibility.sampling import points_within
from tilesnav_ref.visibility.sight import counts

CELL = [[-4, -4, -4], [4, 4, 4]]
STEP = 2.0**-10
WORK = VisibilitySettings(rays=500, threads=1)
IDLE = VisibilitySettings(rays=1, attempts=1, depth=0, leaf_segments=0, aimed_rounds=0, threads=1)


def sheet(x, size):
    """Triangle across the x axis, its front towards +x, and large enough for a shaft of half-width `size`."""
    return [(x, -3 * size, -2 * size), (x, 3 * size, -2 * size), (x, 0, 4 * size)]


def sets(scene, work=WORK, box=CELL):
    """Listed faces, and those of them that are proven visible."""
    cells = np.asarray(box, np.int64).reshape(-1, 2, 3)
    none = np.zeros(0, np.int64)
    complex_ = CellComplex(
        cells[:, 0], cells[:, 1], np.zeros(len(cells), np.uint8), np.zeros(len(cells) + 1, np.int64),
        none, none, 0, 1.0,
    )  # fmt: skip
    table = compute_pvs(scene, complex_, work)
    return set(table.faces_of(0).tolist()), set(table.pvs_faces[table.pvs_proven].tolist())


WALL_AND_TARGET = [sheet(20, 60), sheet(40, 6)]


@pytest.mark.parametrize("work", [WORK, IDLE])
def test_a_porous_wall_hides_nothing(work):
    assert sets(make_flagged(WALL_AND_TARGET), WORK)[0] == {0}
    assert sets(make_flagged(WALL_AND_TARGET, porous=[0]), work)[0] == {0, 1}
    assert sets(make_flagged(WALL_AND_TARGET, porous=[1]), WORK)[0] == {0}


def test_what_is_seen_through_a_forest_is_proven():
    forest = [sheet(10 + 3 * i, 40) for i in range(20)]
    porous = range(len(forest))
    both = sets(make_flagged([*forest, sheet(90, 20), sheet(120, 10)], porous))
    assert both == ({*porous, 20}, {*porous, 20})


def test_an_opaque_wall_does_not_go_on_in_a_porous_one():
    tip, left, right = (20, 0, 12), (20, -90, -90), (20, 90, -90)
    top_left, top_right = (20, -90, 90), (20, 90, 90)
    wall = [[left, right, tip], [right, top_right, tip], [left, tip, top_left], [tip, top_right, top_left]]
    target = [[(40, -30, -40), (40, 30, -40), (40, 0, 36)]]
    assert 4 not in sets(make_flagged(wall + target))[0]
    assert 4 in sets(make_flagged(wall + target, porous=[1, 2, 3]), IDLE)[0]


def test_a_one_sided_face_is_listed_from_its_front_only():
    behind, front = sheet(20, 6), sheet(20, 6)[::-1]
    assert sets(make_flagged([behind], one_sided=[0]), IDLE)[0] == set()
    assert sets(make_flagged([front], one_sided=[0])) == ({0}, {0})
    assert sets(make_flagged([behind])) == ({0}, {0})


def test_a_one_sided_face_hides_from_both_sides():
    for wall in (sheet(20, 60), sheet(20, 60)[::-1]):
        listed, _ = sets(make_flagged([wall, sheet(40, 6)], one_sided=[0]))
        assert 1 not in listed


def test_a_cell_across_the_plane_of_a_one_sided_face_lists_it():
    floor = [(20, -9, 0), (60, 0, 0), (20, 9, 0)]
    assert sets(make_flagged([floor], one_sided=[0])) == ({0}, {0})


def test_a_one_sided_face_is_proven_from_the_part_of_a_cell_before_it():
    floor = [(20, -9, 0), (60, 0, 0), (20, 9, 0)]  # its front is above, where a plate shuts it off
    plate = [(12, -400, 0), (12, 400, 0), (12, 0, 400)]
    assert 0 in sets(make_flagged([floor, plate]))[1]
    assert 0 not in sets(make_flagged([floor, plate], one_sided=[0]))[1]
    assert 0 in sets(make_flagged([floor[::-1], plate], one_sided=[0]))[1]


@pytest.mark.parametrize(("steps", "listed"), [(16, set()), (17, {0}), (15, set())])
def test_the_range_ends_where_it_says(steps, listed):
    scene = make_flagged([sheet(20, 3)])  # 16 steps from the cell
    work = VisibilitySettings(rays=500, threads=1, max_range=steps * STEP)
    assert sets(scene, work) == (listed, listed)
    idle = VisibilitySettings(**{**vars(IDLE), "max_range": steps * STEP})
    assert sets(scene, idle)[0] == listed


def test_a_range_takes_nothing_from_what_is_near_and_hides_what_is_far():
    near, far = [sheet(x, 3) for x in (10, -10)], [sheet(x, 300) for x in (100, -100)]
    scene = make_flagged(near + far)
    assert sets(scene, VisibilitySettings(rays=500, max_range=60 * STEP)) == ({0, 1}, {0, 1})
    assert sets(scene, VisibilitySettings(rays=500, max_range=1e9)) == ({0, 1, 2, 3}, {0, 1, 2, 3})


def test_the_range_in_fine_units_is_rounded_to_either_side():
    frame = FineFrame(np.zeros(3, np.int64), 64)
    scene = make_flagged([sheet(20, 3)])
    for reach, near, far in ((1.0, 63, 64), (1.5, 95, 96), (1 + 2**-20, 64, 65), (2.0**-80, 0, 1)):
        geometry = build_geometry(scene, frame, reach * STEP)
        assert (geometry.near, geometry.far) == (near, far)
    assert build_geometry(scene, frame).near == build_geometry(scene, frame, 1e300).far == UNLIMITED


@pytest.mark.parametrize("value", [0.0, -1.0, np.inf, np.nan])
def test_a_range_that_is_none_is_refused(value):
    with pytest.raises(ValueError, match="max_range"):
        VisibilitySettings(max_range=value)


def test_a_segment_counts_within_the_range_and_before_the_front():
    frame = FineFrame(np.zeros(3, np.int64), 64)
    geometry = build_geometry(make_flagged([sheet(20, 3), sheet(20, 3)], one_sided=[1]), frame, 30 * STEP)
    at, beyond, before, behind = (float(64 * x) for x in (20, 51, 49, -9))
    assert counts(geometry, (before, 0.0, 0.0), (at, 0.0, 0.0), 0)
    assert counts(geometry, (before, 0.0, 0.0), (at, 0.0, 0.0), 1)
    assert counts(geometry, (behind, 0.0, 0.0), (at, 0.0, 0.0), 0)
    assert not counts(geometry, (behind, 0.0, 0.0), (at, 0.0, 0.0), 1)
    assert not counts(geometry, (at, 1.0, 0.0), (at, 0.0, 0.0), 1)  # in its plane
    assert not counts(geometry, (beyond, 0.0, 0.0), (at, 0.0, 0.0), 0)
    assert not counts(geometry, (before + 64, 0.0, 0.0), (at, 0.0, 0.0), 0)  # 30 steps exactly


def distance(box, triangle):
    """Distance of a box and a triangle, by many rounds of alternating projections onto both."""
    a, b, c = np.asarray(triangle, float)
    grid = [(i / 60, j / 60) for i in range(61) for j in range(61 - i)]
    points = np.array([a + (b - a) * u + (c - a) * v for u, v in grid])
    return np.linalg.norm(points - np.clip(points, box[0], box[1]), axis=1).min()


small = st.integers(-12, 12)
corner = st.tuples(small, small, small)


@given(st.tuples(corner, corner, corner), st.integers(1, 30))
@settings(max_examples=200, deadline=None)
def test_a_face_is_out_of_range_when_it_is(triangle, reach):
    u, v = np.subtract(triangle[1], triangle[0]), np.subtract(triangle[2], triangle[0])
    if not np.any(np.cross(u, v)):
        return
    frame = FineFrame(np.zeros(3, np.int64), 64)
    geometry = build_geometry(make_flagged([triangle]), frame, reach * STEP)
    box = np.array(CELL, float)
    apart = distance(box, triangle)
    grain = max(np.abs(u).max(), np.abs(v).max()) * np.sqrt(3) / 60  # of the points that were looked at
    if is_out(geometry, box_prism(box * 64), 0):
        assert apart >= reach - 1e-9
    elif apart - grain > reach + 0.5:
        pytest.fail("a face far beyond the range is kept")


@given(st.integers(0, 2**32 - 1), st.integers(0, 300))
@settings(max_examples=100, deadline=None)
def test_points_are_drawn_near_their_targets_and_within_the_box(seed, near):
    random = np.random.default_rng(seed)
    box = np.array([[-50.0, 0, 10], [50, 7, 12]])
    targets = random.uniform(-200, 200, (40, 3))
    found = points_within(random, box_prism(box), targets, near)
    assert (found > box[0]).all()
    assert (found < box[1]).all()
    assert np.array_equal(found, np.rint(found))
    reachable = (targets > box[0] + 1 - near) & (targets < box[1] - 1 + near) & (near >= 1)
    assert (np.abs(found - targets)[reachable] <= near).all()
