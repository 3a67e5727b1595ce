"""Scans brought together: poses that are known are found again."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from mission_scenes import rectangle, scene_of
from scan_scenes import yard
from scipy.spatial.transform import Rotation

from tilesnav_ref.cli import main
from tilesnav_ref.clouds import read_cloud
from tilesnav_ref.registration import LEAST_HELD, RegistrationError, RegistrationSettings, register
from tilesnav_ref.registration.adjust import adjust
from tilesnav_ref.registration.poses import read_poses, write_poses
from tilesnav_ref.registration.thin import thin
from tilesnav_ref.scene import Scene
from tilesnav_ref.sensor import Route, Scan, ScannerSettings, simulate_scans, write_scans

pytest.importorskip("small_gicp", reason="registration is an extra")

ROUND = Route(
    ((-15, -3, 1.5), (0, 0, 1.5), (17, 0, 1.5), (17, 15, 1.5), (0, 14, 1.5), (-15, 3, 1.5)), speed=20.0
)
"""Around a house, back to where it began."""


def scans_of(scene: Scene, route: Route, every: int = 5) -> list[Scan]:
    return list(simulate_scans(scene, route, ScannerSettings(azimuth_step=0.6, every=every, seed=7)))


def named(scans: Sequence[Scan]) -> list[tuple[str, np.ndarray]]:
    return [(f"scan {scan.number}", scan.points_in_scanner()) for scan in scans]


def wrong(scans: Sequence[Scan], metres: float, degrees: float) -> list[np.ndarray]:
    """True poses, all but the first disturbed by random motions of this size."""
    random = np.random.default_rng(11)
    poses = [scans[0].nav_from_scanner]
    for scan in scans[1:]:
        axis, way = random.normal(size=(2, 3))
        motion = np.eye(4)
        motion[:3, :3] = Rotation.from_rotvec(axis / np.linalg.norm(axis) * np.radians(degrees)).as_matrix()
        motion[:3, 3] = way / np.linalg.norm(way) * metres
        poses.append(scan.nav_from_scanner @ motion)
    return poses


def errors(scans: Sequence[Scan], poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Metres and degrees between poses and the truth."""
    away = [np.linalg.inv(scan.nav_from_scanner) @ pose for scan, pose in zip(scans, poses, strict=True)]
    turns = Rotation.from_matrix([motion[:3, :3] for motion in away]).magnitude()
    return np.linalg.norm([motion[:3, 3] for motion in away], axis=1), np.degrees(turns)


@pytest.fixture(scope="module")
def around() -> list[Scan]:
    return scans_of(yard(), ROUND)


def test_disturbed_poses_are_found_again(around: list[Scan]) -> None:
    starts = wrong(around, 0.6, 2.0)
    assert len(around) >= 8
    found = register(named(around), starts)
    metres, degrees = errors(around, found.map_from_scan)
    assert metres[0] < 1e-9
    assert np.median(metres) < 0.01
    assert metres.max() < 0.02
    assert degrees.max() < 0.1
    assert found.moved[0] < 1e-9
    assert np.abs(found.moved[1:] - 0.6).max() < 0.4  # its middle is not where the scanner is
    assert np.abs(np.degrees(found.turned[1:]) - 2.0).max() < 0.1
    # Means of noisy points: their distances lie between nothing and the noise of 3 cm.
    assert ((found.rms > 0.005) & (found.rms < 0.03)).all()
    assert (found.matched > 0.5).all()
    assert (found.held > 2 * LEAST_HELD).all()


