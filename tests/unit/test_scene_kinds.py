"""Parts that are porous or one-sided are chosen by the names of parts, meshes and materials."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from tilesnav_ref.scene import SceneError, SceneSettings, load_scene
from tilesnav_ref.scene.build import Soup, build_scene
from tilesnav_ref.scene.kinds import NAMES_SHOWN, ONE_SIDED, POROUS, part_kinds

OBJ = """# two objects, the first with two materials
mtllib town.mtl
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 5
v 1 0 5
v 0 1 5
v 3 0 9
o tree_1
usemtl bark
f 1 2 3
usemtl leaves
f 4 5 6
o house
usemtl bark
f 1 2 7
"""


def boxes(path: Path, names: list[tuple[str, str, str]], step: float = 1.0) -> Path:
    """Write boxes a step apart; each has the name of a node, of a mesh and of a material."""
    scene = trimesh.Scene()
    for k, (node, mesh, material) in enumerate(names):
        box = trimesh.creation.box((0.5, 0.5, 0.5))
        box.apply_translation((k * step, 0, 0))
        look = trimesh.visual.material.PBRMaterial(name=material)
        box.visual = trimesh.visual.TextureVisuals(uv=np.zeros((len(box.vertices), 2)), material=look)
        scene.add_geometry(box, node_name=node, geom_name=mesh)
    path.write_bytes(scene.export(file_type="glb"))
    return path


THREE = [("oak 1", "crown", "leaf"), ("oak 2", "crown2", "bark"), ("house", "walls", "brick")]


def porous_parts(path: Path, *patterns: str) -> list[bool]:
    """Whether the faces of each part of `THREE` are porous, by their places."""
    scene, _ = load_scene(path, SceneSettings(transparent=patterns))
    at = np.rint(scene.corners()[:, :, 0].mean(axis=1) / 1024).astype(int)
    return [bool(scene.porous[at == k].all() and scene.porous[at == k].any()) for k in range(3)]


@pytest.mark.parametrize(
    ("patterns", "expected"),
    [
        (("oak*",), [True, True, False]),
        (("oak ?", "ho*"), [True, True, True]),
        (("crown",), [True, False, False]),
        (("bark",), [False, True, False]),
        (("[lb]*",), [True, True, True]),
    ],
)
def test_patterns_match_nodes_meshes_and_materials(
    tmp_path: Path, patterns: tuple[str, ...], expected: list[bool]
) -> None:
    assert porous_parts(boxes(tmp_path / "three.glb", THREE), *patterns) == expected


@pytest.mark.parametrize("name", ["pine", "Oak*", "oak", ""])
def test_a_pattern_that_matches_nothing_is_refused_with_all_names(tmp_path: Path, name: str) -> None:
    path = boxes(tmp_path / "three.glb", THREE)
    for settings in (SceneSettings(transparent=("oak*", name)), SceneSettings(one_sided=(name,))):
        with pytest.raises(SceneError) as error:
            load_scene(path, settings)
        for part in (str(path), repr(name), "'oak 1'", "'walls'", "'brick'"):
            assert part in str(error.value)


def test_a_long_list_of_names_is_cut() -> None:
    labels = [(f"part {k:04d}",) for k in range(NAMES_SHOWN + 5)]
    with pytest.raises(SceneError, match="and 5 more") as error:
        part_kinds(labels, ("x",), (), "town.glb")
    assert "part 0040" not in str(error.value)


def test_both_kinds_add_up() -> None:
    labels = [("a",), ("b",), ("ab",)]
    assert part_kinds(labels, ("a*",), ("*b",), "f").tolist() == [POROUS, ONE_SIDED, POROUS + ONE_SIDED]


def test_materials_of_obj_files_divide_objects(tmp_path: Path) -> None:
    path = tmp_path / "town.obj"
    path.write_text(OBJ)  # its library of materials is missing, and not needed
    for pattern, heights in (("leaves", {5}), ("bark", {0, 9}), ("tree_1*", {0, 5}), ("*", {0, 5, 9})):
        scene, _ = load_scene(path, SceneSettings(transparent=(pattern,)))
        tops = scene.corners()[:, :, 2].max(axis=1) // 1024
        assert set(tops[scene.porous].tolist()) == heights, pattern


def test_without_patterns_names_and_flags_are_as_ever(tmp_path: Path) -> None:
    path = tmp_path / "town.obj"
    path.write_text(OBJ)
    scene, _ = load_scene(path)
    assert len(scene.object_porous) == len(scene.object_one_sided) == 0
    assert not scene.porous.any()
    assert not scene.one_sided.any()
    assert not any("bark" in name for name in scene.object_names)


def test_objects_are_not_merged_across_the_border(tmp_path: Path) -> None:
    small = [(f"{'tree' if k % 2 else 'post'} {k}", f"mesh {k}", "m") for k in range(8)]
    path = boxes(tmp_path / "row.glb", small)
    together, _ = load_scene(path)
    scene, _ = load_scene(path, SceneSettings(transparent=("tree*",), one_sided=("post 0",)))
    assert together.object_count < 8
    assert scene.object_count < 8
    at = np.rint(scene.corners()[:, :, 0].mean(axis=1) / 1024).astype(int)
    assert np.array_equal(scene.porous, at % 2 == 1)
    assert np.array_equal(scene.one_sided, at == 0)


def test_parts_of_divided_faces_and_objects_keep_their_kind() -> None:
    corners = np.array([(0, 0, 0), (8, 0, 0), (0, 8, 0), (4, 0, 0), (4, 0, 8), (5, 0, 8)]) * 1024
    faces = np.array([(0, 1, 2), (3, 4, 5)])
    soup = Soup(corners, faces, np.array([0, 1]), ("leaf", "post"), np.array([POROUS, 0]))
    built = build_scene(soup, SceneSettings())
    assert built.scene.face_count == 3  # the foot of the post divides an edge of the leaf
    assert built.scene.porous.tolist() == [bool(source == 0) for source in built.source]
    assert built.scene.object_one_sided.tolist() == []


def test_a_region_without_trees_is_no_fault_of_the_pattern(tmp_path: Path) -> None:
    path = boxes(tmp_path / "three.glb", THREE, step=200.0)
    scene, _ = load_scene(path, SceneSettings(transparent=("oak*",), region=(390, -10, 410, 10)))
    assert scene.face_count == 12
    assert not scene.porous.any()


def test_lines_in_a_glb_file_take_no_name_from_its_faces(tmp_path: Path) -> None:
    path = boxes(tmp_path / "three.glb", THREE)
    data = path.read_bytes()
    mode = b'"mode":4'
    if mode not in data:
        mode = b'"mode": 4'
    path.write_bytes(data.replace(mode, mode[:-1] + b"1", 1))  # the first becomes lines
    with pytest.raises(SceneError, match="'bark'") as error:
        load_scene(path, SceneSettings(transparent=("pine",)))
    assert "'leaf'" not in str(error.value)
