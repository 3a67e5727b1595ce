"""Scans with poses: each return is tied to the place where its scanner was."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scan_scenes import room

from tilesnav_ref.cli import main
from tilesnav_ref.clouds import CloudSettings, read_cloud
from tilesnav_ref.clouds.write import write_points
from tilesnav_ref.scene import SceneError, SceneSettings, write_mesh
from tilesnav_ref.sensor import Route, ScannerSettings, join, simulate_scans, write_scans
from tilesnav_ref.survey import SurveySettings, open_scene
from tilesnav_ref.survey.read import read_survey
from tilesnav_ref.survey.scans import POSES, read_scans

SETTINGS = ScannerSettings(azimuth_step=3.0, every=2)
ROUTE = Route(((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0)), speed=4.0)
READ = CloudSettings()
XYZ = np.dtype([(axis, "<f8") for axis in "xyz"])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scans") / "scans"
    write_scans(simulate_scans(room(), ROUTE, SETTINGS), path)
    return path


@pytest.fixture
def copied(folder: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(folder, tmp_path / "copied"))


def true_beams() -> tuple[np.ndarray, np.ndarray]:
    found = join(simulate_scans(room(), ROUTE, SETTINGS))
    return found.points, found.places


def test_the_scanner_moves_while_it_turns() -> None:
    _, places = true_beams()
    assert np.allclose([ROUTE.positions(np.zeros(1))[0]], places[:1])
    assert len(np.unique(places.round(6), axis=0)) > 100


def test_a_folder_gives_points_and_places_in_the_nav_frame(folder: Path) -> None:
    cloud = read_scans(folder, READ)
    points, places = true_beams()
    assert cloud.places is not None
    assert np.abs(cloud.points + cloud.origin - points).max() < 1e-6
    assert np.abs(cloud.places + cloud.origin - places).max() < 1e-6


@pytest.mark.parametrize("ending", [".ply", ".las"])
def test_one_file_gives_them_too(tmp_path: Path, ending: str) -> None:
    if ending == ".las":
        pytest.importorskip("laspy", reason="LAS is an extra")
    path = tmp_path / f"a{ending}"
    write_scans(simulate_scans(room(), ROUTE, SETTINGS), path)
    survey = read_survey(path, SceneSettings())
    assert survey.origins is not None
    assert np.abs(survey.points - true_beams()[0]).max() < 0.001
    assert np.abs(survey.origins - true_beams()[1]).max() < 0.001


def test_places_follow_the_unit_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    write_scans(simulate_scans(room(), ROUTE, SETTINGS), path)
    cloud = read_cloud(path, CloudSettings(units="ft"))
    assert cloud.places is not None
    assert np.allclose(cloud.places + cloud.origin, true_beams()[1] * 0.3048, atol=1e-6)


def test_other_poses_replace_those_of_the_folder(folder: Path, tmp_path: Path) -> None:
    rows = [line.split() for line in (folder / POSES).read_text().splitlines()[1:]]
    moved = [" ".join([row[0], str(float(row[1]) + 10.0), *row[2:]]) for row in rows]
    (tmp_path / "found.txt").write_text("\n".join(moved))
    cloud = read_scans(folder, READ, tmp_path / "found.txt")
    assert cloud.places is not None
    assert np.abs(cloud.places + cloud.origin - true_beams()[1] - (10.0, 0.0, 0.0)).max() < 1e-6


def test_scans_without_places_stood_still_at_their_pose(folder: Path, copied: Path) -> None:
    for path in copied.glob("*.ply"):
        cloud = read_cloud(path)
        bare = np.empty(len(cloud.points), XYZ)
        for axis, values in zip("xyz", (cloud.points + cloud.origin).T, strict=True):
            bare[axis] = values
        write_points(path, XYZ, [bare])
    cloud = read_scans(copied, READ)
    assert cloud.places is not None
    assert len(np.unique(cloud.places.round(6), axis=0)) == len(list(copied.glob("*.ply")))
    assert np.allclose(cloud.points, read_scans(folder, READ).points, atol=1e-6)


def test_register_keeps_the_places(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("small_gicp", reason="registration is an extra")
    scans = sorted(str(path) for path in folder.glob("*.ply"))
    options = ["--poses", str(folder / POSES), "--found-poses", str(tmp_path / "found.txt"), "--quiet"]
    assert main(["register", *scans, str(tmp_path / "merged.ply"), *options]) == 0
    merged = read_cloud(tmp_path / "merged.ply")
    again = read_scans(folder, READ, tmp_path / "found.txt")
    assert merged.places is not None
    assert again.places is not None
    assert np.abs(merged.places + merged.origin - again.places - again.origin).max() < 1e-6
    tied = read_scans(tmp_path / "merged.ply", READ, tmp_path / "found.txt").places
    assert tied is not None
    assert np.linalg.norm(tied - merged.places, axis=1).max() < 0.5  # of its way in a turn


@pytest.mark.parametrize("change", ["one pose less", "one scan less", "no poses", "no pose"])
def test_scans_and_poses_that_do_not_match_are_refused(copied: Path, change: str) -> None:
    lines = (copied / POSES).read_text().splitlines()
    count = len(lines) - 1
    expected = {
        "one pose less": f"poses: found {count - 1} for {count} scans",
        "one scan less": f"poses: found {count} for {count - 1} scans",
        "no poses": "poses: found No such file",
        "no pose": r"poses\.txt, line 2: poses: found '1 2 3'",
    }[change]
    if change == "one pose less":
        (copied / POSES).write_text("\n".join(lines[:-1]))
    elif change == "no pose":
        (copied / POSES).write_text("\n".join([lines[0], "1 2 3", *lines[2:]]))
    else:
        (copied / POSES if change == "no poses" else min(copied.glob("*.ply"))).unlink()
    with pytest.raises(SceneError, match=expected):
        read_scans(copied, READ)


def test_points_that_name_no_pose_are_refused(folder: Path, tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    write_scans(simulate_scans(room(), ROUTE, SETTINGS), path)  # turns 0, 2, 4: not lines of poses
    with pytest.raises(SceneError, match=r"a\.ply: points: found scan \d+ where .*poses\.txt has \d+ poses"):
        read_scans(path, READ, folder / POSES)
    (tmp_path / "b.xyz").write_text("1 2 3\n4 5 6\n")
    with pytest.raises(SceneError, match=r"b\.xyz: points: found no field 'scan'"):
        read_scans(tmp_path / "b.xyz", READ, folder / POSES)


def test_a_place_that_is_no_number_is_refused(tmp_path: Path) -> None:
    scans = list(simulate_scans(room(), ROUTE, SETTINGS))
    scans[0].returns.places[3] = np.nan
    write_scans(scans, tmp_path / "a.ply")
    with pytest.raises(SceneError, match=r"points: found one at .*nan"):
        read_cloud(tmp_path / "a.ply")


def test_poses_for_a_mesh_are_refused(folder: Path, tmp_path: Path) -> None:
    write_mesh(room(), tmp_path / "room.ply")
    with pytest.raises(SceneError, match="poses for scans or a point cloud only"):
        open_scene(tmp_path / "room.ply", SceneSettings(), SurveySettings(poses=folder / POSES))


def test_planes_of_a_folder(folder: Path, tmp_path: Path) -> None:
    assert main(["planes", str(folder), str(tmp_path / "planes"), "--quiet"]) == 0
    assert (tmp_path / "planes" / "planes.json").is_file()
    assert main(["planes", str(tmp_path), str(tmp_path / "other"), "--quiet"]) == 2


def test_a_region_is_in_the_frame_of_the_poses(folder: Path) -> None:
    whole = read_scans(folder, READ)
    part = read_scans(folder, replace(READ, region=(0.0, -99.0, 99.0, 99.0)))
    inside = (whole.points + whole.origin)[:, 0] >= 0.0
    assert 0 < len(part.points) < len(whole.points)
    assert len(part.points) == inside.sum()
