"""Pictures of planar features: what they show is computed apart from the drawing, and is checked here."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tilesnav_ref.planar.deviations import in_plane, normal_deviations
from tilesnav_ref.planar.model import PlanarFeatures, Rectangles
from tilesnav_ref.planar.picture import (
    GREY,
    PictureError,
    draw_features,
    draw_normal_deviations,
    feature_colours,
    fullest_wall,
)
from tilesnav_ref.planar.raster import rasterise

PLANES = (
    # normal, first axis, second axis, half sizes, centre
    ((0, 0, 1), (1, 0, 0), (0, 1, 0), (10, 6), (0, 0, 0)),
    ((0, 1, 0), (0, 0, 1), (1, 0, 0), (5, 4), (0, 6, 5)),
    ((1, 0, 0), (0, 1, 0), (0, 0, 1), (2, 2), (10, 0, 2)),
)


def sheets(count: int, noise: float) -> tuple[np.ndarray, PlanarFeatures]:
    """A floor and two walls, points evenly at random with noise along the normals, and 50 stray points."""
    random = np.random.default_rng(5)
    normals, first, second, half, centres = (
        np.array([plane[k] for plane in PLANES], float) for k in range(5)
    )
    parts = []
    for k in range(len(PLANES)):
        u, v = (random.uniform(-1, 1, (2, count)) * half[k][:, None])[:, :, None]
        away = random.normal(0, noise, (count, 1))
        parts.append(centres[k] + u * first[k] + v * second[k] + away * normals[k])
    points = np.concatenate([*parts, random.uniform(-5, 15, (50, 3))])
    labels = np.append(np.repeat(np.arange(3), count), np.full(50, -1)).astype(np.int32)
    features = PlanarFeatures(
        normals=normals,
        offsets=-(normals * centres).sum(axis=1),
        centroids=centres,
        covariances=np.zeros((3, 3, 3)),
        rms=np.full(3, noise),
        counts=np.full(3, count),
        extents=Rectangles(centres, np.stack((first, second), axis=1), half),
        labels=labels,
        inlier_distance=4 * noise,
        normal_deviation=0.1,
    )
    return points, features


def test_deviations_have_the_spread_that_noise_gives() -> None:
    """On an even square patch, half-width h, a fitted slope has the deviation noise / (h sqrt(n / 3))."""
    points, features = sheets(20_000, 0.01)
    found = normal_deviations(points, features)
    assert found.features == 3
    assert 30_000 < len(found.across) <= 60_000
    random = np.random.default_rng(0)
    expected = []
    density = 20_000 / (4 * np.array([plane[3] for plane in PLANES], float).prod(axis=1))
    for places in density:
        radius = np.sqrt(32 / places / np.pi)  # the 32 nearest points fill a disc
        slopes = []
        for _ in range(400):
            r, turn = radius * np.sqrt(random.random(32)), random.random(32) * 2 * np.pi
            x, y, z = r * np.cos(turn), r * np.sin(turn), random.normal(0, 0.01, 32)
            slopes.append(np.linalg.lstsq(np.stack((x, y, np.ones(32)), axis=1), z, rcond=None)[0][0])
        expected.append(np.std(slopes))
    least, greatest = min(expected), max(expected)
    for spread in found.spread:
        assert 0.9 * least < spread < 1.2 * greatest  # edges and corners have wider neighbourhoods
    assert abs(np.median(found.across)) < 0.1 * found.spread[0]


def test_a_feature_with_a_wrong_normal_shows() -> None:
    points, features = sheets(5_000, 0.01)
    tilted = features.normals.copy()
    tilted[1] = (0.0, np.cos(0.2), np.sin(0.2))
    only = np.where(features.labels == 1, 1, -1).astype(np.int32)
    found = normal_deviations(points, replace(features, normals=tilted, labels=only))
    # The true normal, seen from the tilted one, leans down by 0.2 radians and not to the side.
    assert np.median(found.upwards) == pytest.approx(-np.sin(0.2), abs=0.005)
    assert np.median(found.across) == pytest.approx(0.0, abs=0.005)


def test_neighbours_are_of_the_same_feature() -> None:
    """Two sheets closer than the neighbours within each: mixed neighbourhoods would be thick."""
    points, features = sheets(3_000, 0.0)
    floor = points[:3_000]
    both = np.concatenate((floor, floor + np.array((0.0, 0.0, 0.05))))
    labels = np.repeat(np.array((0, 1), np.int32), 3_000)
    level = replace(features, normals=np.tile((0.0, 0.0, 1.0), (3, 1)), labels=labels)
    found = normal_deviations(both, level)
    assert found.features == 2
    assert max(np.abs(found.across).max(), np.abs(found.upwards).max()) < 1e-6


def test_rings_of_a_scanner_say_nothing() -> None:
    along = np.linspace(0, 10, 400)
    ring = np.stack((along, np.zeros(400), np.random.default_rng(1).normal(0, 0.01, 400)), axis=1)
    _, features = sheets(100, 0.01)
    found = normal_deviations(ring, replace(features, labels=np.zeros(400, np.int32)))
    assert len(found.across) == 0
    assert found.spread == (0.0, 0.0)


def test_directions_in_planes() -> None:
    normals = np.array([(0, 0, 1), (1, 0, 0), (0.6, 0, 0.8), (0, -0.6, 0.8)], float)
    level, steep = in_plane(normals)
    assert np.allclose((level * normals).sum(axis=1), 0)
    assert np.allclose(np.cross(level, steep), normals)
    assert np.allclose(level[1:, 2], 0)
    assert level[0].tolist() == [1, 0, 0]
    assert (steep[1:, 2] > 0).all()


def test_nearer_points_are_drawn_over_farther_ones() -> None:
    flat = np.array([(0.0, 0.0), (0.0, 0.0), (9.0, 4.0)])
    colours = np.eye(3)
    image = rasterise(flat, np.array((2.0, 1.0, 0.0)), colours, 90)
    assert image.extent[0] == 0.0
    assert image.extent[2] == 0.0
    assert image.extent[1] == pytest.approx(9.1)
    assert image.pixels.shape[:2] == (41, 91)
    assert image.pixels[-1, 0].tolist() == colours[1].tolist()
    assert image.pixels[0, -1].tolist() == colours[2].tolist()
    assert image.pixels[20, 45].tolist() == [1, 1, 1]
    assert not (image.pixels == colours[0]).all(axis=2).any()


def test_dots_fill_the_gaps_between_even_points() -> None:
    side = np.arange(60) * 5.0
    flat = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    image = rasterise(flat, np.zeros(len(flat)), np.zeros((len(flat), 3)), 295)
    assert (image.pixels.sum(axis=2) == 0).mean() > 0.95


def test_colours() -> None:
    _, features = sheets(10, 0.01)
    colours = feature_colours(features)
    assert np.allclose(colours[-50:], GREY)
    assert len(np.unique(colours[:30], axis=0)) == 3
    assert np.abs(colours[0] - colours[10]).max() > 0.3


def test_wall_with_most_points() -> None:
    _, features = sheets(10, 0.01)
    assert fullest_wall(replace(features, counts=np.array((90, 20, 30)))) == 2
    assert fullest_wall(replace(features, counts=np.array((90, 40, 30)))) == 1
    assert fullest_wall(replace(features, normals=np.tile((0.0, 0.0, 1.0), (3, 1)))) is None


@pytest.mark.parametrize("draw", [draw_features, draw_normal_deviations])
def test_pictures_are_written_and_equal_each_time(draw: object, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="pictures are an extra")
    points, features = sheets(2_000, 0.01)
    for name in ("a.png", "b.png"):
        draw(points, features, tmp_path / name)  # type: ignore[operator]
    first = (tmp_path / "a.png").read_bytes()
    assert first[:4] == b"\x89PNG"
    assert first == (tmp_path / "b.png").read_bytes()


def test_what_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="pictures are an extra")
    points, features = sheets(100, 0.01)
    with pytest.raises(PictureError, match=r"'\.bmp'; allowed: \.png"):
        draw_features(points, features, tmp_path / "a.bmp")
    with pytest.raises(PictureError, match="is not a folder"):
        draw_features(points, features, tmp_path / "no" / "a.png")
    none = replace(features, labels=np.full(len(points), -1, np.int32))
    with pytest.raises(PictureError, match="no feature"):
        draw_normal_deviations(points, none, tmp_path / "a.png")
    with pytest.raises(PictureError, match="no points"):
        draw_features(points[:0], replace(features, labels=none.labels[:0]), tmp_path / "a.png")
    assert list(tmp_path.iterdir()) == []
