"""Triangles of glTF: every way of storing them that tiles use, against values written by hand."""

from __future__ import annotations

import base64
import json
import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tileset_fixture import TRIANGLE, Y_UP_TO_Z_UP, b3dm, glb, model, tile, tileset, write

from tilesnav_ref.scene import SceneError, SceneSettings, load_scene
from tilesnav_ref.scene.parts import MeshFile
from tilesnav_ref.scene.read import read_mesh
from tilesnav_ref.scene.tiles import read_tileset

SQUARE = np.array(((0, 0, 0), (1, 0, 0), (0, 0, -1), (1, 0, -1)), float)
FLAT = SQUARE @ Y_UP_TO_Z_UP.T


def read(folder: Path, content: bytes, name: str = "a.glb", **files: bytes) -> MeshFile:
    path = write(folder, {"tileset.json": tileset(tile(name)), name: content, **files})
    return read_tileset(path, "auto", 10_000, with_materials=True)


def corners(mesh: MeshFile) -> list[list[list[float]]]:
    return [corner for part in mesh.parts for corner in part.vertices[part.faces].tolist()]


def with_data(document: dict[str, Any], binary: bytes, data: bytes) -> tuple[int, bytes]:
    """Append data as a buffer view; its number, and the binary chunk."""
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
    binary += data + bytes(-len(data) % 4)
    document["buffers"][0]["byteLength"] = len(binary)
    return len(document["bufferViews"]) - 1, binary


def test_nodes_multiply_and_turn(tmp_path: Path) -> None:
    half = float(np.sqrt(0.5))
    nodes = [
        {"children": [1], "translation": [10, 0, 0]},
        {"mesh": 0, "translation": [0, 2, 0], "rotation": [0, half, 0, half], "scale": [2, 1, 1]},
    ]
    document, binary = model()
    document["nodes"] = nodes
    found = read(tmp_path, glb(document, binary)).parts[0].vertices
    # x of the mesh, doubled, points along -z of glTF (north) after a quarter turn about y; -z along -x
    assert found == pytest.approx(np.array(((10, 0, 2), (10, 8, 2), (7, 0, 2))), abs=1e-12)


def test_a_mirrored_node_turns_its_faces(tmp_path: Path) -> None:
    found = corners(read(tmp_path, glb(*model(node={"scale": [-1, 1, 1]}))))
    assert found == [[[0, 3, 0], [-4, 0, 0], [0, 0, 0]]]


def test_only_the_default_scene_is_read(tmp_path: Path) -> None:
    document, binary = model(nodes=[{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0]}])
    document.update(scenes=[{"nodes": [0]}, {"nodes": [1]}], scene=1)
    assert corners(read(tmp_path / "a", glb(document, binary)))[0][0] == [5, 0, 0]
    del document["scenes"], document["scene"]
    assert len(corners(read(tmp_path / "b", glb(document, binary)))) == 2


@pytest.mark.parametrize(
    ("mode", "indices", "expected"),
    [
        (5, [0, 1, 2, 3], [[0, 1, 2], [1, 3, 2]]),
        (6, [0, 1, 3, 2], [[1, 3, 0], [3, 2, 0]]),
        (4, [0, 1, 2, 1, 3, 2], [[0, 1, 2], [1, 3, 2]]),
    ],
)
def test_modes(mode: int, indices: list[int], expected: list[list[int]], tmp_path: Path) -> None:
    document, binary = model(SQUARE, [indices])
    document["meshes"][0]["primitives"][0]["mode"] = mode
    assert corners(read(tmp_path, glb(document, binary))) == FLAT[expected].tolist()


def test_points_are_counted_and_no_indices_are_needed(tmp_path: Path) -> None:
    document, binary = model(SQUARE[:3])
    triangles = {"attributes": {"POSITION": 0}}
    document["meshes"][0]["primitives"] = [{"mode": 0, "attributes": {"POSITION": 0}}, triangles]
    mesh = read(tmp_path, glb(document, binary))
    assert corners(mesh) == [FLAT[:3].tolist()]
    assert mesh.skipped == 1


