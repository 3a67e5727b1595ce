"""The ground between planes becomes a height field that its points lie on."""

from __future__ import annotations

import numpy as np
import pytest

from tilesnav_ref.planar.extents import rectangles
from tilesnav_ref.planar.ground import ground_points
from tilesnav_ref.planar.heightfield import HeightField, fill_ground
from tilesnav_ref.planar.mesh import PlanarMesh, mesh_planes
from tilesnav_ref.planar.mesh_settings import MeshSettings
from tilesnav_ref.planar.model import NO_PLANE, PlanarFeatures
from tilesnav_ref.planar.moments import moments_of

DISTANCE = 0.1


def hills() -> np.ndarray:
    """Points of a level half and of one that undulates by half a metre, 2 cm of noise, 4 a square metre."""
    random = np.random.default_rng(3)
    plan = random.random((6400, 2)) * 40.0
    height = np.where(plan[:, 0] > 20.0, 0.5 * np.sin((plan[:, 0] - 20.0) / 4.0), 0.0)
    return np.column_stack((plan, height + random.normal(0.0, 0.02, len(plan))))


def features_of(points: np.ndarray, labels: np.ndarray) -> PlanarFeatures:
    moments = moments_of(points, labels, int(labels.max()) + 1)
    normals, offsets, rms = moments.planes()
    extents = rectangles(points, labels, normals, moments.means)
    shape = (moments.means, moments.covariances(), rms, moments.counts)
    return PlanarFeatures(normals, offsets, *shape, extents, labels, DISTANCE, 0.05)


@pytest.fixture(scope="module")
def ground() -> tuple[np.ndarray, PlanarMesh, HeightField]:
    """The level half is a plane, the other is in none; a hole of 8 m has no points."""
    points = hills()
    points = points[np.abs(points[:, :2] - 30.0).max(axis=1) > 4.0]
    labels = np.where(points[:, 0] < 18.0, 0, NO_PLANE).astype(np.int32)
    features = features_of(points, labels)
    mesh = mesh_planes(points, features)
    every = np.ones(len(points), np.bool_)
    return points, mesh, fill_ground(points, every, features, mesh, MeshSettings())


def areas(field: HeightField) -> np.ndarray:
    corners = field.vertices[field.faces]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2.0


def test_it_covers_what_has_points_and_looks_up(ground: tuple[np.ndarray, PlanarMesh, HeightField]) -> None:
    field = ground[2]
    assert (areas(field) > 0).all()
    assert areas(field).sum() == pytest.approx(40 * 22 - 64, rel=0.06)
    middles = field.vertices[field.faces].mean(axis=1)
    assert not (np.abs(middles[:, :2] - 30.0).max(axis=1) < 2.5).any()
    assert len(field.faces) < 800


def test_its_heights_are_those_of_the_ground(ground: tuple[np.ndarray, PlanarMesh, HeightField]) -> None:
    middles = ground[2].vertices[ground[2].faces].mean(axis=1)
    true = np.where(middles[:, 0] > 20.0, 0.5 * np.sin((middles[:, 0] - 20.0) / 4.0), 0.0)
    assert np.quantile(np.abs(middles[:, 2] - true), 0.95) < DISTANCE


def test_the_border_of_the_plane_is_shared(ground: tuple[np.ndarray, PlanarMesh, HeightField]) -> None:
    _, mesh, field = ground
    edge = mesh.vertices[(mesh.vertices[:, 0] > 16.5) & (np.abs(mesh.vertices[:, 1] - 20.0) < 18.0)]
    assert len(edge) > 3
    assert set(map(tuple, edge.tolist())) <= set(map(tuple, field.vertices.tolist()))


def test_a_step_is_not_bridged() -> None:
    points = hills()
    points[:, 2] = np.where(points[:, 0] > 20.0, 3.0, 0.0)
    features = features_of(points, np.where(points[:, 0] < 10.0, 0, NO_PLANE).astype(np.int32))
    every = np.ones(len(points), np.bool_)
    field = fill_ground(points, every, features, mesh_planes(points, features), MeshSettings())
    heights = field.vertices[field.faces][:, :, 2]
    assert len(heights)
    assert (np.ptp(heights, axis=1) < 1.5).all()
    assert (np.minimum(np.abs(heights), np.abs(heights - 3.0)).max(axis=1) < 0.8).mean() > 0.9


def test_no_ground_and_no_gap_give_nothing() -> None:
    points = hills()
    features = features_of(points, np.zeros(len(points), np.int32))
    mesh = mesh_planes(points, features)
    assert not len(fill_ground(points, np.zeros(len(points), np.bool_), features, mesh, MeshSettings()).faces)


def test_ground_is_what_the_classes_say_or_the_lowest() -> None:
    points = hills()
    house = ((points[:, :2] > 10.0) & (points[:, :2] < 20.0)).all(axis=1)
    points[house, 2] += 6.0
    found = ground_points(points, None)
    assert not found[house].any()
    assert found[~house].mean() > 0.85  # the tops of the waves are higher than the rule allows
    classes = np.where(house, 6, 2).astype(np.uint8)
    assert (ground_points(points, classes) == ~house).all()
    assert (ground_points(points, np.zeros(len(points), np.uint8)) == found).all()
    assert ground_points(points[:0], None).shape == (0,)
