"""Files of scans, read by other programs or from their definition."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scan_scenes import room
from scipy.spatial.transform import Rotation

from tilesnav_ref.cli import main
from tilesnav_ref.scene import SceneError, write_mesh
from tilesnav_ref.sensor import Route, Scan, ScanError, ScannerSettings, join, simulate_scans, write_scans

SETTINGS = ScannerSettings(azimuth_step=3.0, outliers=0.1, every=2)
ROUTE = Route(((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0)), speed=4.0)
OPTIONS = ("--route", "0,0,0 1,0,0 1,1,0", "--speed", "4", "--azimuth-step", "3", "--outliers", "0.1")


@pytest.fixture(scope="module")
def scans() -> list[Scan]:
    return list(simulate_scans(room(), ROUTE, SETTINGS))


def test_ply(scans: list[Scan], tmp_path: Path) -> None:
    path, got = tmp_path / "a.ply", join(scans)
    assert write_scans(scans, path) == len(got)
    read = trimesh.load(path)
    assert np.array_equal(read.vertices, got.points)
    fields = read.metadata["_ply_raw"]["vertex"]["data"]
    for name, values in (
        ("time", got.times),
        ("scan", got.scans),
        ("beam", got.beams),
        ("face", got.faces),
        ("object", got.objects),
        ("true_range", got.true_ranges.astype(np.float32)),
    ):
        assert np.array_equal(fields[name].ravel(), values), name
    assert [one.name for one in tmp_path.iterdir()] == ["a.ply"]


@pytest.mark.parametrize("ending", [".las", ".laz"])
def test_las(scans: list[Scan], tmp_path: Path, ending: str) -> None:
    laspy = pytest.importorskip("laspy", reason="LAS is an extra")
    path, got = tmp_path / f"a{ending}", join(scans)
    assert write_scans(scans, path) == len(got)
    read = laspy.read(path)
    assert np.abs(read.xyz - got.points).max() <= 0.0005 + 1e-9
    assert np.abs(read.header.maxs - got.points.max(axis=0)).max() <= 0.0005 + 1e-9
    for name, values in (
        ("gps_time", got.times),
        ("scan", got.scans),
        ("user_data", got.beams),
        ("face", got.faces),
        ("object", got.objects),
        ("true_range", got.true_ranges.astype(np.float32)),
        ("return_number", np.ones(len(got))),
    ):
        assert np.array_equal(np.asarray(read[name]), values), name
    again = tmp_path / f"b{ending}"
    write_scans(scans, again)
    assert path.read_bytes() == again.read_bytes()


def test_mcap(scans: list[Scan], tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap_ros2.reader", reason="MCAP is an extra")
    path = tmp_path / "a.mcap"
    assert write_scans(scans, path) == len(join(scans))
    messages = [(one.channel.topic, one.ros_msg) for one in reader.read_ros2_messages(str(path))]
    by_topic = {topic: [message for where, message in messages if where == topic] for topic, _ in messages}
    assert {topic: len(of) for topic, of in by_topic.items()} == dict.fromkeys(
        ("/tf", "/pose", "/points"), len(scans)
    )
    rows = zip(scans, by_topic["/points"], by_topic["/pose"], by_topic["/tf"], strict=True)
    for scan, cloud, pose, frames in rows:
        stamp = cloud.header.stamp.sec - 1_000_000_000 + cloud.header.stamp.nanosec * 1e-9
        assert stamp == pytest.approx(scan.time, abs=1e-9)
        # As a driver's client reads them: by name, offset and type of the fields in the message.
        kinds = {7: "<f4", 5: "<i4", 4: "<u2"}
        record = np.dtype(
            {
                "names": [field.name for field in cloud.fields],
                "formats": [kinds[field.datatype] for field in cloud.fields],
                "offsets": [field.offset for field in cloud.fields],
                "itemsize": cloud.point_step,
            }
        )
        points = np.frombuffer(cloud.data, record)
        assert (cloud.height, cloud.width, cloud.row_step) == (1, len(points), len(cloud.data))
        assert np.array_equal(np.stack([points[axis] for axis in "xyz"], axis=1), scan.returns.raw)
        assert np.array_equal(points["ring"], scan.returns.beams)
        assert np.array_equal(points["face"], scan.returns.faces)
        assert np.abs(points["time"] + scan.time - scan.returns.times).max() < 1e-6
        place, turn = pose.pose.position, pose.pose.orientation
        matrix = Rotation.from_quat((turn.x, turn.y, turn.z, turn.w)).as_matrix()
        assert np.allclose(matrix, scan.nav_from_scanner[:3, :3], atol=1e-12)
        assert (place.x, place.y, place.z) == tuple(scan.nav_from_scanner[:3, 3])
        (frame,) = frames.transforms
        assert (frame.header.frame_id, frame.child_frame_id) == ("map", cloud.header.frame_id)
        assert (frame.transform.translation.x, frame.transform.rotation.w) == (place.x, turn.w)


def test_folder_of_scans_with_their_poses(scans: list[Scan], tmp_path: Path) -> None:
    out = tmp_path / "scans"
    write_scans(scans, out)
    poses = np.loadtxt(out / "poses.txt")
    assert sorted(one.name for one in out.glob("*.ply")) == [f"scan_{scan.number:06d}.ply" for scan in scans]
    for scan, pose in zip(scans, poses, strict=True):
        local = trimesh.load(out / f"scan_{scan.number:06d}.ply").vertices
        placed = Rotation.from_quat(pose[4:]).apply(local) + pose[1:4]
        assert np.abs(placed - scan.returns.points).max() < 1e-6  # nine decimals of quaternion and place
        assert pose[0] == pytest.approx(scan.time)


@pytest.mark.parametrize("name", ["a.ply", "a.las", "a.mcap", "folder"])
def test_nothing_is_left_of_scans_that_fail(scans: list[Scan], tmp_path: Path, name: str) -> None:
    pytest.importorskip("laspy", reason="LAS is an extra")

    def breaks() -> Iterator[Scan]:
        yield scans[0]
        raise RuntimeError("half way")

    with pytest.raises(RuntimeError, match="half way"):
        write_scans(breaks(), tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_what_is_not_written(scans: list[Scan], tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    for path, found in ((tmp_path / "a.xyz", r"\.xyz"), (tmp_path / "there", "something there")):
        with pytest.raises(ScanError, match=found):
            write_scans(scans, path)
    with pytest.raises(ScanError, match="no folder"):
        write_scans(scans, tmp_path / "missing" / "a.ply")


def test_las_refuses_what_it_cannot_hold(scans: list[Scan], tmp_path: Path) -> None:
    pytest.importorskip("laspy", reason="LAS is an extra")
    returns = scans[0].returns
    far = Scan(0, 0.0, np.eye(4), type(returns)(**{**vars(returns), "points": returns.points + 3e6}))
    near = Scan(0, 0.0, np.eye(4), returns)
    with pytest.raises(SceneError, match="2147484 m"):
        write_scans([near, far], tmp_path / "a.las")
    assert list(tmp_path.iterdir()) == []


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh, out = tmp_path / "room.ply", tmp_path / "scan.ply"
    write_mesh(room(), mesh)
    assert main(["scan", str(mesh), str(out), *OPTIONS, "--quiet", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["scans"], found["rays"]) == (5, 5 * 120 * 16)
    assert found["points"] == len(trimesh.load(out).vertices)
    assert found["bytes"] == out.stat().st_size
    assert (found["length"], found["duration"]) == (2.0, 0.5)
    assert (found["faces"], found["objects_hit"]) == (12, 1)
    assert 0.5 < found["area_hit"] <= 1.0
    assert found["outliers"] == pytest.approx(0.1 * found["points"], rel=0.1)
    assert main(["scan", str(mesh), str(tmp_path / "b.ply"), *OPTIONS, "--seed", "0"]) == 0
    assert "mean range" in capsys.readouterr().out
    assert out.read_bytes() == (tmp_path / "b.ply").read_bytes()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--route", "1,2,3", "--dropouts", "2"), "dropouts: found 2.0"),
        (("--route", "1,2"), "3 numbers"),
        (("--route", "1,2,3 1,2,3"), "waypoint 2"),
        ((), "--route"),
    ],
)
def test_command_refuses(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], said: str
) -> None:
    assert main(["scan", str(tmp_path / "no.ply"), str(tmp_path / "out.ply"), *options]) == 2
    assert said in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