def test_stride_normalized_integers_and_their_scale(tmp_path: Path) -> None:
    document, binary = model(node={"scale": [4, 1, 3]})
    data = struct.pack("<4h4h4h", 0, 0, 0, 9, 32767, 0, 0, 9, 0, 0, -32768, 9)
    view, binary = with_data(document, binary, data)
    document["bufferViews"][view]["byteStride"] = 8
    document["accessors"][0].update(bufferView=view, componentType=5122, normalized=True)
    document["extensionsRequired"] = ["KHR_mesh_quantization"]
    assert corners(read(tmp_path, glb(document, binary))) == [(TRIANGLE @ Y_UP_TO_Z_UP.T).tolist()]


def test_sparse_positions(tmp_path: Path) -> None:
    document, binary = model(np.zeros((3, 3)))
    indices, binary = with_data(document, binary, bytes((1, 2)))
    values, binary = with_data(document, binary, TRIANGLE[1:].astype("<f4").tobytes())
    document["accessors"][0]["sparse"] = {
        "count": 2,
        "indices": {"bufferView": indices, "componentType": 5121},
        "values": {"bufferView": values},
    }
    expected = [(TRIANGLE @ Y_UP_TO_Z_UP.T).tolist()]
    assert corners(read(tmp_path / "a", glb(document, binary))) == expected
    del document["accessors"][0]["bufferView"]
    assert corners(read(tmp_path / "b", glb(document, binary))) == expected
    document["accessors"][0]["sparse"]["indices"]["bufferView"] = 0  # float32 bytes: numbers beyond the three
    with pytest.raises(SceneError, match=r"sparse.indices: found uint8 up to"):
        read(tmp_path / "c", glb(document, b"\xff\xff" + binary[2:]))


def test_json_gltf_with_a_file_beside_it_and_data_in_it(tmp_path: Path) -> None:
    document, binary = model()
    document["buffers"][0]["uri"] = "a%20b.bin"
    text = json.dumps(document).encode()
    mesh = read(tmp_path / "a", text, "a.gltf", **{"a b.bin": binary})
    assert corners(mesh) == [(TRIANGLE @ Y_UP_TO_Z_UP.T).tolist()]
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + (
        base64.b64encode(binary).decode()
    )
    assert corners(read(tmp_path / "b", json.dumps(document).encode(), "a.gltf")) == corners(mesh)


