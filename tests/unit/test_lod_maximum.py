"""The largest L between a prism and a triangle where it is known or can be sampled."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from tilesnav_ref.cells.model import box_corners
from tilesnav_ref.lod import largest_level
from tilesnav_ref.lod.maximum import proven_bound
from tilesnav_ref.lod.prism import describe_prism

FLOOR = np.array([[-50.0, -50.0, 0.0], [50.0, -50.0, 0.0], [0.0, 70.0, 0.0]])


def span(low: Sequence[float], high: Sequence[float]) -> np.ndarray:
    """Corners (8, 3) of a box."""
    return box_corners(np.array([low], np.float64), np.array([high], np.float64))[0]


def box(x: float, y: float, z: float) -> np.ndarray:
    """Corners (8, 3) of a cube of size 1."""
    return span((x, y, z), (x + 1.0, y + 1.0, z + 1.0))


def wedge(near: float, far: float) -> np.ndarray:
    """Prism over x in 0 to 4 and z in 0 to 2, from y = near at x = 0 and far at x = 4 up to y = 10."""
    corners = span((0.0, 0.0, 0.0), (4.0, 10.0, 2.0))
    corners[[0, 4], 1], corners[[1, 5], 1] = near, far
    return corners


def sampled_maximum(corners: np.ndarray, triangle: np.ndarray, count: int, seed: int = 0) -> float:
    """Largest L over random pairs, many of them on sides, edges and corners."""
    rng = np.random.default_rng(seed)
    places = rng.random((count, 3))
    places = np.where(rng.random((count, 3)) < 0.5, places, np.round(places))
    shares = [np.where((i >> np.arange(3)) & 1, places, 1.0 - places).prod(axis=1) for i in range(8)]
    p = np.stack(shares, axis=1) @ corners
    weights = rng.dirichlet((0.6, 0.6, 0.6), count - 3)
    weights[::2, :] *= np.eye(3)[rng.integers(0, 3, len(weights[::2]))] == 0
    weights = np.concatenate((weights / weights.sum(axis=1, keepdims=True), np.eye(3)))
    x = weights @ triangle
    n = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
    n /= np.linalg.norm(n)
    r = p[:, None] - x[None]
    return float(np.max(np.abs(r @ n) / np.einsum("ijk,ijk->ij", r, r)))


@pytest.mark.parametrize("height", [0.25, 1.0, 2.0, 10.0])
def test_box_over_the_middle_of_a_floor_gives_the_inverse_height(height: float) -> None:
    assert largest_level(box(0, 0, height), FLOOR) == pytest.approx(1 / height, rel=1e-8)
    assert largest_level(box(0, 0, height), FLOOR) >= 1 / height


def test_box_below_counts_as_much_as_a_box_above() -> None:
    assert largest_level(box(0, 0, -3), FLOOR) == pytest.approx(0.5, rel=1e-8)


def test_from_the_side_the_optimum_is_not_the_lowest_point() -> None:
    """A column beside a wall's foot: L = h / (h^2 + a^2) is largest at h = a, where it is 1 / (2 a)."""
    strip = np.array([[0.0, -500.0, 0.0], [0.0, 500.0, 0.0], [-900.0, 0.0, 0.0]])
    low, high = np.array([4.0, -1.0, 0.5]), np.array([5.0, 1.0, 9.0])
    assert largest_level(span(low, high), strip) == pytest.approx(1 / 8, rel=1e-8)


def test_box_across_the_plane_takes_the_better_half() -> None:
    strip = np.array([[0.0, -500.0, 0.0], [0.0, 500.0, 0.0], [-900.0, 0.0, 0.0]])
    low, high = np.array([4.0, -1.0, -2.0]), np.array([5.0, 1.0, 3.0])
    assert largest_level(span(low, high), strip) == pytest.approx(3 / 25, rel=1e-8)  # h = 3, a = 4
    assert largest_level(span(low, high), strip * [1, 1, -1]) == pytest.approx(3 / 25, rel=1e-8)
    mirrored = np.array([4.0, -1.0, -3.0]), np.array([5.0, 1.0, 2.0])
    assert largest_level(span(*mirrored), strip) == pytest.approx(3 / 25, rel=1e-8)


def test_side_in_the_plane_without_contact_is_finite() -> None:
    low, high = np.array([60.0, 0.0, 0.0]), np.array([61.0, 1.0, 1.0])
    value = largest_level(span(low, high), FLOOR)
    assert 0 < value < 0.1
    assert value >= sampled_maximum(span(low, high), FLOOR, 300)


def test_corner_in_a_tilted_plane_is_finite_and_near() -> None:
    """Rounding of a tilted normal lifts the touching corner over the plane by 1e-16 or so."""
    triangle = np.array([[0.0, 0.0, 0.0], [3.0, 1.0, 1.0], [1.0, 3.0, 2.0]])
    for k in range(5, 40):
        corner = triangle[0] + k * (triangle[1] - triangle[0])
        n = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
        low = np.where(n > 0, corner, corner - 1.0)
        high = low + 1.0
        value = largest_level(span(low, high), triangle)
        assert sampled_maximum(span(low, high), triangle, 200) <= value <= 1.0 / (3.0 * (k - 3))


@pytest.mark.parametrize(
    "low",
    [(0.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 0.0, -0.5), (50.0, -51.0, 0.0), (0.0, 70.0, -1.0)],
    ids=["side above", "side below", "pierced", "corner", "edge"],
)
def test_contact_gives_infinity(low: tuple[float, float, float]) -> None:
    assert largest_level(box(*low), FLOOR) == math.inf


