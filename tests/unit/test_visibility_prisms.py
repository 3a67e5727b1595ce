"""Prisms over trapezoids: what is inside, how they are halved, what meets them."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tilesnav_ref.visibility.contact import meets_prism
from tilesnav_ref.visibility.prisms import (
    bounds_of,
    box_prism,
    check_prisms,
    clamp_inside,
    halve,
    holds,
    inner_range,
    plane_side,
    slant,
)
from tilesnav_ref.visibility.sampling import points_within, random_points
from tilesnav_ref.visibility.segments import inner_point
from tilesnav_ref.visibility.shaft import clears_edge, make_shaft, set_shaft

AXES = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)]


def make_prism(axes, sizes, places):
    """A prism with run axis u and slanted axis v; places are v at the four edges along w."""
    u, v = axes
    w = 3 - u - v
    corners = np.zeros((8, 3))
    for i in range(8):
        at_u, at_v = i >> u & 1, i >> v & 1
        corners[i, u], corners[i, w] = sizes[0] * at_u, sizes[1] * (i >> w & 1)
        corners[i, v] = places[2 * at_u + at_v]
    return corners


@st.composite
def prisms(draw):
    low = draw(st.integers(-30, 30)), draw(st.integers(-30, 30))
    high = low[0] + draw(st.integers(4, 40)), low[1] + draw(st.integers(4, 40))
    sizes = draw(st.tuples(st.integers(4, 30), st.integers(4, 30)))
    return make_prism(draw(st.sampled_from(AXES)), sizes, (low[0], high[0], low[1], high[1]))


def inside_by_definition(prism, p):
    """Whether a rational point is strictly inside the hull of the corners: on the inner side of all sides."""
    for axis in range(3):
        bits = [1 << k for k in range(3) if k != axis]
        for side in range(2):
            start = side << axis
            a = [Fraction(float(x)) for x in prism[start]]
            u, v = (
                [Fraction(float(x)) - y for x, y in zip(prism[start | bit], a, strict=True)] for bit in bits
            )
            n = [u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3] for k in range(3)]
            other = prism[start ^ 1 << axis]
            inner = sum(n[k] * (Fraction(float(other[k])) - a[k]) for k in range(3))
            mine = sum(n[k] * (Fraction(p[k]) - a[k]) for k in range(3))
            if mine * inner <= 0:
                return False
    return True


coordinate = st.integers(-35, 75)


@given(prisms(), st.tuples(coordinate, coordinate, coordinate))
@settings(max_examples=400)
def test_a_point_is_held_when_it_is_strictly_inside(prism, p):
    assert holds(prism, tuple(float(x) for x in p)) == inside_by_definition(prism, p)
    inner = clamp_inside(prism, tuple(float(x) for x in p))
    assert inside_by_definition(prism, [int(x) for x in inner])
    if holds(prism, tuple(float(x) for x in p)):
        assert inner == p


@given(prisms())
@settings(max_examples=20)  # each looks at thousands of points in rational numbers
def test_the_inner_range_is_all_that_is_inside(prism):
    u, v = slant(prism)
    assume(v >= 0)
    w = 3 - u - v
    for at in range(1, int(prism[7, u])):
        least, greatest = inner_range(prism, (u, v), at)
        found = []
        for value in range(-35, 76):
            p = [0, 0, 0]
            p[u], p[v], p[w] = at, value, 1
            if inside_by_definition(prism, p):
                found.append(value)
        assert found == list(range(least, greatest + 1))


@given(prisms(), st.integers(0, 2**31))
@settings(max_examples=100)
def test_random_points_are_inside(prism, seed):
    random, state = np.random.default_rng(seed), np.array([seed + 1])
    targets = random.uniform(-90, 90, (20, 3))
    drawn = [*random_points(random, prism, 20), *points_within(random, prism, targets, 25)]
    drawn += [inner_point(state, prism) for _ in range(20)]
    assert all(inside_by_definition(prism, [int(x) for x in p]) for p in drawn)
    assert len({tuple(p) for p in drawn}) > 1


@given(prisms(), st.integers(0, 2), st.tuples(coordinate, coordinate, coordinate))
@settings(max_examples=400)
def test_halves_are_prisms_that_cover_the_whole(prism, axis, p):
    below, above = np.empty((8, 3)), np.empty((8, 3))
    if not halve(prism, axis, below, above):
        lengths = [prism[i | 1 << axis, axis] - prism[i, axis] for i in range(8) if not i >> axis & 1]
        assert min(lengths) < 4 or axis == slant(prism)[0]
        return
    check_prisms(np.array([below, above]).astype(np.int64))
    whole = inside_by_definition(prism, p)
    parts = [inside_by_definition(part, p) for part in (below, above)]
    assert not all(parts)
    if not whole:
        assert not any(parts)
    elif not any(parts):  # on the cut: both halves have it for a limit
        hair = [Fraction(k == axis, 10**6) for k in range(3)]
        assert inside_by_definition(below, [x - d for x, d in zip(p, hair, strict=True)])
        assert inside_by_definition(above, [x + d for x, d in zip(p, hair, strict=True)])


corner = st.tuples(coordinate, coordinate, coordinate)
weights = st.tuples(st.integers(1, 9), st.integers(1, 9), st.integers(1, 9))


@given(prisms(), st.tuples(corner, corner, corner), weights)
@settings(max_examples=600)
def test_a_face_with_a_point_inside_meets(prism, triangle, w):
    mixed = [Fraction(sum(x * c[k] for x, c in zip(w, triangle, strict=True)), sum(w)) for k in range(3)]
    if inside_by_definition(prism, mixed):
        assert meets_prism(np.array([triangle], float), 0, prism)


def test_a_wall_along_a_slanted_side_does_not_meet():
    prism = make_prism((0, 1), (8, 8), (0, 20, 8, 20))
    wall = [(0, 0, -9), (8, 8, -9), (4, 4, 30)]
    behind = [(4, 2, 0), (8, 6, 0), (8, 7, 8)]
    through = [(4, 2, 0), (8, 6, 0), (2, 4, 8)]
    met = [meets_prism(np.array([face], float), 0, prism) for face in (wall, behind, through)]
    assert met == [False, False, True]
    assert meets_prism(np.array([behind], float), 0, box_prism(bounds_of(prism[None])[0]))


@given(prisms(), st.tuples(corner, corner, corner))
@settings(max_examples=300)
def test_the_side_of_a_plane_is_that_of_all_corners(prism, plane):
    a, u, v = np.array(plane[0]), np.subtract(plane[1], plane[0]), np.subtract(plane[2], plane[0])
    signs = {int(np.sign(np.dot(np.cross(u, v), c - a))) for c in prism.astype(int)}
    side = plane_side(*(tuple(float(x) for x in p) for p in plane), prism)
    assert side == (0 if {1, -1} <= signs or signs == {0} else max(signs, key=abs))


UNIT = 960  # divisible by the denominators below, so that the constructed points are integers
small = st.integers(-6, 6)
little = st.tuples(small, small, small)
weight = st.integers(1, 4)


reaches = st.tuples(weight, weight, st.integers(0, 3))


@given(prisms(), st.tuples(little, little, little), weights, little, reaches)
@settings(max_examples=600)
def test_an_edge_through_a_segment_of_the_shaft_is_never_clear(prism, target, w, along, reach):
    area = np.cross(np.subtract(target[1], target[0]), np.subtract(target[2], target[0]))
    assume(np.any(area) and along != (0, 0, 0))
    target = [[40 + 6 * x, y, z] for x, y, z in target]
    shaft = make_shaft()
    set_shaft(shaft, prism * UNIT, np.array(target, float) * UNIT, 3)
    c = [Fraction(sum(float(x) for x in prism[:, k])) / 8 for k in range(3)]
    t = [Fraction(sum(x * v[k] for x, v in zip(w, target, strict=True)), sum(w)) for k in range(3)]
    x = [a + Fraction(reach[2], 4) * (b - a) for a, b in zip(c, t, strict=True)]
    p, q = ([a + s * d for a, d in zip(x, along, strict=True)] for s in (-reach[0], reach[1]))
    scale = int(np.lcm.reduce([int(a.denominator) for a in (*p, *q)]))
    assume(UNIT % scale == 0)
    ends = [tuple(float(a * UNIT) for a in end) for end in (p, q)]
    assert not clears_edge(shaft, *ends)


@pytest.mark.parametrize(
    "change",
    [
        lambda c: c.__setitem__((3, 2), c[3, 2] + 1),  # a side that is no plane
        lambda c: c.__setitem__((slice(None), 0), c[::-1, 0].copy()),  # turned inside out
        lambda c: c.__setitem__((slice(None), 1), 5),  # flat
    ],
)
def test_other_shapes_are_refused(change):
    corners = make_prism((0, 1), (8, 8), (0, 20, 8, 20)).astype(np.int64)
    check_prisms(corners[None])
    change(corners)
    with pytest.raises(ValueError, match="cells: found cell 0"):
        check_prisms(corners[None])
