"""Condition (1): an edge is called clear only when no segment of the shaft meets it."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tilesnav_ref.visibility.prisms import box_prism
from tilesnav_ref.visibility.shaft import clears_edge, make_shaft, set_shaft

UNIT = 960  # divisible by the denominators below, so that the constructed points are integers
small = st.integers(-6, 6)
corner = st.tuples(small, small, small)
weight = st.integers(1, 4)
side = st.integers(1, 5)


def shaft_of(low, size, target):
    shaft = make_shaft()
    box = np.array([low, np.add(low, size)], float) * UNIT
    set_shaft(shaft, box_prism(box), np.array(target, float) * UNIT, len(target))
    return shaft


def inside_box(low, size, w):
    return [Fraction(lo) + Fraction(s * x, 5) for lo, s, x in zip(low, size, w, strict=True)]


def inside(corners, w):
    total = sum(w)
    return [sum(Fraction(c[k]) * x for c, x in zip(corners, w, strict=True)) / total for k in range(3)]


def as_units(p):
    """Round to the fine grid only when exact; otherwise None."""
    scaled = [x * UNIT for x in p]
    return tuple(float(x) for x in scaled) if all(x.denominator == 1 for x in scaled) else None


shafts = st.tuples(corner, st.tuples(side, side, side), st.tuples(corner, corner, corner))
barycentric = st.sampled_from([(1, 1, 2), (2, 1, 1), (1, 2, 1), (2, 3, 5), (1, 1, 8)])
ends = st.tuples(st.tuples(weight, weight, weight), barycentric, st.integers(0, 3))


@given(shafts, ends, corner, st.tuples(weight, weight))
@settings(max_examples=800)
def test_an_edge_through_a_segment_of_the_shaft_is_never_clear(shape, segment, along, reach):
    low, size, target = shape
    w, v, s = segment
    u = np.cross(np.subtract(target[1], target[0]), np.subtract(target[2], target[0]))
    if not np.any(u) or along == (0, 0, 0):
        return
    c, t = inside_box(low, size, w), inside(target, v)
    x = [a + Fraction(s, 4) * (b - a) for a, b in zip(c, t, strict=True)]  # on [c, t)
    p = as_units([a - reach[0] * d for a, d in zip(x, along, strict=True)])
    q = as_units([a + reach[1] * d for a, d in zip(x, along, strict=True)])
    if p is None or q is None:
        return
    assert not clears_edge(shaft_of(low, size, target), p, q)


CELL = ((0, 0, 0), (2, 2, 2))
TARGET = ((10, -1, 0), (10, 3, 0), (10, 1, 4))


@pytest.mark.parametrize(
    ("p", "q", "clear"),
    [
        ((5, -9, 1), (5, 9, 1), False),  # across the shaft
        ((5, -9, 9), (5, 9, 9), True),  # above it
        ((5, -9, 0), (5, 9, 0), True),  # along its floor: weakly outside
        ((10, -1, 0), (10, 3, 0), True),  # the target's own edge
        ((11, -9, 1), (11, 9, 1), True),  # behind the target
        ((10, -9, 1), (10, 9, 1), True),  # in the target's plane
        ((0, -9, 1), (0, 9, 1), True),  # along the cell's back
        ((5, 1, 1), (5, 30, 1), False),  # begins inside
        ((5, 2, -9), (5, 2, 9), False),  # inside near the border: the shaft is wider here
        ((5, 3, -9), (5, 3, 9), True),  # past it: both flanks lean inwards
    ],
)
def test_edges_about_a_plain_shaft(p, q, clear):
    shaft = shaft_of(CELL[0], (2, 2, 2), TARGET)
    assert clears_edge(shaft, tuple(UNIT * float(x) for x in p), tuple(UNIT * float(x) for x in q)) == clear


def test_a_box_target_widens_the_shaft():
    shaft = make_shaft()
    box = np.array([[10 + i % 2, -3 + 8 * (i // 2 % 2), 4 * (i // 4)] for i in range(8)], float)
    set_shaft(shaft, box_prism(np.array([[0, 0, 0], [2, 2, 2]], float)), box, 8)
    assert not clears_edge(shaft, (5.0, 3.0, -9.0), (5.0, 3.0, 9.0))
    assert clears_edge(shaft, (5.0, -9.0, 9.0), (5.0, 9.0, 9.0))
