"""Polyhedra, clipping, polygons, pairs of boxes: near misses on both sides."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from validator_fixture import box_planes

from tilesnav_validator import broadphase, clipping, polygons, polyhedra

TAU = 2.0**-16
BOX = np.array([box_planes((0, 0, 0), (2, 3, 4))])


def test_vertices_and_facets_of_a_box() -> None:
    shape = polyhedra.build(BOX, TAU)
    assert shape.real.sum() == 8
    assert {tuple(v) for v in shape.corners[0]} == {(x, y, z) for x in (0, 2) for y in (0, 3) for z in (0, 4)}
    assert shape.low.tolist() == [[0, 0, 0]]
    assert shape.high.tolist() == [[2, 3, 4]]
    areas = polyhedra.polygon_area(shape.facet(np.zeros(6, np.int64), np.arange(6)))
    assert areas.tolist() == [12, 12, 8, 8, 6, 6]


def test_facets_of_a_slanted_cell() -> None:
    root = np.sqrt(0.5)
    planes = BOX.copy()
    planes[0, 1] = [
        root,
        0,
        root,
        -4 * root,
    ]  # x + z <= 4: a wedge with vertices at x = 4, z = 0 and x = 0, z = 4
    planes[0, 5] = [0, 0, 1, -3]
    shape = polyhedra.build(planes, TAU)
    area = polyhedra.polygon_area(shape.facet(np.zeros(6, np.int64), np.arange(6)))
    assert area == pytest.approx([9, 3 * 3 * np.sqrt(2), 7.5, 7.5, 12, 3])


@pytest.mark.parametrize("plane", range(6))
def test_a_box_with_a_flipped_or_missing_side_is_unbounded(plane: int) -> None:
    flipped = BOX.copy()
    flipped[0, plane] *= -1
    assert polyhedra.unbounded(flipped).tolist() == [True]
    doubled = BOX.copy()
    doubled[0, plane] = doubled[0, plane ^ 1]
    assert polyhedra.unbounded(doubled).tolist() == [True]
    assert polyhedra.unbounded(BOX).tolist() == [False]


def test_parallel_planes_only_are_unbounded() -> None:
    assert polyhedra.unbounded(np.tile(BOX[:, :2], (1, 3, 1))).tolist() == [True]


def test_a_cone_that_narrows_slowly_is_bounded() -> None:
    angle = 1e-6
    planes = BOX.copy()
    planes[0, 1] = [np.sin(angle), np.cos(angle), 0, -3]
    planes[0, 3] = [np.sin(angle), -np.cos(angle), 0, 0]
    assert polyhedra.unbounded(planes).tolist() == [False]
    planes[0, 1] = [-np.sin(angle), np.cos(angle), 0, -3]
    planes[0, 3] = [0, -1, 0, 0]
    assert polyhedra.unbounded(planes).tolist() == [True]


def test_largest_ball() -> None:
    planes = np.concatenate([BOX, [box_planes((0, 0, 0), (0.5, 3, 4))], [box_planes((1, 0, 0), (0, 3, 4))]])
    assert polyhedra.largest_ball(planes, 2.0, 0.0) == pytest.approx([1, 0.25, -0.5])
    assert polyhedra.holds_ball(planes, 0.25, 1e-12).tolist() == [True, True, False]
    assert polyhedra.holds_ball(planes, 0.25 + 1e-6, 1e-12).tolist() == [True, False, False]


def inside(shape: tuple[float, ...], triangle: list[tuple[float, ...]]) -> bool:
    return bool(
        clipping.meets(np.array([triangle], dtype=float), np.array([box_planes((0, 0, 0), shape)]))[0]
    )


def test_triangles_that_meet_a_box() -> None:
    unit = (1.0, 1.0, 1.0)
    assert inside(unit, [(0.4, 0.4, 0.4), (0.5, 0.4, 0.4), (0.4, 0.5, 0.4)])
    assert inside(unit, [(-9, -9, 0.5), (9, -9, 0.5), (0, 30, 0.5)])  # no corner inside
    assert inside(unit, [(-1, 0.5, 0.5), (2, 0.5, 0.5), (2, 0.5, 0.5)])  # a segment
    assert inside(unit, [(0.5, 0.5, 0.5)] * 3)  # a point
    assert inside(unit, [(1, 1, 1), (2, 1, 1), (1, 2, 1)])  # touches: closed half-spaces
    assert not inside(unit, [(1 + 1e-9, 1, 1), (2, 1, 1), (2, 2, 1)])
    assert not inside(unit, [(2.5, 0, 0.5), (0, 2.5, 0.5), (3, 3, 0.5)])  # past an edge, boxes overlap
    assert inside(unit, [(1.9, 0, 0.5), (0, 1.9, 0.5), (3, 3, 0.5)])


def test_clipping_counts_corners() -> None:
    square = np.array([[(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]], dtype=float)
    corners, count = clipping.clip(square, np.array([4]), np.array([[1.0, 1.0, 0.0, -3.0]]))
    assert count.tolist() == [5]
    assert polyhedra.polygon_area(corners[:, :5]).tolist() == [3.5]
    corners, count = clipping.clip(square, np.array([4]), np.array([[1.0, 0.0, 0.0, 1.0]]))
    assert count.tolist() == [0]


@given(st.lists(st.tuples(*[st.integers(-6, 6)] * 9), min_size=1, max_size=20))
def test_clipping_agrees_with_dense_sampling(rows: list[tuple[int, ...]]) -> None:
    triangles = np.array(rows, dtype=float).reshape(-1, 3, 3) / 4
    planes = np.tile(box_planes((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)), (len(rows), 1, 1))
    grid = [(i / 12, j / 12, (12 - i - j) / 12) for i in range(13) for j in range(13 - i)]
    samples = np.einsum("sc,kci->ksi", np.array(grid), triangles)
    hit = (np.abs(samples) <= 0.5).all(axis=2).any(axis=1)
    assert clipping.meets(triangles, planes)[hit].all()


SQUARE = np.array([[(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]], dtype=float)
UP = np.array([[0.0, 0.0, 1.0]])


def test_order_of_polygons() -> None:
    for corners in (SQUARE, SQUARE[:, ::-1]):
        assert polygons.turns_once(corners, UP, TAU).tolist() == [True]
    crossed = SQUARE[:, [0, 2, 1, 3]]
    assert polygons.turns_once(crossed, UP, TAU).tolist() == [False]
    star = np.array([[(np.cos(a), np.sin(a), 0) for a in np.arange(5) * 4 * np.pi / 5]])
    assert polygons.turns_once(star, UP, TAU).tolist() == [False]
    assert polygons.turns_once(star[:, [0, 3, 1, 4, 2]], UP, TAU).tolist() == [True]
    dented = np.array([[(0, 0, 0), (1, 0.01, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]])
    assert polygons.turns_once(dented, UP, TAU).tolist() == [False]
    dented[0, 1, 1] = 0
    assert polygons.turns_once(dented, UP, TAU).tolist() == [True]


def test_distance_to_a_polygon_is_in_its_plane() -> None:
    points = np.array([[(1, 1, 0), (1, 1, 5), (3, 1, 0), (3, 3, 0), (2, 2, 0), (-1, -1, 7)]], dtype=float)
    for corners in (SQUARE, SQUARE[:, ::-1]):
        found = polygons.distance(points, corners, UP)[0]
        assert found == pytest.approx([0, 0, 1, np.sqrt(2), 0, np.sqrt(2)])


def test_edges_of_length_zero_bound_nothing() -> None:
    corners = SQUARE[:, [0, 1, 1, 2, 3]]
    planes = polygons.edge_planes(corners, UP)
    assert planes[0, 1].tolist() == [0, 0, 0, 0]
    assert polygons.distance(np.array([[(1.0, 1.0, 0.0)]]), corners, UP).tolist() == [[0.0]]


def test_overlaps_are_all_pairs() -> None:
    random = np.random.default_rng(5)
    low_a, low_b = random.uniform(0, 10, (150, 3)), random.uniform(0, 10, (211, 3))
    high_a, high_b = low_a + random.uniform(0, 2, (150, 3)), low_b + random.uniform(0, 2, (211, 3))
    found = set()
    for i, j in broadphase.overlaps(low_a, high_a, low_b, high_b):
        found |= set(zip(i.tolist(), j.tolist(), strict=True))
    hit = (low_a[:, None] <= high_b).all(axis=2) & (low_b <= high_a[:, None]).all(axis=2)
    assert found == set(map(tuple, np.argwhere(hit).tolist()))
    corner, opposite = np.array([[0.0, 0, 0], [9, 9, 9]]), np.array([[5.0, 5, 5]])
    assert list(broadphase.overlaps(corner, corner + 1, opposite, opposite)) == []
    assert list(broadphase.overlaps(low_a[:0], high_a[:0], low_b, high_b)) == []
