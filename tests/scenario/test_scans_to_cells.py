"""From a simulated scan with poses to cells that hold nothing of what is truly there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mission_scenes import box_faces, rectangle, scene_of

from tilesnav_ref.cells import CellSettings, decompose, planes
from tilesnav_ref.cli import main
from tilesnav_ref.scene import Scene, SceneSettings, write_mesh
from tilesnav_ref.survey import SurveySettings, open_scene

pytest.importorskip("shapely", reason="point clouds are an extra")

BOUND = 0.03
"""Metres that a true face may reach into a cell: a standard deviation of the ranges."""
ROUTE = "-8,-8,1.5 8,-8,1.5 8,8,1.5 -8,8,1.5 -8,-7,1.5"


def courtyard() -> Scene:
    """Ground within walls 4 m high, a shed, a pillar, and a thin wall that stands across no axis."""
    thin = np.array([[3, 2, 0], [6, 5, 0], [6, 5, 3], [3, 2, 3]], np.float64)
    return scene_of(
        rectangle((-12, 12), (-12, 12), (0, 0)),
        box_faces((-12, -12, 0), (-11, 12, 4)),
        box_faces((11, -12, 0), (12, 12, 4)),
        box_faces((-11, -12, 0), (11, -11, 4)),
        box_faces((-11, 11, 0), (11, 12, 4)),
        box_faces((-5, -4, 0), (0, 3, 3)),
        box_faces((3.0, -3.0, 0), (3.4, -2.6, 4)),
        np.stack((thin[[0, 1, 2]], thin[[0, 2, 3]])),
    )


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scans")
    write_mesh(courtyard(), folder / "truth.ply")
    for name, every in (("scans", 3), ("sparse", 40)):
        options = ["--route", ROUTE, "--speed", "4", "--azimuth-step", "0.5", "--every", str(every)]
        assert main(["scan", str(folder / "truth.ply"), str(folder / name), *options, "--quiet"]) == 0
    return folder


def cells_of(folder: Path, free: bool = False) -> np.ndarray:
    """(C, 6, 4) planes of the cells that a scan leads to."""
    scene, _ = open_scene(folder, SceneSettings(), SurveySettings(view="ground", unknown_is_free=free))
    settings = CellSettings(min_size=1, max_size=4, coverage_points=500)
    return np.asarray(planes(decompose(scene, settings), scene.step)).reshape(-1, 6, 4)


def entering(sides: np.ndarray, corners: np.ndarray, depth: float) -> int:
    """Pairs of a cell, six planes (C, 6, 4) that look outwards, and a triangle (F, 3, 3) that reaches deeper
    than `depth` into it: the triangle cut with the planes moved inwards."""
    pairs = 0
    for cell in sides:
        for triangle in corners:
            part = triangle
            for plane in cell:
                part = cut(part, part @ plane[:3] + plane[3] + depth)
            pairs += len(part) > 0
    return pairs


def cut(polygon: np.ndarray, away: np.ndarray) -> np.ndarray:
    """The part of a polygon (N, 3) where the linear function with values (N,) is negative."""
    kept: list[np.ndarray] = []
    for k in range(len(polygon)):
        a, b = away[k - 1], away[k]
        if (a < 0) != (b < 0):
            kept.append(polygon[k - 1] + (polygon[k] - polygon[k - 1]) * (a / (a - b)))
        if b < 0:
            kept.append(polygon[k])
    return np.array(kept).reshape(-1, 3)


def true_corners() -> np.ndarray:
    scene = courtyard()
    return scene.corners() * scene.step


def test_no_true_face_enters_a_cell_and_cells_lie_in_seen_space_only(place: Path) -> None:
    """Inside of the walls, the shed and the pillar, and beyond the walls, nothing was seen."""
    sides = cells_of(place / "scans")
    assert len(sides) > 10
    assert entering(sides, true_corners(), BOUND) == 0
    points = np.random.default_rng(0).uniform((-14, -14, -1), (14, 14, 9), (40_000, 3))
    inside = (np.einsum("ckj,pj->pck", sides[:, :, :3], points) + sides[:, :, 3] <= 0).all(axis=2).any(axis=1)
    assert inside.mean() > 0.01
    found = points[inside]
    assert np.abs(found[:, :2]).max() < 11.0
    assert found[:, 2].min() > 0.0
    for low, high in (((-5, -4, 0), (0, 3, 3)), ((3.0, -3.0, 0), (3.4, -2.6, 4))):
        assert not ((found > low) & (found < high)).all(axis=1).any()


def test_with_unknown_space_taken_for_free_true_faces_do_enter_cells(place: Path) -> None:
    """What the rule prevents: between the beams of every 40th turn stand walls that nothing hit."""
    assert entering(cells_of(place / "sparse", free=True), true_corners(), BOUND) > 0
