"""Contraction within an error, and what the levels of a scene state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from levels_reference import farthest, plate, recessed

from tilesnav_ref.levels import CoarseLevel, LevelSettings, coarse_levels
from tilesnav_ref.levels.simplify import ROUNDING, simplify_object
from tilesnav_ref.scene.arrange import morton
from tilesnav_ref.scene.build import Soup, build_scene
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.scene.sample import TownSettings, make_town
from tilesnav_ref.scene.settings import SceneSettings


def scene_of(*parts: tuple[np.ndarray, np.ndarray]) -> Scene:
    before = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    soup = Soup(
        np.concatenate([vertices for vertices, _ in parts]),
        np.concatenate([faces + before[k] for k, (_, faces) in enumerate(parts)]),
        np.repeat(np.arange(len(parts)), [len(faces) for _, faces in parts]),
        tuple(f"part {k}" for k in range(len(parts))),
    )
    return build_scene(soup, SceneSettings(object_faces_min=1)).scene


def check_level(fine: Scene, level: CoarseLevel, parts: int) -> None:
    """The error holds through the map, at points of a lattice; the map covers both sides."""
    coarse = level.scene
    assert len(level.offsets) == coarse.face_count + 1
    assert set(level.fine_faces.tolist()) == set(range(fine.face_count))
    assert (np.diff(level.offsets) > 0).all()
    rows = np.repeat(np.arange(coarse.face_count), np.diff(level.offsets))
    assert (fine.face_object[level.fine_faces] == coarse.face_object[rows]).all()
    pairs = np.stack((rows, level.fine_faces), axis=1)
    assert (np.lexsort((pairs[:, 1], pairs[:, 0])) == np.arange(len(pairs))).all()
    assert len(np.unique(pairs, axis=0)) == len(pairs)
    errors = level.errors / fine.step
    one, other = fine.corners().astype(float), coarse.corners().astype(float)
    for face in range(fine.face_count):
        standing = other[rows[level.fine_faces == face]]
        assert farthest(one[face], standing, parts) <= errors[fine.face_object[face]]
    for face in range(coarse.face_count):
        listed = level.fine_faces[level.offsets[face] : level.offsets[face + 1]]
        assert farthest(other[face], one[listed], parts) <= errors[coarse.face_object[face]]


def test_a_flat_plate_becomes_two_faces_without_an_error() -> None:
    vertices, faces = plate(4, 3)
    found = simplify_object(vertices, faces, 100.0)
    assert len(found.faces) == 2
    assert found.error <= 100.0 / 64 + ROUNDING


def test_an_open_border_is_kept() -> None:
    """A hole of three squares is no point of the plate: what closes it is 1.5 squares away."""
    vertices, faces = plate(7, 7)
    middle = vertices[faces].mean(axis=1)
    hole = (np.abs(middle[:, :2] - 3.5 * 1024) < 1.5 * 1024).all(axis=1)
    found = simplify_object(vertices, faces[~hole], 200.0)
    assert len(found.faces) == 8
    a, b, c = vertices[found.faces].swapaxes(0, 1)
    assert np.cross(b - a, c - a)[:, 2].sum() / 2 == (49 - 9) * 1024**2


@pytest.mark.parametrize(("bound", "count"), [(200, 2), (100, 18)])
def test_a_recess_goes_where_the_error_allows_it(bound: int, count: int) -> None:
    vertices, faces = recessed(128)
    found = simplify_object(vertices, faces, float(bound))
    assert len(found.faces) == count
    assert found.error <= bound + ROUNDING
    if count == 2:
        assert found.error >= 128


def test_faces_that_cannot_be_simplified_stand_for_themselves() -> None:
    tetrahedron = np.array([[0, 0, 0], [4096, 0, 0], [0, 4096, 0], [0, 0, 4096]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    found = simplify_object(tetrahedron, faces, 50.0)
    assert np.array_equal(found.faces, faces)
    assert found.error == ROUNDING
    assert np.array_equal(found.pairs, np.stack((np.arange(4), np.arange(4)), axis=1))


def test_levels_of_a_scene() -> None:
    scene = scene_of(recessed(128), (plate(3, 3)[0] + (0, 0, 9000), plate(3, 3)[1]))
    levels = coarse_levels(scene, LevelSettings(3, (0.1, 0.2)))
    assert [level.level for level in levels] == [1, 2]
    for level in levels:
        check_level(scene, level, 8)
        assert level.errors.shape == (scene.object_count,)
        assert (level.errors <= (0.1, 0.2)[level.level - 1] + ROUNDING * scene.step).all()
        assert set(map(tuple, level.scene.vertices[level.scene.faces].reshape(-1, 3))) <= set(
            map(tuple, scene.vertices)
        )
    assert levels[1].scene.face_count < levels[0].scene.face_count < scene.face_count


def test_faces_of_a_level_are_numbered_along_the_curve() -> None:
    """As those of the scene are: what sends faces counts on neighbours with numbers near each other."""
    scene = scene_of(recessed(128), (plate(3, 3)[0] + (0, 0, 9000), plate(3, 3)[1]))
    level = coarse_levels(scene, LevelSettings(2, (0.1,)))[0].scene
    places = morton(level.vertices[level.faces].sum(axis=1) // 3)
    assert np.bincount(level.face_object).min() > 1
    assert np.array_equal(np.lexsort((places, level.face_object)), np.arange(level.face_count))


def test_the_number_of_threads_changes_nothing() -> None:
    scene = scene_of(recessed(128), (plate(3, 3)[0] + (0, 0, 9000), plate(3, 3)[1]))
    steps: list[tuple[int, int]] = []
    one = coarse_levels(scene, LevelSettings(2), lambda *step: steps.append(step), threads=1)[0]
    two = coarse_levels(scene, LevelSettings(2), threads=3)[0]
    assert steps[-1] == (2, 2)
    assert np.array_equal(one.scene.faces, two.scene.faces)
    assert np.array_equal(one.fine_faces, two.fine_faces)
    assert np.array_equal(one.errors, two.errors)


def test_one_level_is_the_finest() -> None:
    assert coarse_levels(scene_of(plate(1, 1)), LevelSettings()) == ()


@pytest.mark.jit
@pytest.mark.slow
def test_levels_of_the_town_hold_their_errors() -> None:
    town = make_town(TownSettings(detail="fine", width=25, depth=25))
    for level in coarse_levels(town, LevelSettings(3)):
        check_level(town, level, 8)
        assert level.scene.face_count < town.face_count / 4


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"levels": 0}, "levels"),
        ({"levels": 4}, "levels"),
        ({"levels": 3, "level_errors": (0.1,)}, "level_errors"),
        ({"level_errors": (0.2, 0.1)}, "level_errors"),
        ({"level_errors": (0.0, 0.1)}, "level_errors"),
        ({"level_errors": (0.1, float("nan"))}, "level_errors"),
    ],
)
def test_settings_that_make_no_sense(changes: dict[str, object], named: str) -> None:
    with pytest.raises(ValueError, match=f"setting {named}: found"):
        replace(LevelSettings(), **changes)
