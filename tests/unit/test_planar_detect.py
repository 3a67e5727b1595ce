"""Planar features of clouds whose planes are known."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tilesnav_ref.clouds.synthetic import SyntheticSettings, synthetic_town
from tilesnav_ref.commands.planes import compression
from tilesnav_ref.planar import NO_PLANE, PlanarFeatures, PlaneSettings, detect_planes
from tilesnav_ref.planar.agreement import agreement

NOISE = 0.02


def turned(points: np.ndarray, seed: int = 1) -> np.ndarray:
    """Turn about an axis of no special direction, and move."""
    q = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return points @ q.T + np.array((500.0, -300.0, 40.0))


def box(
    size: tuple[float, float, float], density: float, roof: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Points and sides of a box without a floor; sides -x, +x, -y, +y and roof are 0 to 4."""
    random = np.random.default_rng(7)
    points, sides = [], []
    for side in range(5 if roof else 4):
        axis, up = (side // 2, side % 2) if side < 4 else (2, 1)
        others = [k for k in range(3) if k != axis]
        count = round(size[others[0]] * size[others[1]] * density)
        part = random.uniform(size=(count, 3)) * np.array(size)
        part[:, axis] = up * size[axis]
        points.append(part)
        sides.append(np.full(count, side, np.int32))
    noise = random.normal(0.0, NOISE, (sum(map(len, points)), 3))
    return np.concatenate(points) + noise, np.concatenate(sides)


@pytest.fixture(scope="module")
def house() -> tuple[np.ndarray, np.ndarray, PlanarFeatures]:
    points, sides = box((12.0, 8.0, 6.0), 60.0)
    points = turned(points)
    return points, sides, detect_planes(points)


@pytest.mark.jit
def test_a_box_has_five_planes(house: tuple[np.ndarray, np.ndarray, PlanarFeatures]) -> None:
    _, sides, found = house
    assert len(found) == 5
    score = agreement(found.labels, sides)
    assert (score.recall, score.precision) == (1.0, 1.0)
    assert score.right > 0.985
    assert found.inlier_distance == pytest.approx(4 * NOISE, rel=0.15)
    assert found.rms == pytest.approx(NOISE, rel=0.1)


@pytest.mark.jit
def test_what_a_feature_says_follows_from_its_points(
    house: tuple[np.ndarray, np.ndarray, PlanarFeatures],
) -> None:
    points, _, found = house
    assert found.counts.tolist() == sorted(found.counts.tolist(), reverse=True)
    assert np.allclose(np.linalg.norm(found.normals, axis=1), 1.0)
    for k in range(len(found)):
        own = points[found.labels == k]
        assert len(own) == found.counts[k]
        assert np.allclose(own.mean(axis=0), found.centroids[k])
        assert np.allclose(np.cov(own.T, bias=True), found.covariances[k])
        away = found.distances(own, k)
        assert np.abs(away).max() <= found.inlier_distance + 0.25 * NOISE  # the last fit moved a little
        assert math.sqrt((away**2).mean()) == pytest.approx(found.rms[k])
        least = np.linalg.svd(own - own.mean(axis=0), full_matrices=False)[2][2]
        assert abs(least @ found.normals[k]) == pytest.approx(1.0, abs=1e-9)
        u, v = found.extents.axes[k]
        assert np.allclose(np.cross(u, v), found.normals[k])
        flat = (own - found.extents.centres[k]) @ np.stack((u, v), axis=1)
        assert (np.abs(flat) <= found.extents.half_sizes[k] + 1e-9).all()
        assert np.allclose(np.abs(flat).max(axis=0), found.extents.half_sizes[k])
        assert found.extents.half_sizes[k, 0] >= found.extents.half_sizes[k, 1]
    corners = found.extents.corners()
    assert np.allclose(np.einsum("kci,ki->kc", corners, found.normals) + found.offsets[:, None], 0.0)


@pytest.mark.jit
def test_points_at_edges_go_to_the_right_side(
    house: tuple[np.ndarray, np.ndarray, PlanarFeatures],
) -> None:
    """Between three noises and 0.4 m from an edge, where neighbourhoods mix but planes are apart."""
    points, sides, found = house
    inside = found.labels >= 0
    plane = np.array([np.bincount(found.labels[(sides == s) & inside]).argmax() for s in range(5)])
    away = np.abs(points @ found.normals.T + found.offsets)
    own = away[np.arange(len(points)), plane[sides]]
    away[np.arange(len(points)), plane[sides]] = np.inf
    edge = away.min(axis=1)
    near = (edge > 3 * NOISE) & (edge < 0.4) & (own < 3 * NOISE)
    assert near.sum() > 2000
    assert (found.labels[near] == plane[sides[near]]).mean() > 0.995


@pytest.mark.jit
def test_the_same_on_any_threads_and_again(
    house: tuple[np.ndarray, np.ndarray, PlanarFeatures],
) -> None:
    points, _, found = house
    for threads in (1, 3):
        again = detect_planes(points, PlaneSettings(threads=threads))
        assert np.array_equal(again.labels, found.labels)
        assert np.array_equal(again.normals, found.normals)
        assert np.array_equal(again.extents.half_sizes, found.extents.half_sizes)


@pytest.mark.jit
def test_a_building_without_a_roof_is_compressed() -> None:
    """The figure of the source paper: 3,200 points become features with 95 % fewer numbers."""
    points, sides = box((15.0, 10.0, 8.0), 8.0, roof=False)
    assert len(points) == 3200
    found = detect_planes(turned(points))
    assert len(found) == 4
    assert agreement(found.labels, sides).right > 0.97
    saved = compression(found)
    assert saved is not None
    assert saved >= 0.95


@pytest.mark.jit
def test_a_town_with_strays() -> None:
    town = synthetic_town(SyntheticSettings(points=140_000, blocks=(1, 1)))
    assert (town.labels < 0).mean() == pytest.approx(0.05)
    scores = []
    for seed in range(3):
        found = detect_planes(town.points, PlaneSettings(seed=seed))
        score = agreement(found.labels, town.labels)
        assert score.recall >= 0.95  # 41 planes: two may be lost
        assert score.precision >= 0.9
        assert score.right > 0.985
        assert score.strays < 0.03
        scores.append((len(found), int((found.labels >= 0).sum())))
    counts, inside = np.array(scores).T
    assert np.ptp(counts) <= 3
    assert np.ptp(inside) <= 0.02 * inside.min()


@pytest.mark.jit
def test_a_ball_of_strays_has_no_plane() -> None:
    random = np.random.default_rng(2)
    found = detect_planes(random.uniform(-2.0, 2.0, (20_000, 3)))
    assert len(found) == 0
    assert (found.labels == NO_PLANE).all()


@pytest.mark.jit
def test_steps_are_two_planes_and_gaps_divide() -> None:
    random = np.random.default_rng(4)
    flat = random.uniform(size=(6000, 3)) * (10.0, 10.0, 0.0)
    step = flat + np.array((10.0, 0.0, 0.25))
    beyond = flat + np.array((24.0, 0.0, 0.0))
    points = np.concatenate((flat, step, beyond)) + random.normal(0.0, 0.01, (18_000, 3))
    found = detect_planes(points)
    score = agreement(found.labels, np.repeat(np.arange(3, dtype=np.int32), 6000))
    assert len(found) == 3
    assert score.right > 0.99


@pytest.mark.jit
def test_dense_spots_are_thinned_and_all_points_labelled() -> None:
    """A scanner on the floor: the density falls with the square of the distance."""
    random = np.random.default_rng(5)
    away, turn = np.exp(random.uniform(np.log(0.02), np.log(12.0), 60_000)), random.uniform(0, 7, 60_000)
    floor = np.stack((away * np.cos(turn), away * np.sin(turn), random.normal(0, 0.005, 60_000)), axis=1)
    found = detect_planes(floor)
    near = away < 1.0
    assert (found.labels[near] == 0).mean() > 0.98
    assert abs(found.normals[0, 2]) > 0.9999


def test_normals_look_up() -> None:
    from tilesnav_ref.planar.moments import upward  # noqa: PLC0415 - used here alone

    normals = np.array([(0, 0, -1.0), (0, -1.0, 1e-12), (-1.0, 0, 0), (0.6, 0.0, 0.8), (0.6, 0.8, 0.0)])
    expected = [(0, 0, 1), (0, 1, -1e-12), (1, 0, 0), (0.6, 0, 0.8), (0.6, 0.8, 0)]
    assert np.allclose(upward(normals), expected, atol=0)


def test_few_points_have_no_plane() -> None:
    for count in (0, 1, 5, 20):
        found = detect_planes(np.zeros((count, 3)))
        assert len(found) == 0
        assert found.labels.tolist() == [NO_PLANE] * count
        assert found.extents.corners().shape == (0, 4, 3)


@pytest.mark.jit
def test_points_in_one_place_or_on_a_line_are_no_error() -> None:
    line = np.linspace(0.0, 1.0, 200)[:, None] * np.array((1.0, 2.0, 3.0))
    for points in (np.ones((200, 3)), line):
        found = detect_planes(points)
        assert np.isfinite(found.normals).all()
        assert np.isfinite(found.extents.half_sizes).all()


@pytest.mark.parametrize("noise", [0.0, 1e-9])
def test_points_without_noise_have_their_planes(noise: float) -> None:
    """Angles are measured by the deviation of local normals, which is zero on the sides of an exact cube."""
    side = np.stack(np.meshgrid(*[np.linspace(0.0, 4.0, 25)] * 2), axis=-1).reshape(-1, 2)
    sides = [np.insert(side, axis, at, axis=1) for axis in range(3) for at in (0.0, 4.0)]
    points = np.unique(np.concatenate(sides), axis=0)
    features = detect_planes(points + np.random.default_rng(0).normal(0.0, noise, points.shape))
    assert len(features) == 6
    assert np.allclose(np.sort(np.abs(features.normals), axis=1)[:, 2], 1.0, atol=1e-6)
    assert features.counts.sum() == len(points)


def test_bad_points() -> None:
    points = np.zeros((50, 3))
    points[7, 1] = np.nan
    with pytest.raises(ValueError, match="point 7"):
        detect_planes(points)
    with pytest.raises(ValueError, match="shape"):
        detect_planes(np.zeros((50, 2)))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("inlier_distance", -1.0),
        ("inlier_distance", math.nan),
        ("radius", math.inf),
        ("normal_sigmas", 0.0),
        ("min_points", 5),
        ("seed", -1),
        ("threads", -1),
    ],
)
def test_bad_settings(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=name):
        replace(PlaneSettings(), **{name: value})


def corner(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Three squares of 3 m that meet at a corner, and a few strays."""
    random = np.random.default_rng(11)
    parts = []
    for axis in range(3):
        part = random.uniform(0.0, 3.0, (count, 3))
        part[:, axis] = 0.0
        parts.append(part)
    strays = random.uniform(0.5, 3.0, (count // 20, 3))
    noise = random.normal(0.0, 0.01, (3 * count, 3))
    truth = np.append(np.repeat(np.arange(3), count), np.full(count // 20, -1)).astype(np.int32)
    return np.concatenate((np.concatenate(parts) + noise, strays)), truth


def test_a_corner_of_few_points() -> None:
    """Small enough to run without compiled kernels."""
    points, truth = corner(150)
    found = detect_planes(turned(points), PlaneSettings(min_points=40))
    score = agreement(found.labels, truth)
    assert (score.recall, score.precision) == (1.0, 1.0)
    assert score.right > 0.97
    assert score.strays < 0.3


def test_features_do_not_depend_on_the_seed_by_much() -> None:
    points, truth = corner(150)
    for seed in (1, 2**31 - 1):
        found = detect_planes(points, PlaneSettings(min_points=40, seed=seed))
        assert len(found) == 3
        assert agreement(found.labels, truth).right > 0.96
