"""Distances of points, pieces and surfaces, against another program and against known values."""

from __future__ import annotations

import numpy as np
import pytest
from levels_reference import farthest, lattice
from trimesh.triangles import closest_point

from tilesnav_ref.levels.deviation import LOOSE, bound_distance, near_pairs
from tilesnav_ref.levels.nearest import squared_distance
from tilesnav_ref.levels.pieces import CORNERS, cut

SQUARE = np.array([[[0, 0, 0], [8, 0, 0], [8, 8, 0]], [[0, 0, 0], [8, 8, 0], [0, 8, 0]]], float)


def test_distance_of_a_point_agrees_with_another_program() -> None:
    random = np.random.default_rng(1)
    triangles, points = random.normal(size=(400, 3, 3)), 2 * random.normal(size=(400, 3))
    found = [squared_distance(t, p) ** 0.5 for t, p in zip(triangles, points, strict=True)]
    expected = np.linalg.norm(points - closest_point(triangles, points), axis=1)
    assert np.allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("point", [(0.0, 3.0, 4.0), (7.0, 3.0, 4.0), (-4.0, 3.0, 0.0)])
def test_distance_of_a_triangle_without_area_is_not_too_small(point: tuple[float, float, float]) -> None:
    for corners in ([[0, 0, 0], [4, 0, 0], [2, 0, 0]], [[1, 0, 0]] * 3):
        line = np.linspace(min(c[0] for c in corners), max(c[0] for c in corners), 401)
        least = min((x - point[0]) ** 2 + point[1] ** 2 + point[2] ** 2 for x in line)
        assert squared_distance(np.array(corners, float), np.array(point)) >= least - 1e-9


def test_a_cut_loses_no_area() -> None:
    random = np.random.default_rng(2)
    for _ in range(50):
        piece = random.normal(size=(3, 2)) @ random.normal(size=(2, 3))
        values = random.normal(size=3)
        areas = []
        for sign in (1.0, -1.0):
            part = np.empty((CORNERS, 3))
            size = cut(piece, values, sign, part)
            fan = [np.cross(part[i] - part[0], part[i + 1] - part[0]) for i in range(1, size - 1)]
            areas.append(np.linalg.norm(np.sum(fan, axis=0)) if fan else 0.0)
        whole = np.linalg.norm(np.cross(piece[1] - piece[0], piece[2] - piece[0]))
        assert np.isclose(sum(areas), whole)


def test_a_distance_that_no_corner_has_is_found() -> None:
    """Both ends of a long face touch others; its middle is 50 away from both."""
    long = np.array([[[-50, 0, 0], [50, 0, 0], [0, 1, 0]]], float)
    posts = np.array([[[x, 0, 0], [x, 0, 9], [x, 9, 9]] for x in (-50, 50)], float)
    bound = bound_distance(long, posts, 1e-3)
    assert 50.0 <= bound <= LOOSE * 50.02


def test_a_part_that_sticks_out_is_found() -> None:
    over = np.array([[[0, 0, 3], [20, 0, 3], [0, 8, 3]]], float)
    expected = np.hypot(12, 3)
    assert expected <= bound_distance(over, SQUARE, 1e-3) <= LOOSE * expected
    assert 3.0 <= bound_distance(over[:, :, :] * (0.3, 1, 1), SQUARE, 1e-3) <= LOOSE * 3.0


def test_the_same_surface_divided_otherwise_is_at_distance_0() -> None:
    other = np.array([[[0, 0, 0], [8, 0, 0], [0, 8, 0]], [[8, 0, 0], [8, 8, 0], [0, 8, 0]]], float)
    assert bound_distance(SQUARE, other, 1e-6) <= 1e-6
    pairs = near_pairs(SQUARE, other, 1e-6)
    assert sorted(map(tuple, pairs.tolist())) == [(0, 0), (0, 1), (1, 0), (1, 1)]


def test_bounds_of_random_soups_hold_and_are_tight() -> None:
    random = np.random.default_rng(3)
    for _ in range(12):
        one, other = random.integers(-40, 40, (5, 3, 3)) * 1.0, random.integers(-40, 40, (4, 3, 3)) * 1.0
        bound = bound_distance(one, other, 0.1)
        seen = max(farthest(triangle, other, 24) for triangle in one)
        assert seen <= bound + 1e-9
        assert bound <= LOOSE * seen + 4  # a step of the lattice
        pairs = near_pairs(one, other, bound)
        assert len(np.unique(pairs, axis=0)) == len(pairs)
        for number, triangle in enumerate(one):
            chosen = other[pairs[pairs[:, 0] == number, 1]]
            assert farthest(triangle, chosen, 12) <= bound + 1e-9


def test_the_lattice_of_the_reference_has_the_corners() -> None:
    assert {(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)} <= set(map(tuple, lattice(4).tolist()))