def test_degenerate_triangle_gives_zero() -> None:
    line = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [2.0, 2.0, 0.0]])
    assert largest_level(box(0, 0, 1), line) == 0.0


def test_any_direction_proves_a_bound() -> None:
    corners = box(2, 1, 3)
    corners[[1, 5], 1] -= 0.5
    triangle = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 1.0, 0.25]])
    n = np.cross(triangle[1], triangle[2])
    n /= np.linalg.norm(n)
    truth = sampled_maximum(corners, triangle, 400)
    prism = describe_prism(corners, 1.0)
    bounds = [proven_bound(prism, triangle, n, u) for u in np.random.default_rng(0).normal(size=(500, 3))]
    assert min(bounds) >= truth
    assert min(bounds) < 1.1 * truth
    assert max(bounds) == math.inf


def test_billboard_of_a_hundred_triangles_against_dense_samples() -> None:
    """The picture of a billboard near a small cell: the near end is the finest, the far one the coarsest."""
    x, z = np.linspace(0.0, 10.0, 11), np.linspace(2.0, 7.0, 6)
    low, high = np.array([0.5, 0.6, 1.0]), np.array([1.5, 1.6, 2.0])
    values = []
    for i in range(10):
        for k in range(5):
            a, b = (x[i], 0.0, z[k]), (x[i + 1], 0.0, z[k])
            c, d = (x[i + 1], 0.0, z[k + 1]), (x[i], 0.0, z[k + 1])
            for triangle in (np.array([a, b, c]), np.array([a, c, d])):
                value, sample = (
                    largest_level(span(low, high), triangle),
                    sampled_maximum(span(low, high), triangle, 600),
                )
                assert sample <= value <= 1.15 * sample
                values.append((i, value))
    by_column = [max(value for column, value in values if column == i) for i in range(10)]
    assert len(values) == 100
    assert by_column[2:] == sorted(by_column[2:], reverse=True)
    assert max(by_column) == pytest.approx(1 / 0.6, rel=1e-8)


@pytest.mark.parametrize("gap", [0.25, 1.0, 7.0])
def test_slanted_side_along_a_wall_gives_the_inverse_distance(gap: float) -> None:
    """The wall is 3 x = 4 y moved back by a gap; the box around the prism runs through it."""
    normal = np.array([3.0, -4.0, 0.0]) / 5.0
    along = np.array([4.0, 3.0, 0.0])
    wall = np.array([-9.0 * along - [0, 0, 9], 9.0 * along - [0, 0, 9], [0.0, 0.0, 9.0]]) + gap * normal
    value = largest_level(wedge(0.0, 3.0), wall)
    assert value == pytest.approx(1 / gap, rel=1e-8)
    assert value >= 1 / gap
    around = largest_level(span((0.0, 0.0, 0.0), (4.0, 10.0, 2.0)), wall)
    assert (around == math.inf) == (gap < 2.4)  # the distance of the corner that is cut off


@pytest.mark.parametrize(
    "triangle",
    [
        [[2.0, 1.5, 1.0], [5.0, -9.0, 0.0], [2.0, -9.0, 5.0]],
        [[0.0, 0.0, 0.0], [4.0, 3.0, 0.0], [2.0, -3.0, -1.0]],
        [[2.0, 1.5, -2.0], [2.0, 1.5, 4.0], [9.0, 0.0, 1.0]],
        [[1.0, -2.0, 1.0], [1.0, 9.0, 1.0], [2.0, -2.0, 2.0]],
    ],
    ids=["vertex on the slanted side", "along a slanted edge", "edge across the side", "pierced"],
)
def test_contact_with_a_slanted_side_gives_infinity(triangle: list[list[float]]) -> None:
    assert largest_level(wedge(0.0, 3.0), np.array(triangle)) == math.inf


def test_nearness_to_the_box_around_does_not_count() -> None:
    """A triangle in the corner that the slanted side cuts off, next to none of the prism."""
    triangle = np.array([[3.75, 0.25, 0.5], [4.0, 0.25, 0.5], [4.0, 0.25, 1.0]])
    value = largest_level(wedge(0.0, 3.0), triangle)
    sample = sampled_maximum(wedge(0.0, 3.0), triangle, 1500)
    assert sample <= value <= 1.02 * sample
    assert value < 0.6


def test_trapezoid_with_a_side_of_no_length_is_a_prism_too() -> None:
    triangle = np.array([[5.0, 9.0, -1.0], [6.0, 9.0, 3.0], [5.5, 12.0, 1.0]])
    value, sample = largest_level(wedge(0.0, 10.0), triangle), 0.0
    for seed in range(4):
        sample = max(sample, sampled_maximum(wedge(0.0, 10.0), triangle, 1500, seed))
    assert sample <= value <= 1.05 * sample


TWICE = wedge(0.0, 3.0)
TWICE[[4, 5], 1] += 1.0


@pytest.mark.parametrize(
    ("corners", "triangle", "message"),
    [
        (np.zeros((8, 2)), FLOOR, "shapes"),
        (box(0, 0, 0), FLOOR[:2], "shapes"),
        (span((0, 0, 0), (1, 1, 0)), FLOOR, "upper side of axis 2"),
        (box(0, 0, 0)[::-1], FLOOR, "upper side of axis 0"),
        (wedge(0.0, 11.0), FLOOR, "upper side of axis 1"),
        (TWICE, FLOOR, "along 2 foreign axes"),
        (span((0, 0, np.nan), (1, 1, 1)), FLOOR, "finite"),
        (box(0, 0, 0), np.full((3, 3), np.inf), "finite"),
    ],
)
def test_bad_input_is_refused(corners: np.ndarray, triangle: np.ndarray, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        largest_level(corners, triangle)
