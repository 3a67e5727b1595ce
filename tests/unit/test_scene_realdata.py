"""Meshes that others made: counts that their descriptions state, and soundness of what becomes of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tilesnav_ref.scene import Scene, SceneSettings, load_scene
from tilesnav_ref.scene.noding import count_junctions
from tilesnav_ref.scene.weld import has_area

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
MUNICH = DATA / "munich_mesh" / "munich.ply"

pytestmark = [
    pytest.mark.realdata,
    pytest.mark.jit,
    pytest.mark.skipif(not DATA.is_dir(), reason="../shared/data is not beside the checkout"),
]


def assert_sound(scene: Scene) -> None:
    """On the grid, noded, with area, every vertex once and used, order never going back."""
    assert np.abs(scene.vertices).max() < 1 << 23
    assert len(np.unique(scene.vertices, axis=0)) == len(scene.vertices)
    assert np.array_equal(np.unique(scene.faces), np.arange(len(scene.vertices)))
    assert has_area(scene.corners()).all()
    assert count_junctions(scene.vertices, scene.faces.astype(np.int64)) == 0
    assert (np.diff(scene.face_object) >= 0).all()
    assert (np.diff(scene.object_content) >= 0).all()
    assert np.bincount(scene.face_object).max() <= 4096


def test_munich() -> None:
    scene, report = load_scene(MUNICH)
    assert (report.file_vertices, report.file_faces) == (34_044, 38_936)
    assert (report.faces_before_noding, report.boundary_edges, report.degenerate_removed) == (
        38_936,
        7_218,
        0,
    )
    assert report.faces_divided > 4_000
    assert report.moved_max <= np.sqrt(3) / 2 / 1024
    assert report.lower == pytest.approx((-805.58, -688.60, 0.0), abs=0.01)
    assert report.upper == pytest.approx((669.88, 517.04, 98.57), abs=0.01)
    assert_sound(scene)


def test_region_of_munich() -> None:
    scene, report = load_scene(MUNICH, SceneSettings(region=(-150.0, -150.0, 150.0, 150.0)))
    assert 4_000 < report.faces < 8_000
    assert report.faces_before_noding + report.cropped_faces == 38_936
    assert_sound(scene)


def test_dungeon_is_y_up() -> None:
    scene, report = load_scene(DATA / "recast_dungeon" / "dungeon.obj", SceneSettings(up="y"))
    assert (report.file_vertices, report.file_faces) == (5_101, 10_133)
    assert (report.boundary_edges, report.non_manifold_edges) == (432, 138)
    extent = np.subtract(report.upper, report.lower)
    assert extent == pytest.approx((74.3, 98.9, 40.2), abs=0.1)
    assert_sound(scene)


def test_hospital() -> None:
    scene, report = load_scene(DATA / "hospital_indoor" / "hospital3_collision.ply")
    assert (report.file_vertices, report.file_faces) == (113_801, 82_822)
    assert np.subtract(report.upper, report.lower)[:2] == pytest.approx((25.1, 57.1), abs=0.1)
    assert report.junctions > 0
    assert_sound(scene)