def test_adjustment_closes_a_loop(around: list[Scan]) -> None:
    """Drift as a growing map leaves it: 4 cm and a tenth of a degree more with each scan."""
    settings = RegistrationSettings()
    thinned = [thin(name, points, settings) for name, points in named(around)]
    drifted = []
    for number, scan in enumerate(around):
        motion = np.eye(4)
        motion[:3, :3] = Rotation.from_euler("zx", (0.1 * number, 0.05 * number), degrees=True).as_matrix()
        motion[:3, 3] = np.array((0.0, 0.03, 0.025)) * number
        drifted.append(motion @ scan.nav_from_scanner)
    rounds: list[int] = []
    found = adjust(thinned, np.array(drifted), settings, rounds.append)
    assert errors(around, np.array(drifted))[0].max() > 0.3
    assert errors(around, found.poses)[0].max() < 0.02
    assert errors(around, found.poses)[1].max() < 0.1
    assert rounds == list(range(1, found.rounds + 1))


def test_same_again(around: list[Scan]) -> None:
    settings = RegistrationSettings(rounds=2)
    first, again = (register(named(around[:3]), wrong(around[:3], 0.3, 1.0), settings) for _ in range(2))
    assert np.array_equal(first.map_from_scan, again.map_from_scan)


def test_scans_that_follow_each_other_need_no_poses() -> None:
    scans = scans_of(yard(), Route(((0, 0, 1.5), (4, 0, 1.5)), speed=10.0), every=1)
    found = register(named(scans))
    relative = scans[0].nav_from_scanner @ found.map_from_scan
    assert errors(scans, relative)[0].max() < 0.02


def test_clouds_in_the_coordinates_of_a_country(around: list[Scan]) -> None:
    far = np.array((691_000.0, 5_335_000.0, 520.0))
    clouds = [(str(scan.number), scan.returns.points + far) for scan in around[:3]]
    turn = Rotation.from_euler("z", 0.5, degrees=True).as_matrix()
    middle = clouds[1][1].mean(axis=0)
    clouds[1] = (clouds[1][0], (clouds[1][1] - middle) @ turn.T + middle + (0.2, -0.1, 0.05))
    found = register(clouds)
    placed = [
        points @ pose[:3, :3].T + pose[:3, 3]
        for (_, points), pose in zip(clouds, found.map_from_scan, strict=True)
    ]
    for scan, points in zip(around[:3], placed, strict=True):
        assert np.linalg.norm(points - far - scan.returns.points, axis=1).max() < 0.05
    given = register(clouds, [np.eye(4)] * 3)
    assert np.array_equal(given.map_from_scan, found.map_from_scan)


def test_a_direction_that_no_plane_fixes_is_told() -> None:
    corridor = scene_of(
        rectangle((-200, 200), (-3, 3), (0, 0)),
        np.array([((-200, y, 0), (200, y, 0), (200, y, 4)) for y in (-3, 3)], float),
        np.array([((-200, y, 0), (200, y, 4), (-200, y, 4)) for y in (-3, 3)], float),
    )
    scans = scans_of(corridor, Route(((0, 0, 1.5), (2, 0, 1.5)), speed=10.0), every=1)
    found = register(named(scans), [scan.nav_from_scanner for scan in scans])
    assert (found.held < LEAST_HELD).all()
    assert (found.matched > 0.9).all()


def test_what_is_refused(around: list[Scan]) -> None:
    clouds = named(around[:2])
    with pytest.raises(RegistrationError, match="found 1; allowed: 2"):
        register(clouds[:1])
    with pytest.raises(RegistrationError, match="found 3; allowed: 2, one a scan"):
        register(clouds, [np.eye(4)] * 3)
    mirrored = np.diag((1.0, -1.0, 1.0, 1.0))
    with pytest.raises(RegistrationError, match="starting pose 2: found no rigid motion"):
        register(clouds, [np.eye(4), mirrored])
    with pytest.raises(RegistrationError, match="thin air: found points in 0 voxels"):
        register([clouds[0], ("thin air", np.full((9, 3), np.nan))])
    away = np.eye(4)
    away[0, 3] = 500.0
    with pytest.raises(RegistrationError, match=f"{clouds[1][0]}: found partners for 0%"):
        register(clouds, [np.eye(4), away])
    with pytest.raises(RegistrationError, match="larger voxels"):
        register([clouds[0], ("far", clouds[1][1] + 1e9)])


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("voxel", 0.0),
        ("reach", 0.1),
        ("fine_reach", -1.0),
        ("links", 0),
        ("map_scans", 0),
        ("link_points", 0),
        ("rounds", -1),
        ("least_overlap", 1.5),
    ],
)
def test_bad_settings(name: str, value: float) -> None:
    with pytest.raises(RegistrationError, match=name):
        RegistrationSettings(**{name: value})  # type: ignore[arg-type]


