"""Condition (2): occluders keep off the target and the cell."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from visibility_reference import cross, dot, half_open_meets, in_triangle, minus, point

from tilesnav_ref.visibility.contact import meets_box, meets_prism, meets_relative_interior
from tilesnav_ref.visibility.prisms import box_prism

small = st.integers(0, 4)
corner = st.tuples(small, small, small)
triangle = st.tuples(corner, corner, corner).filter(
    lambda t: bool(np.any(np.cross(np.subtract(t[1], t[0]), np.subtract(t[2], t[0]))))
)
weights = st.tuples(st.integers(1, 6), st.integers(1, 6), st.integers(1, 6))


def mix(corners, w):
    total = sum(w)
    return tuple(sum(point(c)[k] * x for c, x in zip(corners, w, strict=True)) / total for k in range(3))


def on_face(p, corners):
    corners = [point(c) for c in corners]
    normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]))
    return dot(normal, minus(p, corners[0])) == 0 and in_triangle(p, corners)


@given(triangle, triangle, weights)
@settings(max_examples=600)
def test_a_common_point_inside_the_target_is_never_overlooked(face, target, w):
    if on_face(mix(target, w), face):
        assert meets_relative_interior(np.array([face, target], float), 0, 1)


@given(triangle, triangle)
@settings(max_examples=600)
def test_an_edge_that_pierces_the_target_is_never_overlooked(face, target):
    corners = [point(c) for c in target]
    normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]))
    for k in range(3):
        p, q = point(face[k]), point(face[(k + 1) % 3])
        at_p, at_q = dot(normal, minus(p, corners[0])), dot(normal, minus(q, corners[0]))
        if at_p * at_q < 0:
            s = at_p / (at_p - at_q)
            hit = tuple(a + s * (b - a) for a, b in zip(p, q, strict=True))
            inside = all(
                dot(normal, cross(minus(corners[(i + 1) % 3], corners[i]), minus(hit, corners[i]))) > 0
                for i in range(3)
            )
            if inside:
                assert half_open_meets(p, q, corners)
                assert meets_relative_interior(np.array([face, target], float), 0, 1)


TARGET = [(0, 0, 0), (8, 0, 0), (0, 8, 0)]


@pytest.mark.parametrize(
    ("face", "meets"),
    [
        ([(0, 0, 0), (8, 0, 0), (0, 0, 8)], False),  # shares an edge
        ([(2, 0, 0), (6, 0, 0), (0, 0, 8)], False),  # stands on the edge
        ([(0, 0, 0), (-3, -3, 5), (-3, 0, 5)], False),  # shares a vertex
        ([(2, 2, 0), (3, 3, 5), (2, 3, 5)], True),  # a vertex inside
        ([(1, 1, 0), (3, 3, 0), (2, 2, 5)], True),  # an edge inside
        ([(-1, -1, 0), (9, 9, 0), (0, 0, 5)], True),  # an edge across
        ([(2, 2, -1), (3, 3, 5), (2, 3, 5)], True),  # pierces
        ([(2, 2, 1), (3, 3, 5), (2, 3, 5)], False),  # above
        ([(8, 0, 0), (8, 8, 0), (0, 8, 0)], False),  # coplanar neighbour
        ([(0, 0, 0), (8, 0, 0), (0, 8, 0)], True),  # doubled
        ([(1, 1, 0), (9, 1, 0), (1, 9, 0)], True),  # coplanar overlap
        ([(20, 0, -4), (20, 9, -4), (20, 0, 9)], False),  # far away
        ([(5, 5, -4), (5, 5, 4), (20, 20, 0)], False),  # crosses the plane outside the target
    ],
)
def test_contact_of_each_kind(face, meets):
    assert meets_relative_interior(np.array([face, TARGET], float), 0, 1) == meets


@given(triangle, corner, st.tuples(st.integers(1, 4), st.integers(1, 4), st.integers(1, 4)), weights)
@settings(max_examples=400)
def test_a_point_of_a_face_in_a_box_is_never_overlooked(face, low, size, w):
    lower, upper = np.array(low, float), np.add(low, size).astype(float)
    box = np.stack([lower, upper])
    p = mix(face, w)
    corners = np.array([face], float)
    if all(lo < x < up for x, lo, up in zip(p, lower, upper, strict=True)):
        assert meets_prism(corners, 0, box_prism(box))
    if all(lo <= x <= up for x, lo, up in zip(p, lower, upper, strict=True)):
        assert meets_box(corners, 0, box)


def test_a_box_may_rest_against_a_wall():
    wall = np.array([[(0, -9, -9), (0, 9, -9), (0, 0, 9)]], float)
    box = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
    assert not meets_prism(wall, 0, box_prism(box))
    assert meets_box(wall, 0, box)


def test_a_sliver_whose_normal_vanishes_in_floating_point_still_meets_its_twin():
    sliver = [(0, 0, 0), (267914296, 165580141, 0), (165580141, 102334155, 0)]  # Fibonacci numbers: area 1/2
    assert meets_relative_interior(np.array([sliver, sliver], float), 0, 1)
