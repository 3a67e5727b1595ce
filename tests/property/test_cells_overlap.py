"""The integer tests of triangles against boxes and rectangles, beside clipping with fractions."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from tilesnav_ref.cells.overlap import meets_box, sign_of_dot
from tilesnav_ref.cells.walls import meets_rectangle

Point = tuple[Fraction, Fraction, Fraction]


def clip(polygon: list[Point], axis: int, limit: int, sign: int) -> list[Point]:
    """Part of a convex polygon where sign * (x[axis] - limit) <= 0."""
    kept: list[Point] = []
    for a, b in pairwise([*polygon, polygon[0]] if polygon else []):
        da, db = sign * (a[axis] - limit), sign * (b[axis] - limit)
        if da <= 0:
            kept.append(a)
        if (da < 0 < db) or (db < 0 < da):
            t = da / (da - db)
            kept.append((a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])))
    return kept


def meets_by_clipping(triangle: np.ndarray, low: np.ndarray, high: np.ndarray) -> bool:
    """Whether a triangle meets the relative interior of a box, which may be flat.

    The triangle is clipped by the closed box. The mean of the vertices of what is left satisfies a side
    strictly exactly when one vertex does, hence all sides exactly when some point of the polygon does.
    """
    polygon: list[Point] = [(Fraction(x), Fraction(y), Fraction(z)) for x, y, z in triangle.tolist()]
    for axis in range(3):
        polygon = clip(polygon, axis, int(high[axis]), 1)
        polygon = clip(polygon, axis, int(low[axis]), -1)
    if not polygon:
        return False
    mean = [sum((v[axis] for v in polygon), Fraction(0)) / len(polygon) for axis in range(3)]
    return all(int(low[k]) < mean[k] < int(high[k]) for k in range(3) if low[k] < high[k])


tiny = st.integers(-4, 4)
huge = st.one_of(st.integers(-(2**23) + 1, 2**23 - 1), st.sampled_from([-(2**23) + 1, 2**23 - 1, 0, 1]))


@st.composite
def cases(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A triangle and a box, either small with many contacts or as large as the grid."""
    numbers = draw(st.sampled_from([tiny, tiny, huge]))
    triangle = np.array([[draw(numbers) for _ in range(3)] for _ in range(3)], dtype=np.int64)
    a, b = (np.array([draw(numbers) for _ in range(3)], dtype=np.int64) for _ in range(2))
    assume(np.all(a != b))
    assume(np.any(np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0]) != 0))
    return triangle, np.minimum(a, b), np.maximum(a, b)


@given(cases())
@settings(max_examples=400, deadline=None)
def test_box_test_is_exact(case: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
    triangle, low, high = case
    assert meets_box(triangle, low, high, np.empty(3, np.int64)) == meets_by_clipping(triangle, low, high)


@given(cases(), st.integers(0, 2), st.booleans())
@settings(max_examples=400, deadline=None)
def test_rectangle_test_is_exact(
    case: tuple[np.ndarray, np.ndarray, np.ndarray], axis: int, through_corner: bool
) -> None:
    triangle, low, high = case
    level = triangle[0, axis] if through_corner else low[axis]
    low[axis] = high[axis] = level
    found = meets_rectangle(triangle, low, high, axis, np.empty(3, np.int64))
    assert found == meets_by_clipping(triangle, low, high)


@given(cases(), st.integers(0, 2))
@settings(max_examples=200, deadline=None)
def test_rectangle_in_the_plane_of_the_triangle(
    case: tuple[np.ndarray, np.ndarray, np.ndarray], axis: int
) -> None:
    triangle, low, high = case
    triangle[:, axis] = low[axis] = high[axis] = 7
    assume(np.any(np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0]) != 0))
    found = meets_rectangle(triangle, low, high, axis, np.empty(3, np.int64))
    assert found == meets_by_clipping(triangle, low, high)


wide = st.integers(-(2**51), 2**51)
narrow = st.integers(-(2**25), 2**25)


@given(st.tuples(wide, wide, wide), st.tuples(narrow, narrow, narrow), st.booleans())
@example((2**51, -(2**51), 1), (2**25, 2**25, 1), False)
@example((2**51, -(2**51), -1), (2**25, 2**25, 1), False)
@settings(max_examples=200, deadline=None)
def test_sign_of_a_wide_product(n: tuple[int, int, int], v: tuple[int, int, int], cancel: bool) -> None:
    if cancel:  # two terms that cancel leave the third to decide
        n, v = (n[0], n[0], n[2] % 3 - 1), (v[0], -v[0], v[2])
    exact = sum(a * b for a, b in zip(n, v, strict=True))
    assert sign_of_dot(np.array(n, dtype=np.int64), *(np.int64(x) for x in v)) == (exact > 0) - (exact < 0)


def test_zero_axis_separates_nothing() -> None:
    """An edge along a coordinate axis has a zero cross product with it, which must not separate."""
    triangle = np.array([[-9, 1, 1], [9, 1, 1], [0, 1, 9]])
    assert meets_box(triangle, np.array([0, 0, 0]), np.array([2, 2, 2]), np.empty(3, np.int64))
