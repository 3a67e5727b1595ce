"""One segment against one face and against a scene."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from visibility_reference import half_open_meets, make_scene, point, sees

from tilesnav_ref.visibility.geometry import FineFrame, build_geometry, fine_frame
from tilesnav_ref.visibility.sight import CROSS, MISS, TOUCH, blocker, find_crossed, make_crossed, meet

small = st.integers(0, 5)
corner = st.tuples(small, small, small)
FRAME = FineFrame(np.zeros(3, np.int64), 64)
WALL = [[(0, 0, 0), (8, 0, 0), (0, 0, 8)]]


def flat(triangle):
    u, v = np.subtract(triangle[1], triangle[0]), np.subtract(triangle[2], triangle[0])
    return not np.any(np.cross(u, v))


def floats(p):
    return tuple(float(x) for x in p)


@given(st.tuples(corner, corner, corner), corner, corner)
@settings(max_examples=400)
def test_a_miss_is_a_miss_and_a_cross_is_a_cross(triangle, c, t):
    if flat(triangle) or c == t:
        return
    corners = np.array([triangle], float)
    how = meet(corners, 0, floats(c), floats(t))
    truth = half_open_meets(point(c), point(t), [point(v) for v in triangle])
    if how == MISS:
        assert not truth
    if how == CROSS:
        assert truth
    if truth:
        assert how in (CROSS, TOUCH)


@pytest.mark.parametrize(
    ("c", "t", "how"),
    [
        ((1, -2, 1), (1, 2, 1), CROSS),
        ((1, -2, 1), (1, 0, 1), MISS),  # ends on the face: [c, t) does not meet it
        ((1, 0, 1), (1, 2, 1), TOUCH),  # begins on the face
        ((4, -2, 4), (4, 2, 4), TOUCH),  # through an edge
        ((0, -2, 0), (0, 2, 0), TOUCH),  # through a vertex
        ((9, -2, 9), (9, 2, 9), MISS),
        ((1, -2, 1), (1, -1, 1), MISS),  # stops before
        ((1, 0, 1), (2, 0, 1), TOUCH),  # in the plane
    ],
)
def test_a_wall_met_in_each_way(c, t, how):
    assert meet(np.array(WALL, float), 0, floats(c), floats(t)) == how


@given(st.lists(st.tuples(corner, corner, corner), min_size=1, max_size=12), corner, st.integers(0, 11))
@settings(max_examples=150, deadline=None)
def test_an_unblocked_segment_is_seen_by_definition(triangles, c, which):
    triangles = [t for t in triangles if not flat(t)]
    if not triangles:
        return
    scene = make_scene(triangles)
    geometry = build_geometry(scene, FRAME)
    target = which % len(triangles)
    part = geometry.corners[target]
    t = tuple((2 * part[0] + part[1] + part[2]) / 4)
    start = tuple(64.0 * x for x in c)
    if blocker(geometry, start, t, target) < 0:
        fine = [Fraction(x) / 64 for x in t]
        assert sees(scene, point(c), point(fine), target)


def test_crossings_come_in_order_and_without_the_target():
    walls = [[(-9, y, -9), (9, y, -9), (0, y, 9)] for y in (6, 2, 4, 8)]
    geometry = build_geometry(make_scene(walls), FineFrame(np.zeros(3, np.int64), 64))
    found = make_crossed(8)
    assert find_crossed(geometry, (0.0, 0.0, 0.0), (64.0, 64.0 * 10, 0.0), 3, found)
    assert list(found.nearest[: found.counts[0]]) == [1, 2, 0]
    assert sorted(found.faces[: found.counts[1]]) == [0, 1, 2]
    assert found.counts[2] == 0
    short = make_crossed(2)
    assert find_crossed(geometry, (0.0, 0.0, 0.0), (64.0, 64.0 * 10, 0.0), 3, short)
    assert list(short.nearest) == [1, 2]
    assert sorted(short.faces[: short.counts[1]]) == [0, 1, 2]


def test_what_a_segment_touches_is_kept_apart_and_what_has_no_room_is_said():
    walls = [[(-9, y, -9), (9, y, -9), (0, y, 9)] for y in (6, 2, 4, 8)]
    geometry = build_geometry(make_scene(walls), FineFrame(np.zeros(3, np.int64), 64))
    found = make_crossed(8)
    # In the plane x = 0 it runs through the upper corners at y = 2 and y = 6, and between them through y = 4.
    assert find_crossed(geometry, (0.0, 64.0 * 2, 64.0 * 9), (0.0, 64.0 * 7, -64.0), 3, found)
    assert sorted(found.touched[: found.counts[2]]) == [1]
    narrow = found._replace(faces=np.zeros(1, np.int32))
    assert not find_crossed(geometry, (0.0, 0.0, 0.0), (64.0, 64.0 * 10, 0.0), 3, narrow)


def test_the_frame_keeps_every_point_below_the_limit_and_refuses_more():
    frame = fine_frame(np.array([-(2**23) + 1] * 3), np.array([2**23 - 1] * 3))
    assert frame.scale == 32
    with pytest.raises(ValueError, match="grid steps"):
        fine_frame(np.array([-(2**30)] * 3), np.array([2**30] * 3))
    with pytest.raises(ValueError, match="grid steps"):
        fine_frame(np.array([-(2**27)] * 3), np.array([2**27] * 3))
    assert fine_frame(np.array([-(2**26)] * 3), np.array([2**26] * 3)).scale == 4