def test_instances(tmp_path: Path) -> None:
    document, binary = model()
    moves, binary = with_data(document, binary, np.array(((0, 0, 0), (10, 5, 0)), "<f4").tobytes())
    document["accessors"].append({"bufferView": moves, "componentType": 5126, "count": 2, "type": "VEC3"})
    document["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}}
    found = corners(read(tmp_path, glb(document, binary)))
    assert [corner[0] for corner in found] == [[0, 0, 0], [10, 0, 5]]


def test_batches_become_parts_with_the_texts_of_the_table(tmp_path: Path) -> None:
    vertices = np.concatenate(
        (SQUARE[:3], SQUARE[:3] + np.array((5, 0, 0)), SQUARE[:3] + np.array((9, 0, 0)))
    )
    content = glb(*model(vertices, np.arange(9).reshape(3, 3), batch=[1, 1, 1, 0, 0, 0, 1, 1, 1]))
    table = {"name": ["the church", "the oak"], "height": [30, 12], "binary": {"byteOffset": 0}}
    mesh = read(tmp_path, b3dm(content, {"BATCH_LENGTH": 2}, table), "a.b3dm")
    assert [(part.name, len(part.faces)) for part in mesh.parts] == [("a.b3dm#0", 1), ("a.b3dm#1", 2)]
    assert mesh.parts[1].labels == ("a.b3dm#1", "a.b3dm", "the oak")
    assert mesh.parts[1].vertices.max(axis=0).tolist() == [10, 1, 0]


def test_parts_chosen_by_the_texts_of_the_table(tmp_path: Path) -> None:
    vertices = np.concatenate((TRIANGLE, TRIANGLE + np.array((50, 0, 0))))
    content = glb(*model(vertices, [[0, 1, 2], [3, 4, 5]], batch=[0, 0, 0, 1, 1, 1]))
    data = b3dm(content, {"BATCH_LENGTH": 2}, {"class": ["house", "tree"]})
    path = write(tmp_path, {"tileset.json": tileset(tile("a.b3dm")), "a.b3dm": data})
    scene, _ = load_scene(path, SceneSettings(transparent=("tree",), object_reach=1.0))
    porous = scene.corners()[scene.porous] * scene.step
    assert len(porous) == 1
    assert porous[0, :, 0].min() > scene.corners()[~scene.porous][0, :, 0].max() * scene.step


def test_feature_ids_of_version_1_1(tmp_path: Path) -> None:
    document, binary = model(SQUARE, [[0, 1, 2], [3, 2, 1]])
    ids, binary = with_data(document, binary, bytes((7, 0, 0, 9)))
    document["accessors"].append({"bufferView": ids, "componentType": 5121, "count": 4, "type": "SCALAR"})
    primitive = document["meshes"][0]["primitives"][0]
    primitive["attributes"]["_FEATURE_ID_3"] = 2
    features = [{"featureCount": 1, "texture": {}}, {"featureCount": 10, "attribute": 3}]
    primitive["extensions"] = {"EXT_mesh_features": {"featureIds": features}}
    assert [part.name for part in read(tmp_path, glb(document, binary)).parts] == ["a.glb#7", "a.glb#9"]


def test_names_of_nodes_meshes_and_materials_choose_parts(tmp_path: Path) -> None:
    document, binary = model(node={"name": "crown"}, materials=[{"name": "leaf"}])
    document["meshes"][0]["name"] = "oak"
    document["meshes"][0]["primitives"][0]["material"] = 0
    assert read(tmp_path, glb(document, binary)).parts[0].labels == ("a.glb", "crown", "oak", "leaf")


def test_a_large_array_that_many_primitives_share_is_kept_once(tmp_path: Path) -> None:
    document, binary = model(np.repeat(TRIANGLE, 300, axis=0), [[0, 300, 600]])
    document["meshes"][0]["primitives"] *= 50
    mesh = read(tmp_path, glb(document, binary))
    assert [(len(part.vertices), len(part.faces)) for part in mesh.parts] == [(150, 50)]


def test_draco(tmp_path: Path) -> None:
    draco = pytest.importorskip("DracoPy", reason="DracoPy is not installed (extra tiles)")
    data = compressed_by_draco(draco, preserve_order=False)
    mesh = read(tmp_path, glb(*data))
    assert [part.name for part in mesh.parts] == ["a.glb#4"]
    found = np.array(corners(mesh))
    assert found == pytest.approx(
        np.rint(found), abs=40 * 2**-14
    )  # 14 bits over 40 m; the grid has whole metres
    assert oriented(np.rint(found)) == oriented((GRID @ Y_UP_TO_Z_UP.T)[GRID_FACES])


GRID = np.array([(x, (x * y) % 3, y) for x in range(0, 40, 4) for y in range(0, 40, 4)], float)
GRID_FACES = np.array(
    [(k, k + 1, k + 10) for k in range(89) if k % 10 < 9]
    + [(k + 1, k + 11, k + 10) for k in range(89) if k % 10 < 9]
)


def oriented(faces: Any) -> list[tuple[tuple[float, ...], ...]]:
    """Faces in an order of their own, each from its least corner on."""
    turned = []
    for face in np.asarray(faces).tolist():
        first = face.index(min(face))
        turned.append(tuple(map(tuple, face[first:] + face[:first])))
    return sorted(turned)


def compressed_by_draco(draco: Any, preserve_order: bool) -> tuple[dict[str, Any], bytes]:
    """The grid in Draco, with the feature id 4; order is kept by the sequential method only."""
    ids = np.full((len(GRID), 1), 4, np.uint8)
    packed = draco.encode(
        GRID.astype(np.float32), GRID_FACES, preserve_order=preserve_order, generic_attributes={5: ids}
    )
    attributes = {one["unique_id"]: one for one in draco.decode(packed).attributes}
    position = next(k for k, one in attributes.items() if one["attribute_type"] == 0)
    document, binary = model(GRID, GRID_FACES, batch=ids[:, 0])
    document["bufferViews"] = []
    view, binary = with_data(document, b"", packed)
    for accessor in document["accessors"]:
        del accessor["bufferView"]
    stored = {"POSITION": position, "_BATCHID": 5}
    primitive = document["meshes"][0]["primitives"][0]
    primitive["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": view, "attributes": stored}}
    document["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    return document, binary


@pytest.mark.parametrize("preserve_order", [False, True])
def test_draco_that_claims_more_or_is_broken(preserve_order: bool, tmp_path: Path) -> None:
    draco = pytest.importorskip("DracoPy", reason="DracoPy is not installed (extra tiles)")
    document, binary = compressed_by_draco(draco, preserve_order)
    document["accessors"][1]["count"] -= 3
    with pytest.raises(
        SceneError, match="162 faces and 100 points claimed; allowed: at most the 161 and 100"
    ):
        read(tmp_path / "a", glb(document, binary))
    document["accessors"][1]["count"] += 3
    broken = binary[:60] + bytes(len(binary) - 60)
    with pytest.raises(SceneError, match="KHR_draco_mesh_compression"):
        read(tmp_path / "b", glb(document, broken))
    with pytest.raises(SceneError, match=r"version 2.1, type 1"):
        read(tmp_path / "c", glb(document, binary[:6] + b"\1" + binary[7:]))
    with pytest.raises(SceneError, match=r"allowed: a Draco mesh of version 2.2"):
        read(tmp_path / "d", glb(document, bytes(len(binary))))


def compressed_by_meshopt(
    meshopt: Any, name: str = "EXT_meshopt_compression"
) -> tuple[dict[str, Any], bytes]:
    """The grid in meshopt: float32 positions, 16 bit indices, and a fallback buffer without data."""
    document, _ = model(GRID, GRID_FACES)
    positions = GRID.astype("<f4")
    packed = [
        meshopt.encode_vertex_buffer_level(positions, 2, 0),
        meshopt.encode_index_buffer(GRID_FACES.astype("<u4")),
    ]
    shapes = [(len(GRID), 12, "ATTRIBUTES"), (GRID_FACES.size, 2, "TRIANGLES")]
    binary, views = b"", []
    for data, (count, stride, mode) in zip(packed, shapes, strict=True):
        view = {"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)}
        view.update(byteStride=stride, count=count, mode=mode)
        views.append({"buffer": 1, "byteLength": count * stride, "extensions": {name: view}})
        binary += data + bytes(-len(data) % 4)
    fallback = {"byteLength": 1 << 20, "extensions": {name: {"fallback": True}}}
    document.update(
        bufferViews=views, buffers=[{"byteLength": len(binary)}, fallback], extensionsRequired=[name]
    )
    return document, binary


@pytest.mark.parametrize("name", ["EXT_meshopt_compression", "KHR_meshopt_compression"])
def test_meshopt(name: str, tmp_path: Path) -> None:
    meshopt = pytest.importorskip("meshopt", reason="meshopt is not installed (extra tiles)")
    found = oriented(corners(read(tmp_path, glb(*compressed_by_meshopt(meshopt, name)))))
    assert found == oriented((GRID @ Y_UP_TO_Z_UP.T)[GRID_FACES])
    assert len(found) == 162


def test_meshopt_with_quantized_and_filtered_positions(tmp_path: Path) -> None:
    meshopt = pytest.importorskip("meshopt", reason="meshopt is not installed (extra tiles)")
    document, _ = compressed_by_meshopt(meshopt)
    filtered = meshopt.encode_filter_exp(GRID.astype(np.float32), 15, "Separate")
    packed = meshopt.encode_vertex_buffer_level(filtered, 2, 0)
    _, triangles = compressed_by_meshopt(meshopt)
    start = document["bufferViews"][1]["extensions"]["EXT_meshopt_compression"]["byteOffset"]
    binary = triangles[start:]
    document["bufferViews"][1]["extensions"]["EXT_meshopt_compression"]["byteOffset"] = 0
    document["bufferViews"][0]["extensions"]["EXT_meshopt_compression"].update(
        byteOffset=len(binary), byteLength=len(packed), filter="EXPONENTIAL"
    )
    document["buffers"][0]["byteLength"] = len(binary) + len(packed)
    found = np.sort(np.array(corners(read(tmp_path, glb(document, binary + packed)))).reshape(-1, 3), axis=0)
    expected = np.sort((GRID @ Y_UP_TO_Z_UP.T)[GRID_FACES].reshape(-1, 3), axis=0)
    assert found == pytest.approx(expected, abs=40 * 2**-14)


def test_meshopt_that_claims_too_much_or_is_broken(tmp_path: Path) -> None:
    meshopt = pytest.importorskip("meshopt", reason="meshopt is not installed (extra tiles)")
    document, binary = compressed_by_meshopt(meshopt)
    packed = document["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]
    with pytest.raises(SceneError, match="meshopt_compression: found"):
        read(tmp_path / "a", glb(document, bytes(len(binary))))
    packed["count"] = 2**33
    with pytest.raises(
        SceneError, match=r"meshopt_compression.count: found 8589934592; allowed: an integer from 1"
    ):
        read(tmp_path / "b", glb(document, binary))
    packed.update(count=100, mode="TREES")
    with pytest.raises(SceneError, match="'TREES'; allowed: ATTRIBUTES, TRIANGLES, INDICES"):
        read(tmp_path / "c", glb(document, binary))


@pytest.mark.parametrize("library", ["DracoPy", "meshopt"])
def test_a_missing_decoder_is_named_with_its_extra(
    library: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, library, None)  # an import of it now fails
    document, binary = model()
    if library == "DracoPy":
        extension = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
        document["meshes"][0]["primitives"][0]["extensions"] = extension
    else:
        packed = {"buffer": 0, "byteLength": 36, "byteStride": 12, "count": 3, "mode": "ATTRIBUTES"}
        document["bufferViews"][0]["extensions"] = {"EXT_meshopt_compression": packed}
    with pytest.raises(
        SceneError, match=rf"no {library}; allowed: {library} installed \(pip install 'tilesnav\[tiles"
    ):
        read(tmp_path, glb(document, binary))


def test_a_glb_file_may_be_compressed_too(tmp_path: Path) -> None:
    meshopt = pytest.importorskip("meshopt", reason="meshopt is not installed (extra tiles)")
    path = tmp_path / "grid.glb"
    path.write_bytes(glb(*compressed_by_meshopt(meshopt)))
    scene, report = load_scene(path, SceneSettings(up="z"))
    assert report.up == "z"
    assert oriented(scene.corners() * scene.step) == oriented(GRID[GRID_FACES])


def test_primitives_of_a_glb_file_keep_their_order_and_names(tmp_path: Path) -> None:
    """Not by random names of frames, which another library gives them."""
    document, binary = model(node={"name": "house"})
    document["meshes"][0]["primitives"] *= 3
    document["nodes"].append({"mesh": 0})
    document["scenes"] = [{"nodes": [1, 0]}]
    path = tmp_path / "a.glb"
    path.write_bytes(glb(document, binary))
    found = [part.name for part in read_mesh(path, 100).parts]
    assert found == ["a", "a_1", "a_2", "house", "house_1", "house_2"]
