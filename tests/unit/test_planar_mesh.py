"""Planar features become a mesh without cracks, near what was measured, with few faces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from planar_fixture import distances_to_triangles, features_of, labelled_scene, sample_triangles

from tilesnav_ref.planar import PlanarFeatures
from tilesnav_ref.planar.mesh import PlanarMesh, mesh_planes
from tilesnav_ref.planar.mesh_settings import MeshSettings
from tilesnav_ref.planar.outline import Frame, find_outline
from tilesnav_ref.scene.sample import TownSettings, make_town

FLAT = Frame(np.zeros(3), np.eye(3)[:2])
CUBE = np.array([[x, y, z] for x in (0.0, 4.0) for y in (0.0, 5.0) for z in (0.0, 3.0)])
SIDES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def cloud_of(
    sides: tuple[tuple[int, ...], ...], seed: int = 0
) -> tuple[np.ndarray, PlanarFeatures, np.ndarray]:
    """Noisy points on sides of a box, their features, and the true triangles."""
    corners = np.array([CUBE[[a, b, c]] for a, b, c, d in sides] + [CUBE[[a, c, d]] for a, b, c, d in sides])
    points, owner = sample_triangles(corners, 100.0, 0.01, seed)
    return points, features_of(points, owner % len(sides)), corners


def edge_counts(mesh: PlanarMesh) -> np.ndarray:
    """How many faces each edge has."""
    edges = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return np.unique(edges, axis=0, return_counts=True)[1]


def test_a_closed_box_comes_back_closed_with_twelve_faces() -> None:
    points, features, corners = cloud_of(SIDES)
    mesh = mesh_planes(points, features)
    assert len(mesh.faces) == 12
    assert len(mesh.vertices) == 8
    assert (edge_counts(mesh) == 2).all()
    near = np.linalg.norm(mesh.vertices[:, None] - CUBE[None], axis=2).min(axis=1)
    assert near.max() < 0.01
    assert np.bincount(mesh.face_plane).tolist() == [2] * 6
    assert corners.shape == (12, 3, 3)


def test_where_nothing_was_measured_the_mesh_stays_open() -> None:
    """Without its floor and one wall, the box has no face there; the borders are where the points end."""
    points, features, _ = cloud_of(SIDES[:3] + SIDES[5:])
    mesh = mesh_planes(points, features)
    assert len(features) == 4
    counts = edge_counts(mesh)
    assert (counts == 1).any()
    assert counts.max() == 2
    corners = mesh.vertices[mesh.faces]
    gap = np.array([[2.0, 5.0, 1.5], [2.0, 2.5, 0.0]])
    assert distances_to_triangles(gap, corners).min() > 1.4


def test_faces_run_counter_clockwise_about_the_normal_of_their_plane() -> None:
    points, features, _ = cloud_of(SIDES)
    mesh = mesh_planes(points, features)
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("fk,fk->f", normals, features.normals[mesh.face_plane]) > 0).all()


def test_an_outline_has_the_window_and_not_the_gaps_of_chance() -> None:
    rng = np.random.default_rng(1)
    flat = rng.random((4000, 2)) * (10.0, 6.0)
    flat = flat[~((np.abs(flat - (4.0, 3.0)) < (1.0, 0.75)).all(axis=1))]
    outline = find_outline(np.column_stack((flat, np.zeros(len(flat)))), FLAT, MeshSettings())
    (part,) = outline.shape.geoms
    assert len(part.interiors) == 1
    # 39 m of border lie inside the truth by up to a spacing of 8 cm
    assert 57.0 - 3.1 < outline.shape.area < 57.0 + 0.1
    assert outline.shape.is_valid


def test_points_on_a_line_have_no_area() -> None:
    line = np.outer(np.linspace(0.0, 5.0, 60), (1.0, 0.0, 0.0))
    assert find_outline(line, FLAT, MeshSettings()).shape.is_empty


def test_two_parts_of_a_feature_are_two_polygons() -> None:
    rng = np.random.default_rng(2)
    flat = np.vstack((rng.random((500, 2)), rng.random((500, 2)) - (5.0, 0.0)))
    outline = find_outline(np.column_stack((flat, np.zeros(1000))), FLAT, MeshSettings())
    assert len(outline.shape.geoms) == 2
    assert outline.shape.area < 2.2


@pytest.fixture(scope="module")
def town() -> tuple[np.ndarray, np.ndarray, PlanarFeatures, PlanarMesh]:
    scene = make_town(TownSettings(width=25, depth=25))
    points, features = labelled_scene(scene, 40.0)
    return scene.corners() * scene.step, points, features, mesh_planes(points, features)


def test_the_town_is_within_3_cm_both_ways_with_fewer_faces_than_the_truth(
    town: tuple[np.ndarray, np.ndarray, PlanarFeatures, PlanarMesh],
) -> None:
    truth, points, features, mesh = town
    corners = mesh.vertices[mesh.faces]
    on_mesh, _ = sample_triangles(corners, 5.0, 0.0, 3)
    on_truth, _ = sample_triangles(truth, 5.0, 0.0, 4)
    assert np.quantile(distances_to_triangles(on_mesh, truth), 0.95) < 0.03
    assert np.quantile(distances_to_triangles(on_truth, corners), 0.95) < 0.03
    assert len(mesh.faces) < len(truth)
    assert np.quantile(mesh.inlier_distances(points, features), 0.95) < 0.06


def test_most_of_the_length_of_its_edges_is_shared(
    town: tuple[np.ndarray, np.ndarray, PlanarFeatures, PlanarMesh],
) -> None:
    """Open are the border of the ground and walls that stand on the middle of another plane."""
    mesh = town[3]
    edges = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, counts = np.unique(edges, axis=0, return_counts=True)
    lengths = np.linalg.norm(mesh.vertices[unique[:, 0]] - mesh.vertices[unique[:, 1]], axis=1)
    assert lengths[counts == 1].sum() < 0.25 * lengths.sum()


def test_the_same_points_give_the_same_mesh() -> None:
    points, features, _ = cloud_of(SIDES)
    first, second = mesh_planes(points, features), mesh_planes(points.copy(), features)
    assert np.array_equal(first.vertices, second.vertices)
    assert np.array_equal(first.faces, second.faces)


def test_no_feature_gives_an_empty_mesh() -> None:
    points, features, _ = cloud_of(SIDES)
    none = replace(
        features,
        normals=features.normals[:0],
        offsets=features.offsets[:0],
        centroids=features.centroids[:0],
        labels=np.full(len(points), -1, np.int32),
    )
    mesh = mesh_planes(points, none)
    assert mesh.vertices.shape == (0, 3)
    assert mesh.faces.shape == (0, 3)


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_a_setting_that_is_not_positive_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match="mesh setting reach: found"):
        MeshSettings(reach=value)