def test_command(around: list[Scan], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scans = around[:4]
    write_scans(scans, tmp_path / "scans")
    files = [str(path) for path in sorted((tmp_path / "scans").glob("*.ply"))]
    write_poses(tmp_path / "starts.txt", np.array(wrong(scans, 0.3, 1.0)))
    out, poses = tmp_path / "merged.ply", tmp_path / "poses.txt"
    options = ["--poses", str(tmp_path / "starts.txt"), "--found-poses", str(poses), "--quiet"]
    assert main(["register", *files, str(out), *options, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert errors(scans, read_poses(poses))[0].max() < 0.03
    assert np.allclose([row["pose"] for row in found["scans"]], read_poses(poses), atol=1e-6)
    assert [row["scan"] for row in found["scans"]] == files
    assert found["points"] == sum(len(scan.returns) for scan in scans)
    merged = read_cloud(out)
    expected = np.concatenate([scan.returns.points for scan in scans])
    away = np.linalg.norm(merged.points + merged.origin - expected, axis=1)
    assert np.percentile(away, 99) < 0.05
    assert main(["register", *files, str(out), *options]) == 2
    assert "something there" in capsys.readouterr().err
    options[3] = str(tmp_path / "again.txt")
    assert main(["register", *files, str(tmp_path / "again.ply"), *options]) == 0
    assert "rms" in capsys.readouterr().out
    assert out.read_bytes() == (tmp_path / "again.ply").read_bytes()


def test_command_refuses(around: list[Scan], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_scans(around[:2], tmp_path / "scans")
    files = [str(path) for path in sorted((tmp_path / "scans").glob("*.ply"))]
    (tmp_path / "bad.txt").write_text("# remark\n0 1 2 3 0 0 0 1\n0 1 2 3 0 0 0 2\n")
    before = sorted(tmp_path.iterdir())
    for arguments, said in (
        ([*files, str(tmp_path / "a.ply"), "--poses", str(tmp_path / "bad.txt")], "line 3: found a quat"),
        ([*files, str(tmp_path / "a.xyz")], "'.xyz'"),
        ([files[0], str(tmp_path / "a.ply")], "found 1; allowed: 2"),
        ([*files, str(tmp_path / "a.ply"), "--voxel", "0"], "voxel: found 0.0"),
        ([*files, str(tmp_path / "no" / "a.ply")], "no folder"),
        ([*files, str(tmp_path / "missing.ply"), str(tmp_path / "a.ply")], "missing.ply"),
    ):
        assert main(["register", *arguments, "--quiet"]) == 2
        assert said in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == before


def test_poses_are_written_and_read(tmp_path: Path) -> None:
    random = np.random.default_rng(2)
    poses = np.repeat(np.eye(4)[None], 5, axis=0)
    poses[:, :3, :3] = Rotation.random(5, random_state=3).as_matrix()
    poses[:, :3, 3] = random.uniform(-1e6, 1e6, (5, 3))
    write_poses(tmp_path / "p.txt", poses)
    assert np.abs(read_poses(tmp_path / "p.txt") - poses).max() < 1e-8


@pytest.mark.parametrize("line", ["1 2 3", "0 1 2 3 0 0 0 x", "0 nan 2 3 0 0 0 1"])
def test_bad_poses(tmp_path: Path, line: str) -> None:
    (tmp_path / "p.txt").write_text(line)
    with pytest.raises(RegistrationError, match=r"line 1: .*eight numbers"):
        read_poses(tmp_path / "p.txt")
