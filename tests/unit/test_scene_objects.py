"""Objects, contents and the order of faces."""

from __future__ import annotations

import numpy as np

from tilesnav_ref.scene import SceneSettings
from tilesnav_ref.scene.arrange import Unarranged, arrange, morton
from tilesnav_ref.scene.objects import form_objects, kd_groups, merge_small

STEPS = 1024


def fans(places: list[tuple[float, float]], counts: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Strips of triangles, each a component, at places in metres."""
    vertices, faces = [], []
    for (x, y), count in zip(places, counts, strict=True):
        first = len(vertices)
        vertices += [(x * STEPS + k * 8, y * STEPS + k % 2 * 64, 0) for k in range(count + 2)]
        faces += [(first + k, first + k + 1, first + k + 2) for k in range(count)]
    return np.array(vertices, np.int64), np.array(faces, np.int64)


def test_components_are_objects_and_small_ones_join_the_nearest() -> None:
    vertices, faces = fans([(0, 0), (3, 0), (20, 0), (22, 0)], [20, 3, 30, 4])
    objects, names = form_objects(vertices, faces, np.zeros(len(faces), np.int64), ("town",), SceneSettings())
    assert objects.tolist() == [0] * 23 + [1] * 34
    assert names == ("town#0", "town#2")


def test_small_objects_join_each_other_until_they_are_large_enough() -> None:
    vertices, faces = fans([(k, 0) for k in range(8)], [4] * 8)
    objects, _ = form_objects(vertices, faces, np.zeros(len(faces), np.int64), ("a",), SceneSettings())
    assert np.bincount(objects).min() >= 16


def test_objects_out_of_reach_stay_alone() -> None:
    vertices, faces = fans([(0, 0), (100, 0)], [3, 3])
    labels = np.repeat([0, 1], 3)
    assert merge_small(vertices, faces, labels, SceneSettings()).tolist() == labels.tolist()
    assert not merge_small(vertices, faces, labels, SceneSettings(object_reach=200)).any()


def test_long_ground_of_two_faces_stays_alone() -> None:
    vertices, faces = fans([(0, 0)], [20])
    ground = np.array([(-90, -90, 0), (90, -90, 0), (90, 90, 0), (-90, 90, 0)]) * STEPS
    faces = np.concatenate((faces, np.array([(0, 1, 2), (0, 2, 3)]) + len(vertices)))
    vertices = np.concatenate((vertices, ground))
    objects, _ = form_objects(vertices, faces, np.zeros(22, np.int64), ("a",), SceneSettings())
    assert objects.tolist() == [0] * 20 + [1] * 2


def test_parts_of_a_file_are_objects_even_where_they_touch() -> None:
    vertices, faces = fans([(0, 0)], [40])
    part = np.repeat([1, 0], 20)
    objects, names = form_objects(vertices, faces, part, ("roof", "wall"), SceneSettings())
    assert objects.tolist() == [0] * 20 + [1] * 20
    assert names == ("wall", "roof")


def test_large_objects_are_divided_in_space() -> None:
    vertices, faces = fans([(0, 0)], [1000])
    settings = SceneSettings(object_faces_max=100)
    objects, names = form_objects(vertices, faces, np.zeros(1000, np.int64), ("long",), settings)
    sizes = np.bincount(objects)
    assert sizes.max() <= 100
    assert sizes.min() >= 50
    assert sorted(names) == sorted(f"long#0/{k}" for k in range(len(sizes)))
    for k in range(len(sizes)):  # each a run along the strip
        assert np.ptp(np.flatnonzero(objects == k)) == sizes[k] - 1


def test_groups_hold_every_point_once_and_no_more_than_the_limit() -> None:
    generator = np.random.default_rng(1)
    points = generator.integers(-1000, 1000, (200, 3))
    weights = generator.integers(1, 50, 200)
    groups = kd_groups(points, weights, 120)
    assert sorted(np.concatenate(groups).tolist()) == list(range(200))
    assert max(weights[g].sum() for g in groups) <= 120
    assert [len(g) for g in kd_groups(points[:1], np.array([500]), 10)] == [1]
    assert sum(len(g) for g in kd_groups(np.zeros((9, 3), np.int64), np.full(9, 7), 10)) == 9


def test_order_never_goes_back() -> None:
    vertices, faces = fans([(30 * (k % 6), 30 * (k // 6)) for k in range(36)], [20 + k for k in range(36)])
    object_of = np.repeat(np.arange(36), [20 + k for k in range(36)])
    names = tuple(f"house {k}" for k in range(36))
    mesh = Unarranged(vertices, faces, object_of, names)
    scene, order = arrange(mesh, 150, -10, np.eye(4))
    assert sorted(order.tolist()) == list(range(len(faces)))
    assert np.array_equal(scene.faces, faces[order])
    assert (np.diff(scene.face_object) >= 0).all()
    assert (np.diff(scene.object_content) >= 0).all()
    assert scene.object_count == 36
    for k, name in enumerate(scene.object_names):
        assert set(object_of[order[scene.face_object == k]]) == {names.index(name)}
    sizes = np.bincount(scene.object_content[scene.face_object])
    assert sizes.max() <= 150
    assert scene.content_count == len(sizes) > 5


def test_scene_without_faces_is_empty() -> None:
    none = np.zeros((0, 3), np.int64)
    scene, order = arrange(Unarranged(none, none, np.zeros(0, np.int64), ()), 10, -10, np.eye(4))
    assert (scene.face_count, scene.object_count, scene.content_count, len(order)) == (0, 0, 0, 0)


def test_morton_interleaves_from_the_lowest_bit() -> None:
    origin = -(1 << 23)
    points = np.array([(0, 0, 0), (8, 0, 0), (0, 8, 0), (0, 0, 8), (16, 0, 0), (7, 7, 7)]) + origin
    assert morton(points).tolist() == [0, 1, 2, 4, 8, 0]
    assert morton(np.array([[(1 << 23) - 1] * 3])).tolist() == [(1 << 63) - 1]
