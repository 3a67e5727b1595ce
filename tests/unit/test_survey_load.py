"""A point cloud becomes a scene: planes, their table, and what was done."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from survey_fixture import site_from_above, write_las

from tilesnav_ref.cells import CellSettings, decompose
from tilesnav_ref.levels import LevelSettings, coarse_levels
from tilesnav_ref.scene import Scene, SceneError, SceneReport, SceneSettings
from tilesnav_ref.scene.frame import NavFrame
from tilesnav_ref.survey import SurveySettings, load, open_scene
from tilesnav_ref.survey.read import Survey, is_cloud
from tilesnav_ref.tileset.content import make_content


@pytest.fixture(scope="module")
def cloud(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_las(
        tmp_path_factory.mktemp("cloud") / "site.las", site_from_above() - (-500_000.0, -4e6, -70.0)
    )


@pytest.fixture(scope="module")
def loaded(cloud: Path) -> tuple[Scene, SceneReport]:
    return open_scene(cloud, SceneSettings(), SurveySettings())


def test_ground_and_roof_are_planes_of_the_scene(loaded: tuple[Scene, SceneReport]) -> None:
    scene, report = loaded
    planes = scene.planes
    assert planes is not None
    assert len(planes.face_plane) == scene.face_count
    assert planes.areas[0] == pytest.approx(1600 - 100 - 28, rel=0.05)
    assert planes.areas[1] == pytest.approx(100, rel=0.1)
    assert np.abs(planes.normals[:2, 2]).min() > 0.999
    distances = np.einsum("fck,fk->fc", scene.corners() * scene.step, planes.normals[planes.face_plane])
    assert np.abs(distances + planes.offsets[planes.face_plane][:, None]).max() < 0.02
    assert report.survey is not None
    assert report.survey["planes"] == len(planes)
    assert report.survey["points"] == 19200
    assert report.survey["point_distance_95"] < 0.06


def test_coordinates_beyond_the_grid_get_an_origin_that_is_stated(
    loaded: tuple[Scene, SceneReport],
) -> None:
    scene, report = loaded
    assert report.survey is not None
    assert report.survey["origin"] == (500_000.0, 4e6, 0.0)
    assert np.allclose(scene.vertices.min(axis=0) * scene.step, (0.0, 0.0, 70.0), atol=0.2)


def test_what_is_under_the_roof_is_unknown_unless_it_is_taken_for_free(
    cloud: Path, loaded: tuple[Scene, SceneReport]
) -> None:
    unknown = loaded[0].unknown
    assert unknown is not None
    assert unknown.holds(np.array([[15, 15, 73]]) * 1024).all()
    assert loaded[1].survey is not None
    assert 0 < loaded[1].survey["unknown_share"] < 1
    scene, report = open_scene(cloud, SceneSettings(), SurveySettings(unknown_is_free=True))
    assert scene.unknown is None
    assert report.survey is not None
    assert report.survey["unknown_share"] == 0


def test_the_ground_is_filled_where_asked_for_and_seen_from_above(cloud: Path) -> None:
    scene, report = open_scene(cloud, SceneSettings(), SurveySettings(fill_ground=True))
    planes = scene.planes
    assert planes is not None
    between = planes.face_plane < 0
    assert report.survey is not None
    assert report.survey["ground_faces"] >= between.sum() > 100  # slivers go where vertices are welded
    assert {scene.object_names[k] for k in scene.face_object[between]} == {"ground"}
    assert np.abs(scene.corners()[between][:, :, 2] * scene.step - 70.0).max() < 0.1
    (number,) = np.unique(scene.face_object[between])
    assert b'"nullFeatureId":' in make_content(scene, 0).data.replace(b" ", b"")
    assert scene.object_names[int(number)] == "ground"
    settings = SurveySettings(fill_ground=True, view="ground", unknown_is_free=True)
    beside = open_scene(cloud, SceneSettings(), settings)[1].survey
    assert beside is not None
    assert beside["ground_faces"] == 0


def test_a_region_keeps_the_points_in_it(cloud: Path) -> None:
    settings = SceneSettings(region=(0, 0, 5, 5), region_margin=2.0)
    scene, report = open_scene(cloud, settings, SurveySettings())
    assert report.survey is not None
    assert report.survey["points"] + report.survey["left_out"] == 19200
    assert report.survey["points"] == pytest.approx(49 * 12, rel=0.2)
    assert (scene.vertices.max(axis=0)[:2] <= 7 * 1024 + 1).all()


def test_a_region_without_a_point_is_refused(cloud: Path) -> None:
    with pytest.raises(SceneError, match=r"site\.las: points: found none of 19200 is in the region"):
        open_scene(cloud, SceneSettings(region=(900, 900, 950, 950)), SurveySettings())


def test_points_without_a_plane_are_refused(tmp_path: Path) -> None:
    leaves = np.random.default_rng(0).random((25, 3)) * 20.0
    with pytest.raises(SceneError, match="found no plane in 25 points"):
        open_scene(write_las(tmp_path / "leaves.las", leaves), SceneSettings(), SurveySettings())


def test_a_survey_from_the_ground_needs_the_places_of_its_scanner(cloud: Path) -> None:
    with pytest.raises(SceneError, match=r"no positions of the scanner.*view air, or unknown_is_free"):
        open_scene(cloud, SceneSettings(), SurveySettings(view="ground"))


@pytest.mark.parametrize(("name", "value"), [("block", 0.0), ("rise", float("nan")), ("view", "space")])
def test_a_setting_out_of_range_is_refused(name: str, value: object) -> None:
    with pytest.raises(SceneError, match=f"settings: {name}: found"):
        SurveySettings(**{name: value})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("a.las", "", True),
        ("a.XYZ", "", True),
        ("a.obj", "", False),
        ("a.ply", "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nend_header\n", True),
        ("a.ply", "ply\nelement vertex 9\nelement face 0\nend_header\n", True),
        ("a.ply", "ply\nelement vertex 9\nelement face 2\nend_header\n", False),
        ("a.ply", "nothing", False),
    ],
)
def test_a_cloud_is_known_by_its_name_or_header(tmp_path: Path, name: str, text: str, expected: bool) -> None:
    path = tmp_path / name
    path.write_text(text)
    assert is_cloud(path) is expected


def test_a_ply_file_that_is_not_there_is_left_to_the_reader_of_meshes(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"none\.ply"):
        open_scene(tmp_path / "none.ply", SceneSettings(), SurveySettings())


def test_coarse_levels_are_written_without_planes(loaded: tuple[Scene, SceneReport]) -> None:
    scene = loaded[0]
    (level,) = coarse_levels(scene, LevelSettings(levels=2), threads=1)
    assert level.scene.planes is None
    assert b"_FEATURE_ID_0" in make_content(scene, 0).data
    assert b"_FEATURE_ID_0" not in make_content(level.scene, 0).data


def test_with_the_places_of_the_scanner_the_inside_of_a_room_is_free(
    cloud: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A room of 10 m, scanned from its middle, as an E57 file would state it."""
    rays = np.random.default_rng(5).normal(size=(60_000, 3))
    points = rays / np.abs(rays).max(axis=1, keepdims=True) * 5.0
    points *= 1.0 + np.random.default_rng(6).normal(0.0, 0.002, (len(points), 1))
    frame = NavFrame(points, np.eye(4), "z")
    survey = Survey(points, frame, None, np.zeros_like(points))
    monkeypatch.setattr(load, "read_survey", lambda *_: survey)
    scene, report = open_scene(cloud, SceneSettings(), SurveySettings(view="ground", block=0.5))
    assert report.survey is not None
    assert report.survey["planes"] == 6
    cells = decompose(scene, CellSettings(min_size=1, max_size=4, coverage_points=1000))
    assert cells.count > 0
    assert np.abs(cells.corners).max() < 5 * 1024
    free = decompose(replace(scene, unknown=None), CellSettings(min_size=1, max_size=4, coverage_points=1000))
    assert np.abs(free.corners).max() > 5 * 1024


def test_without_the_extra_the_error_names_it(cloud: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith(("shapely", "tilesnav_ref.survey.load"))]:
        monkeypatch.delitem(sys.modules, name)
    for name in [name for name in sys.modules if name.startswith("tilesnav_ref.planar.")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "shapely", None)
    with pytest.raises(SceneError, match=r"point cloud: found no module shapely; allowed: the extra 'lidar'"):
        open_scene(cloud, SceneSettings(), SurveySettings())
