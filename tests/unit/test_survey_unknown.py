"""No cell is placed in space that a survey says nothing about."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from survey_fixture import site_from_above

from tilesnav_ref.cells import CellComplex, CellError, CellSettings, decompose
from tilesnav_ref.scene import Scene, SceneSettings, Soup, build_scene
from tilesnav_ref.scene.unknown import UnknownSpace
from tilesnav_ref.survey.beams import unknown_beside_beams
from tilesnav_ref.survey.columns import unknown_below

M = 1024
BLOCKS = UnknownSpace(
    (np.array([0, 10, 20]), np.array([0, 10]), np.array([0, 10, 30])),
    np.array([[[True, False]], [[False, False]]]),
    open_above=True,
)


def ground(size: float = 40.0) -> Scene:
    """Two triangles."""
    side = round(size * M)
    vertices = np.array([[0, 0, 0], [side, 0, 0], [side, side, 0], [0, side, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    return build_scene(Soup(vertices, faces, np.zeros(2, np.int64), ("ground",)), SceneSettings()).scene


@pytest.fixture(scope="module")
def site() -> tuple[Scene, np.ndarray]:
    """The ground with what the survey of the site leaves unknown, and the returns."""
    scene, returns = ground(), np.round(site_from_above() * M).astype(np.int64)
    bounds = np.stack((scene.vertices.min(axis=0), scene.vertices.max(axis=0)))
    return replace(scene, unknown=unknown_below(returns, bounds, M, M // 4)), returns


def points_in(cells: CellComplex, seed: int = 0) -> np.ndarray:
    """Random points of every cell, grid steps rounded down."""
    weights = np.random.default_rng(seed).dirichlet(np.ones(8), (cells.count, 200))
    return np.floor(weights @ cells.corners.astype(np.float64)).reshape(-1, 3).astype(np.int64)


def test_blocks_hold_their_points_and_what_is_around_them() -> None:
    points = np.array([[5, 5, 5], [15, 5, 5], [5, 5, 20], [-1, 5, 5], [25, 5, 5], [5, 5, 99], [5, 5, -1]])
    assert BLOCKS.holds(points).tolist() == [True, False, False, True, True, False, True]
    closed = replace(BLOCKS, open_above=False)
    assert closed.holds(points)[5]
    lattice = BLOCKS.holds_lattice((points[:2, 0], points[:1, 1], points[:1, 2]))
    assert lattice.reshape(-1).tolist() == [True, False]


def test_points_between_grid_steps_are_told_apart() -> None:
    assert BLOCKS.holds(np.array([[79, 40, 40], [81, 40, 40]]), parts=8).tolist() == [True, False]


def test_the_border_separates_and_has_no_other_triangle() -> None:
    border = BLOCKS.border()
    areas = np.linalg.norm(np.cross(border[:, 1] - border[:, 0], border[:, 2] - border[:, 0]), axis=1) / 2
    # top and side of the unknown block; around: both ends along y and x, and below, of what is known
    assert areas.sum() == 100 + 100 + 2 * (400 + 100) + 10 * 20 + 10 * 30 + 100
    assert (border.min(axis=(0, 1)) >= [0, 0, 0]).all()


def test_blocks_that_do_not_fit_their_cuts_are_refused() -> None:
    with pytest.raises(ValueError, match="blocks between"):
        UnknownSpace(BLOCKS.cuts, BLOCKS.unknown[:1], True)


def test_below_the_highest_return_of_a_column_nothing_is_known(site: tuple[Scene, np.ndarray]) -> None:
    scene, returns = site
    unknown = scene.unknown
    assert unknown is not None
    assert unknown.holds(returns - [0, 0, 1]).all()
    under_tree, above_tree = np.array([[30, 30, 2]]) * M, np.array([[30, 30, 9]]) * M
    assert unknown.holds(under_tree).all()
    assert not unknown.holds(above_tree).any()
    assert not unknown.holds(np.array([[5.5, 5.5, 0.6]]) * M).any()
    assert 0.02 < unknown.share() < 0.3


def test_a_column_without_a_return_is_unknown_up_to_the_sky() -> None:
    scene = ground()
    returns = np.round(site_from_above() * M).astype(np.int64)
    hole = ((returns[:, :2] > 4 * M) & (returns[:, :2] < 8 * M)).all(axis=1)
    bounds = np.stack((scene.vertices.min(axis=0), scene.vertices.max(axis=0)))
    unknown = unknown_below(returns[~hole], bounds, M, M // 4)
    cells = decompose(replace(scene, unknown=unknown), CellSettings(min_size=2, max_size=8))
    inside = points_in(cells)
    assert not ((inside[:, :2] > 5 * M) & (inside[:, :2] < 7 * M)).all(axis=1).any()
    assert cells.count > 0


@pytest.mark.parametrize("method", ["prisms", "boxes", "voxel"])
@pytest.mark.parametrize("clearance", [0.0, 0.25])
def test_no_cell_overlaps_unknown_space(
    site: tuple[Scene, np.ndarray], method: str, clearance: float
) -> None:
    scene, returns = site
    settings = CellSettings(
        min_size=2, max_size=8, method=method, clearance=clearance, keep_interiors=True, coverage_points=2000
    )
    cells = decompose(scene, settings)
    assert cells.count > 10
    assert scene.unknown is not None
    assert not scene.unknown.holds(points_in(cells)).any()
    low, high = cells.corners.min(axis=1), cells.corners.max(axis=1)
    for a, b in zip(low, high, strict=True):
        below = ((returns[:, :2] > a[:2]) & (returns[:, :2] < b[:2])).all(axis=1)
        if method != "prisms" and below.any():
            assert returns[below, 2].max() <= a[2]


def test_the_same_scene_without_unknown_space_has_cells_there(site: tuple[Scene, np.ndarray]) -> None:
    """What the test above would miss if nothing were asked."""
    scene, _ = site
    free = decompose(replace(scene, unknown=None), CellSettings(min_size=2, max_size=8))
    assert scene.unknown is not None
    assert scene.unknown.holds(points_in(free)).any()


def test_borders_of_unknown_space_carry_no_vehicle(site: tuple[Scene, np.ndarray]) -> None:
    """Above the roof of the house no face is near, only the top of what is unknown."""
    scene, _ = site
    cells = decompose(scene, CellSettings(min_size=2, max_size=8, altitude_max=16.0))
    low, high = cells.corners.min(axis=1) / M, cells.corners.max(axis=1) / M
    over = ((low[:, :2] < 20.0) & (high[:, :2] > 10.0)).all(axis=1) & (low[:, 2] > 6.0) & (low[:, 2] < 8.9)
    assert over.any()
    assert (cells.kinds[over] == 0).all()
    assert (cells.kinds == 1).any()


def test_only_what_beams_have_crossed_is_free() -> None:
    """A scanner in the middle of a room of 10 m, that looks at one half of it."""
    rng = np.random.default_rng(3)
    angles, rise = rng.random(200_000) * np.pi - np.pi / 2, rng.random(200_000) * 2.0 - 1.0
    ends = np.column_stack((np.cos(angles), np.sin(angles), 0.6 * rise)) * 4.9
    origins = np.zeros((200_000, 3))
    bounds = np.array([[-5, -5, -2], [5, 5, 2]]) * M
    unknown = unknown_beside_beams(
        np.round(origins * M).astype(np.int64), np.round(ends * M).astype(np.int64), bounds, M // 2
    )
    ask = np.round(np.array([[2.2, 0.3, 0.1], [-2.2, 0.3, 0.1], [0.3, 0.3, 1.8], [4.95, 0.0, 0.0]]) * M)
    assert unknown.holds(ask.astype(np.int64)).tolist() == [False, True, True, True]
    assert not unknown.open_above
    scene = replace(ground(), unknown=unknown)
    scene = replace(scene, vertices=scene.vertices - [20 * M, 20 * M, 3 * M])
    cells = decompose(scene, CellSettings(min_size=1, max_size=4, coverage_points=2000))
    assert cells.count > 0
    assert not unknown.holds(points_in(cells)).any()
    assert (cells.corners[:, :, 0] >= -M // 2).all()


def test_without_any_known_space_there_is_no_cell() -> None:
    blocks = UnknownSpace(BLOCKS.cuts, np.ones((2, 1, 2), np.bool_), open_above=False)
    with pytest.raises(CellError, match="no free space"):
        decompose(replace(ground(), unknown=blocks), CellSettings(min_size=2, max_size=8))
