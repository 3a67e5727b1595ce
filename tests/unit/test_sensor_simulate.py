"""The simulated scanner: ranges and poses as computed by other means, noise as it was asked for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mission_scenes import box_faces
from scan_scenes import nearest_hits, room, wall_ranges, yard
from scipy.spatial.transform import Rotation

from tilesnav_ref.scene import Scene
from tilesnav_ref.sensor import NO_FACE, Route, Scan, ScanError, ScannerSettings, join, simulate_scans

EXACT = ScannerSettings(range_noise=0.0, dropouts=0.0, azimuth_step=2.0)
STILL = Route(((0.5, -1.0, 0.25),))


def scan(scene: Scene, route: Route, settings: ScannerSettings) -> list[Scan]:
    return list(simulate_scans(scene, route, settings))


def test_ranges_in_a_room() -> None:
    (one,) = scan(room(), STILL, EXACT)
    got = one.returns
    assert len(got) == 180 * 16
    directions = EXACT.directions().reshape(-1, 3)
    expected = wall_ranges(np.array(STILL.waypoints), directions)
    assert np.abs(got.true_ranges - expected).max() < 1e-9
    assert np.abs(got.points - (np.array(STILL.waypoints) + expected[:, None] * directions)).max() < 1e-9
    assert np.abs(got.raw - expected[:, None] * directions).max() < 1e-5  # float32 at 10 m
    assert got.beams.tolist() == list(range(16)) * 180
    assert np.allclose(got.times, np.repeat(np.arange(180) / 1800.0, 16))
    assert one.nav_from_scanner[:3, 3].tolist() == list(STILL.waypoints[0])


def test_true_faces_hold_the_points() -> None:
    scene = room()
    (one,) = scan(scene, STILL, EXACT)
    corners = scene.corners()[one.returns.faces] * scene.step
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert np.abs(((one.returns.points - corners[:, 0]) * normals).sum(axis=1)).max() < 1e-9
    low, high = corners.min(axis=1) - 1e-5, corners.max(axis=1) + 1e-5
    assert np.all((one.returns.points >= low) & (one.returns.points <= high))
    assert (one.returns.objects == scene.face_object[one.returns.faces]).all()


def test_what_is_in_front_hides_what_is_behind() -> None:
    scene = yard()
    (one,) = scan(scene, Route(((0.0, 0.0, 1.75),)), replace(EXACT, azimuth_step=5.0))
    expected = nearest_hits(
        scene.corners() * scene.step,
        np.array((0, 0, 1.75)),
        replace(EXACT, azimuth_step=5.0).directions().reshape(-1, 3),
    )
    met = np.isfinite(expected) & (expected <= 100.0)
    assert 0.4 < met.mean() < 0.9
    assert len(one.returns) == met.sum()
    assert np.abs(one.returns.true_ranges - expected[met]).max() < 1e-9


def test_far_from_the_zero_of_the_frame() -> None:
    low, high = np.array((8000.0, -8000.0, 8000.0)), np.array((8020.0, -7980.0, 8010.0))
    corners = np.round(box_faces(tuple(low), tuple(high)) * 1024).astype(np.int64)
    scene = Scene(
        corners.reshape(-1, 3),
        np.arange(36, dtype=np.int32).reshape(-1, 3),
        np.zeros(12, np.int32),
        np.zeros(1, np.int32),
        ("box",),
    )
    middle = (8009.9, -7991.3, 8004.7)
    (one,) = scan(scene, Route((middle,)), EXACT)
    expected = wall_ranges(np.array(middle), EXACT.directions().reshape(-1, 3), (low, high))
    assert len(one.returns) == 180 * 16
    # Rounding of the origin to a grid step of 1 mm may choose the other face at an edge of the box.
    assert np.abs(one.returns.true_ranges - expected).max() < 2e-3
    assert np.median(np.abs(one.returns.true_ranges - expected)) < 1e-9


@pytest.mark.parametrize("mount", [{}, {"roll": 90.0}, {"pitch": 30.0, "roll": -10.0}])
def test_a_scanner_that_moves_and_turns(mount: dict[str, float]) -> None:
    settings = replace(EXACT, **mount)
    route = Route(((0.0, 0.0, 0.0), (4.0, 0.0, 1.0), (4.0, 4.0, 1.0)), speed=8.0)
    scans = scan(room(), route, settings)
    assert len(scans) == 11  # 8.12 m at 8 m/s
    got = join(scans)
    places = route.positions(got.times)
    turns = Rotation.from_euler("z", route.headings(got.times)[:, None]) * Rotation.from_euler(
        "YX", [settings.pitch, settings.roll], degrees=True
    )
    assert np.abs(places + turns.apply(got.raw) - got.points).max() < 1e-5
    directions = turns.apply(got.raw / np.linalg.norm(got.raw, axis=1, keepdims=True).astype(np.float64))
    assert np.abs(wall_ranges(places, directions) - got.true_ranges).max() < 1e-4
    for one in scans:
        pose = one.nav_from_scanner
        back = one.points_in_scanner() @ pose[:3, :3].T + pose[:3, 3]
        assert np.abs(back - one.returns.points).max() < 1e-9


def test_roll_of_a_quarter_sweeps_the_plane_across() -> None:
    settings = ScannerSettings(beams=1, lowest=0.0, highest=0.0, range_noise=0.0, dropouts=0.0, roll=90.0)
    (one,) = scan(room(), Route(((0.0, 0.0, 0.0),)), settings)
    assert np.ptp(one.returns.points[:, 1]) < 1e-9
    assert one.returns.points[:, 2].min() == pytest.approx(-2.0)
    assert one.returns.points[:, 2].max() == pytest.approx(3.0)


def test_noise_dropouts_and_outliers() -> None:
    settings = ScannerSettings(range_noise=0.05, dropouts=0.1, outliers=0.2, max_range=50.0)
    (one,) = scan(room(), STILL, settings)
    got, rays = one.returns, settings.firings * settings.beams
    stray = got.faces == NO_FACE
    assert len(got) / rays == pytest.approx(0.9, abs=0.01)
    assert stray.mean() == pytest.approx(0.2, abs=0.01)
    assert (got.objects[stray] == NO_FACE).all()
    away = np.linalg.norm(got.points - STILL.waypoints[0], axis=1)
    error = (away - got.true_ranges)[~stray]
    assert error.std() == pytest.approx(0.05, rel=0.03)
    assert abs(error.mean()) < 0.001  # five standard errors
    assert away[stray].mean() == pytest.approx(25.25, abs=1.0)
    assert away.max() <= 50.0 + 1e-9


def test_nothing_beyond_the_range() -> None:
    everything = scan(room(), STILL, EXACT)[0].returns.true_ranges
    some = scan(room(), STILL, replace(EXACT, min_range=3.0, max_range=6.0))[0].returns.true_ranges
    assert sorted(some) == sorted(everything[(everything >= 3.0) & (everything <= 6.0)])
    assert len(some) < len(everything)
    nothing = scan(room(), STILL, replace(EXACT, min_range=50.0))[0].returns
    assert len(nothing) == 0


def test_same_for_a_seed_and_each_scan_by_itself() -> None:
    settings = ScannerSettings(azimuth_step=4.0, outliers=0.1, seed=3)
    route = Route(((0.0, 0.0, 0.0), (3.0, 0.0, 0.0)))
    first, again = (scan(room(), route, settings) for _ in range(2))
    assert [one.number for one in first] == [0, 1, 2, 3, 4, 5]
    assert all(np.array_equal(a.returns.points, b.returns.points) for a, b in zip(first, again, strict=True))
    some = scan(room(), route, replace(settings, every=3))
    assert [one.number for one in some] == [0, 3]
    assert np.array_equal(some[1].returns.points, first[3].returns.points)
    other = scan(room(), route, replace(settings, seed=4))
    assert not np.array_equal(other[0].returns.points[:50], first[0].returns.points[:50])


def test_headings_turn_evenly_the_shorter_way() -> None:
    route = Route(((0, 0, 0), (10, 0, 0), (10, 0, 5), (10, -10, 5), (0, -10, 5)), speed=1.0, turn_length=2.0)
    assert (route.length, route.duration) == (35.0, 35.0)
    times = np.array((0.0, 8.9, 12.5, 15.0, 20.0, 24.5, 25.0, 25.5, 30.0, 99.0))
    degrees = np.degrees(route.headings(times))
    assert np.allclose(degrees, (0, 0, 0, -45, -90, -112.5, -135, -157.5, -180, -180))
    assert np.allclose(route.positions(np.array((12.5, 99.0))), ((10, 0, 2.5), (0, -10, 5)))
    assert np.allclose(np.degrees(Route(((0, 0, 0), (0, 0, 5), (0, 5, 5))).headings(np.array((0.5,)))), 90)
    straight_up = Route(((0, 0, 0), (0, 0, 5)))
    assert straight_up.headings(np.array((0.5,))) == 0.0


@pytest.mark.parametrize(
    ("members", "named"),
    [
        ({"waypoints": ()}, "route"),
        ({"waypoints": ((0.0, 0.0, float("nan")),)}, "waypoint 1"),
        ({"waypoints": ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 0.0, 0.0))}, "waypoint 3"),
        ({"waypoints": ((0.0, 0.0, 0.0),), "speed": 0.0}, "speed"),
        ({"waypoints": ((0.0, 0.0, 0.0),), "turn_length": -1.0}, "turn_length"),
    ],
)
def test_bad_routes(members: dict[str, object], named: str) -> None:
    with pytest.raises(ScanError, match=named):
        Route(**members)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("beams", 0),
        ("beams", 1),
        ("beams", 257),
        ("lowest", 20.0),
        ("highest", 90.0),
        ("azimuth_step", 0.7),
        ("azimuth_step", 0.0),
        ("rotation_rate", 0.0),
        ("min_range", 100.0),
        ("range_noise", -0.1),
        ("dropouts", 1.0),
        ("outliers", -0.1),
        ("pitch", 181.0),
        ("roll", float("nan")),
        ("every", 0),
        ("seed", -1),
    ],
)
def test_bad_settings(name: str, value: float) -> None:
    with pytest.raises(ScanError, match=name):
        ScannerSettings(**{name: value})  # type: ignore[arg-type]
