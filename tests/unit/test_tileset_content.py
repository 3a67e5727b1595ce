"""glTF contents equal the scene, read back by pygltflib and by our own reader."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pygltflib
import pytest
from test_tileset_small_map import STEP, small_scene

from tilesnav_ref.scene.model import Scene
from tilesnav_ref.stream.glb import open_glb
from tilesnav_ref.tileset.content import PRIMITIVE_RESTART, gltf_positions, make_content


def _accessor(document: pygltflib.GLTF2, index: int) -> np.ndarray:
    accessor = document.accessors[index]
    view = document.bufferViews[accessor.bufferView]
    dtype = {5126: "<f4", 5123: "<u2", 5125: "<u4"}[accessor.componentType]
    width = {"VEC3": 3, "SCALAR": 1}[accessor.type]
    begin = view.byteOffset + accessor.byteOffset
    return np.frombuffer(document.binary_blob(), dtype, accessor.count * width, begin).reshape(-1, width)


def _grid_faces(data: bytes, scene: Scene) -> list[np.ndarray]:
    """Corners of the faces of every primitive, grid coordinates."""
    document = pygltflib.GLTF2.load_from_bytes(data)
    result = []
    for primitive in document.meshes[0].primitives:
        x, y, z = _accessor(document, primitive.attributes.POSITION).astype(np.float64).T / scene.step
        nav = np.stack((x, -z, y), axis=1)
        result.append(nav[_accessor(document, primitive.indices)[:, 0]].reshape(-1, 3, 3))
    return result


def test_faces_come_back_in_order() -> None:
    scene = small_scene()
    contents = [make_content(scene, number) for number in range(2)]
    faces = [face for content in contents for face in _grid_faces(content.data, scene)]
    assert [len(face) for face in faces] == [2, 2, 1]
    assert np.array_equal(np.concatenate(faces), scene.corners())
    assert [(c.face_count, c.object_count) for c in contents] == [(4, 2), (1, 1)]
    assert contents[0].lower.tolist() == [0, 0, 0]
    assert contents[0].upper.tolist() == [8192, 4096, 3072]


def test_our_reader_gives_the_same(tmp_path: Path) -> None:
    scene = small_scene()
    path = tmp_path / "0.glb"
    path.write_bytes(make_content(scene, 0).data)
    glb = open_glb(path)
    assert glb.face_counts == (2, 2)
    corners = np.concatenate([glb.corners(0), glb.corners(1)])
    assert np.array_equal(corners.astype(np.float64) / STEP, scene.corners()[:4])


def test_document_says_what_viewers_need() -> None:
    document = pygltflib.GLTF2.load_from_bytes(make_content(small_scene(), 0).data)
    assert document.asset.generator.startswith("tilesnav ")
    assert [p.mode for p in document.meshes[0].primitives] == [4, 4]
    assert [p.extras["name"] for p in document.meshes[0].primitives] == ["ground", "wall"]
    assert document.materials[0].doubleSided
    assert [view.target for view in document.bufferViews] == [34962, 34963]
    node = document.nodes[0]
    assert (node.matrix, node.translation, node.rotation, node.scale) == (None, None, None, None)
    for primitive in document.meshes[0].primitives:
        accessor = document.accessors[primitive.attributes.POSITION]
        positions = _accessor(document, primitive.attributes.POSITION)
        assert accessor.min == positions.min(axis=0).tolist()
        assert accessor.max == positions.max(axis=0).tolist()


def test_positions_are_y_up_and_have_no_negative_zero() -> None:
    positions = gltf_positions(np.array([[1024, 0, 2048], [0, -512, 0]]), STEP)
    assert positions.tolist() == [[1.0, 2.0, 0.0], [0.0, 0.0, 0.5]]
    assert not np.signbit(positions).any()


@pytest.mark.parametrize("exponent", [-20, -10, 0])
def test_the_ends_of_the_grid_are_exact(exponent: int) -> None:
    end = 2**23 - 1
    step = 2.0**exponent
    positions = gltf_positions(np.array([[end, -end, end - 1]]), step)
    assert (positions.astype(np.float64) / step).tolist() == [[end, end - 1, end]]


def test_a_coordinate_beyond_the_grid_is_refused() -> None:
    with pytest.raises(ValueError, match="8388608 is not exact in float32"):
        gltf_positions(np.array([[0, -(2**23), 0]]), STEP)


def _fan(vertex_count: int) -> Scene:
    """One object whose faces use every vertex of a long strip."""
    vertices = np.zeros((vertex_count, 3), dtype=np.int64)
    vertices[:, 0] = np.arange(vertex_count) // 2
    vertices[1::2, 1] = 1
    starts = np.arange(vertex_count - 2)
    faces = np.stack((starts, starts + 1, starts + 2), axis=1).astype(np.int32)
    zeros = np.zeros(len(faces), dtype=np.int32)
    return Scene(vertices, faces, zeros, zeros[:1], ("fan",))


@pytest.mark.parametrize(("vertices", "component"), [(65535, 5123), (65536, 5125)])
def test_indices_are_as_short_as_they_may_be(vertices: int, component: int) -> None:
    scene = _fan(vertices)
    content = make_content(scene, 0)
    document = pygltflib.GLTF2.load_from_bytes(content.data)
    indices = document.accessors[document.meshes[0].primitives[0].indices]
    assert indices.componentType == component
    assert vertices - 1 != PRIMITIVE_RESTART["<u2"] or component == 5125
    assert np.array_equal(_grid_faces(content.data, scene)[0], scene.corners())


def test_long_and_short_indices_in_one_content() -> None:
    small, large = small_scene(), _fan(65536)
    offset = len(small.vertices)
    scene = replace(
        small,
        vertices=np.concatenate((small.vertices, large.vertices)),
        faces=np.concatenate((small.faces[:2], large.faces + offset, small.faces[2:4])).astype(np.int32),
        face_object=np.repeat([0, 1, 2], [2, large.face_count, 2]).astype(np.int32),
        object_content=np.zeros(3, dtype=np.int32),
        object_names=("a", "b", "c"),
    )
    content = make_content(scene, 0)
    assert np.array_equal(np.concatenate(_grid_faces(content.data, scene)), scene.corners())
    document = pygltflib.GLTF2.load_from_bytes(content.data)
    assert [view.byteOffset % 4 for view in document.bufferViews] == [0, 0, 0]


def test_an_object_without_faces_is_refused() -> None:
    scene = replace(small_scene(), face_object=np.array([0, 0, 0, 0, 2], dtype=np.int32))
    with pytest.raises(ValueError, match=r"object 1 \('wall'\) has no faces"):
        make_content(scene, 0)
