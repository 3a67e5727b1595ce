"""The billboard of the paper's figure 8: L in closed form, sampled, and by the rule of the paper."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from test_lod_maximum import sampled_maximum

from tilesnav_ref.lod import LodSettings, largest_level
from tilesnav_ref.lod.codes import level_codes

PROGRAM = Path(__file__).resolve().parents[2] / "benchmarks" / "billboard.py"


@pytest.fixture(scope="module")
def program() -> ModuleType:
    spec = importlib.util.spec_from_file_location("billboard", PROGRAM)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def distance(square: np.ndarray, triangle: np.ndarray) -> float:
    """Distance of two convex polygons in the plane, each a ring of corners in counterclockwise order."""

    def outside(ring: np.ndarray, points: np.ndarray) -> bool:
        """Whether a side of the ring has all points on its outer side."""
        sides = np.roll(ring, -1, axis=0) - ring
        to = points[None] - ring[:, None]
        return bool(np.any(np.all(sides[:, None, 0] * to[:, :, 1] - sides[:, None, 1] * to[:, :, 0] <= 0, 1)))

    def nearest(ring: np.ndarray, points: np.ndarray) -> float:
        sides = np.roll(ring, -1, axis=0) - ring
        to = points[:, None] - ring[None]
        along = np.clip((to * sides).sum(-1) / (sides * sides).sum(-1), 0, 1)
        return float(np.linalg.norm(to - along[:, :, None] * sides, axis=-1).min())

    if not (outside(square, triangle) or outside(triangle, square)):
        return 0.0
    return min(nearest(square, triangle), nearest(triangle, square))


def known(heights: tuple[float, float], away: float) -> float:
    """Largest h / (h^2 + a^2) over the heights: at h = a where that is one of them, else at an end."""
    return max(h / (h * h + away * away) for h in (*heights, min(max(away, heights[0]), heights[1])))


def footprint(corners: np.ndarray) -> np.ndarray:
    """Ring of the cell as seen from its front, x and z."""
    (x0, z0), (x1, z1) = corners[:, [0, 2]].min(axis=0), corners[:, [0, 2]].max(axis=0)
    return np.array(((x0, z0), (x1, z0), (x1, z1), (x0, z1)))


@pytest.mark.parametrize("size", [0.5, 2.0, 4.0])
def test_exact_values_are_those_of_the_plane_distance(program: ModuleType, size: float) -> None:
    """In one plane L depends on the distance within the plane alone, so it is known for the board."""
    corners = program.cell(size)
    heights = (-corners[:, 1].max(), -corners[:, 1].min())
    away = [distance(footprint(corners), triangle[:, [0, 2]]) for triangle in program.board()]
    exact = np.array([largest_level(corners, triangle) for triangle in program.board()])
    expected = np.array([known(heights, one) for one in away])
    assert exact == pytest.approx(expected, rel=1e-8)
    assert np.all(exact >= expected * (1 - 1e-15))
    # Red near, blue far: farther triangles never have a larger value.
    assert np.all(np.diff(exact[np.argsort(away, kind="stable")]) <= 1e-8 * exact.max())
    assert exact.argmax() in np.flatnonzero(np.array(away) == min(away))


def test_figure_has_a_hundred_triangles_over_two_decades(program: ModuleType) -> None:
    triangles = np.concatenate((program.board(), program.pedestal()))
    assert len(triangles) == 108
    exact, _ = program.both(triangles, program.cell())
    assert exact.max() == pytest.approx(1 / program.GAP, rel=1e-8)
    assert exact.max() / exact.min() > 100


def test_exact_is_never_below_dense_samples_nor_the_rule(program: ModuleType) -> None:
    corners = program.cell()
    triangles = np.concatenate((program.board(), program.pedestal()))
    exact, sampled = program.both(triangles, corners)
    dense = np.array([sampled_maximum(corners, triangle, 400, seed=8) for triangle in triangles])
    assert np.all(exact >= dense)
    assert np.all(exact >= sampled)
    assert np.median(exact / dense) < 1.01


def test_the_rule_of_the_paper_is_below_the_exact_value(program: ModuleType) -> None:
    """Beside the nearest square by two fifths; from a cell of 4 m, so far that levels get too coarse."""
    exact, sampled = program.both(program.board(), program.cell())
    assert (exact / sampled).max() == pytest.approx(np.sqrt(2), rel=0.01)
    assert np.count_nonzero(exact > 1.05 * sampled) >= 6
    exact, sampled = program.both(program.board(), program.cell(4.0))
    assert (exact / sampled).max() > 10
    coarser = level_codes(sampled, LodSettings()) > level_codes(exact, LodSettings())
    assert np.count_nonzero(coarser) > 20


def test_smaller_triangles_do_not_mend_the_rule(program: ModuleType) -> None:
    """They help with the triangles, not with the cell, which has samples at its corners only."""
    corners = program.cell()
    near = np.array((1.0, 0.0, 4.5)) + np.array(((0, 0, 0), (1, 0, 0), (1, 0, 1))) * 2.0**-9
    exact, sampled = largest_level(corners, near), program.sampled_rule(corners, near)
    # From the middle of the cell's front 1 / h, from its corners h / (h^2 + 2 * 0.25^2).
    assert exact == pytest.approx(1 / program.GAP, rel=1e-8)
    h = program.GAP
    assert exact / sampled == pytest.approx((h * h + 2 * 0.25**2) / (h * h), rel=0.01)


def test_triangles_of_the_scene_are_sound(program: ModuleType) -> None:
    for triangles, area in ((program.board(), 49.0), (program.board(3), 49.0), (program.pedestal(), 10.0)):
        crosses = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        assert np.linalg.norm(crosses, axis=1).sum() / 2 == pytest.approx(area)
