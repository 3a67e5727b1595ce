"""Contents: every way in which a glTF is not what core/content-gltf asks, and the faces of those that are."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from validator_fixture import FLOOR, WALL, Small, failures, gltf, pack_glb

from tilesnav_validator import glb

Change = Callable[[dict[str, Any]], None]


def read(change: Change | None = None) -> list[glb.Primitive]:
    root, binary = gltf([FLOOR, WALL])
    if change:
        change(root)
    return glb.read(memoryview(pack_glb(root, binary)))


def test_positions_are_turned_into_the_nav_frame() -> None:
    floor, wall = read()
    assert floor.positions[floor.triangles].tolist() == [[list(p) for p in t] for t in FLOOR]
    assert wall.positions[wall.triangles].tolist() == [[list(p) for p in t] for t in WALL]


@pytest.mark.parametrize(("code", "dtype"), [(5121, "<u1"), (5123, "<u2"), (5125, "<u4")])
def test_indices_and_strides(code: int, dtype: str) -> None:
    vertices = np.array([(0, 0, 0), (1, 0, 0), (0, 0, -1), (0, 1, 0)], dtype="<f4")
    spread = np.zeros((4, 5), dtype="<f4")
    spread[:, :3] = vertices
    indices = np.array([0, 1, 2, 0, 2, 3], dtype=dtype).tobytes()
    indices += b"\0" * (-len(indices) % 4)
    root, _ = gltf([FLOOR])
    root["bufferViews"] = [
        {"buffer": 0, "byteLength": 80, "byteStride": 20},
        {"buffer": 0, "byteOffset": 80, "byteLength": len(indices)},
    ]
    root["accessors"] = [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": 1, "componentType": code, "count": 6, "type": "SCALAR"},
    ]
    root["meshes"][0]["primitives"][0]["indices"] = 1
    root["buffers"] = [{"byteLength": 80 + len(indices)}]
    (primitive,) = glb.read(memoryview(pack_glb(root, spread.tobytes() + indices)))
    assert primitive.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert primitive.positions.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    root["accessors"][1]["count"] = 5
    with pytest.raises(glb.GlbError, match="multiple of 3"):
        glb.read(memoryview(pack_glb(root, spread.tobytes() + indices)))
    root["accessors"][1]["count"] = 6
    root["accessors"][0]["count"] = 3
    with pytest.raises(glb.GlbError, match="index 3"):
        glb.read(memoryview(pack_glb(root, spread.tobytes() + indices)))


def put(*path: Any) -> Change:
    """A change that sets the value at a path of keys."""
    *way, last, value = path

    def change(root: dict[str, Any]) -> None:
        node: Any = root
        for part in way:
            node = node[part]
        node[last] = value

    return change


P0 = ("meshes", 0, "primitives", 0)
FAULTS = {
    "version": put("asset", "version", "1.0"),
    "asset": put("asset", []),
    "matrix": put("nodes", 0, "matrix", np.eye(4).flatten().tolist()),
    "scale": put("nodes", 0, "scale", [1, 1, 1]),
    "rotation": put("nodes", 0, "rotation", [0, 0, 0, 1]),
    "translation": put("nodes", 0, "translation", [0, 0, 0]),
    "skin": put("nodes", 0, "skin", 0),
    "instancing": put("nodes", 0, "extensions", {"EXT_mesh_gpu_instancing": {}}),
    "two nodes": put("nodes", [{"mesh": 0, "children": [1]}, {"mesh": 0}]),
    "node twice": put("nodes", [{"mesh": 0, "children": [1, 1]}, {}]),
    "nodes in a circle": put("nodes", [{"mesh": 0, "children": [0]}]),
    "no such child": put("nodes", 0, "children", [1]),
    "children": put("nodes", 0, "children", {}),
    "no scene": put("scenes", []),
    "other scene": put("scenes", [{}, {"nodes": [0]}]),
    "no such scene": put("scene", 1),
    "not in the scene": put("scenes", [{"name": "empty"}]),
    "transform of a node not shown": put("nodes", [{"mesh": 0}, {"scale": [1, 1, 1]}]),
    "no node": put("nodes", []),
    "no such mesh": put("nodes", 0, "mesh", 1),
    "mesh true": put("nodes", 0, "mesh", True),
    "nodes": put("nodes", {}),
    "meshes": put("meshes", [7]),
    "lines": put(*P0, "mode", 1),
    "draco": put(*P0, "extensions", {"KHR_draco_mesh_compression": {}}),
    "meshopt": put("bufferViews", 0, "extensions", {"EXT_meshopt_compression": {}}),
    "morph": put(*P0, "targets", [{"POSITION": 0}]),
    "no position": put(*P0, "attributes", {}),
    "attributes": put(*P0, "attributes", None),
    "position accessor": put(*P0, "attributes", "POSITION", 99),
    "position negative": put(*P0, "attributes", "POSITION", -1),
    "short": put("accessors", 0, "componentType", 5122),
    "type of type": put("accessors", 0, "componentType", "5126"),
    "vec2": put("accessors", 0, "type", "VEC2"),
    "sparse": put("accessors", 0, "sparse", {}),
    "normalized": put("accessors", 0, "normalized", True),
    "count": put("accessors", 0, "count", 7),
    "count 2^63": put("accessors", 0, "count", 2**63),
    "count -1": put("accessors", 0, "count", -1),
    "count 1.5": put("accessors", 0, "count", 1.5),
    "not triangles": put("accessors", 0, "count", 5),
    "offset": put("accessors", 0, "byteOffset", 10**9),
    "view": put("accessors", 0, "bufferView", 5),
    "no view": put("accessors", 0, "bufferView", None),
    "view offset": put("bufferViews", 0, "byteOffset", 10**12),
    "view length": put("bufferViews", 0, "byteLength", 10 * 2**30),
    "view buffer": put("bufferViews", 0, "buffer", 1),
    "stride": put("bufferViews", 0, "byteStride", 8),
    "stride 2^40": put("bufferViews", 0, "byteStride", 2**40),
    "buffer length": put("buffers", 0, "byteLength", 10 * 2**30),
    "buffer uri": put("buffers", 0, "uri", "x.bin"),
    "data uri": put("buffers", 0, "uri", "data:application/octet-stream;base64,AAAA"),
    "no buffer": put("buffers", []),
    "view of a second buffer": lambda root: root.update(
        buffers=[*root["buffers"], {"byteLength": 8, "uri": "x.bin"}],
        bufferViews=[*root["bufferViews"], {"buffer": 1, "byteLength": 8}],
    ),
    "nothing": put("accessors", 0, "count", 0),
    "float index": put(*P0, "indices", 1),
}


@pytest.mark.parametrize("change", FAULTS.values(), ids=FAULTS.keys())
def test_faults(change: Change) -> None:
    with pytest.raises(glb.GlbError):
        read(change)


def test_nodes_without_a_mesh_do_no_harm() -> None:
    assert len(read(put("nodes", [{"mesh": 0, "children": [1]}, {"name": "x"}]))) == 2


def test_a_node_outside_the_scene_shows_nothing() -> None:
    assert len(read(put("nodes", [{"mesh": 0}, {"mesh": 0}]))) == 2

    def second_scene(root: dict[str, Any]) -> None:
        root.update(scene=1, scenes=[{"nodes": [0, 1]}, {"nodes": [1]}], nodes=[{}, {"mesh": 0}])

    assert len(read(second_scene)) == 2


def test_what_is_not_in_use_may_lie_outside() -> None:
    def outside(root: dict[str, Any]) -> None:
        root["buffers"].append({"byteLength": 8, "uri": "x.bin"})
        root["images"] = [{"uri": "bricks.png"}]

    assert len(read(outside)) == 2


def test_numbers_that_are_integers_written_as_floats_count() -> None:
    assert len(read(put("accessors", 0, "count", 6.0))) == 2


def test_files_without_meshes() -> None:
    assert glb.read(memoryview(pack_glb({"asset": {"version": "2.0"}}, b""))) == []


def test_a_nan_is_a_fault() -> None:
    root, binary = gltf([FLOOR])
    for value in (float("nan"), float("inf")):
        with pytest.raises(glb.GlbError, match="finite"):
            glb.read(memoryview(pack_glb(root, struct.pack("<f", value) + binary[4:])))


def test_every_truncation_and_foreign_chunks() -> None:
    whole = pack_glb(*gltf([FLOOR]))
    for length in range(len(whole)):
        with pytest.raises(glb.GlbError):
            glb.read(memoryview(whole[:length]))
        with pytest.raises(glb.GlbError):  # with a header that agrees with the shorter file
            glb.read(memoryview(whole[:8] + struct.pack("<I", length) + whole[12:length]))
    for start, text in ((0, b"gltf"), (4, b"\1"), (16, b"BIN\0"), (20, b"x")):
        with pytest.raises(glb.GlbError):
            glb.read(memoryview(whole[:start] + text + whole[start + len(text) :]))
    end = len(whole) - len(gltf([FLOOR])[1])
    with pytest.raises(glb.GlbError, match="BIN"):
        glb.read(memoryview(whole[: end - 4] + b"XXXX" + whole[end:]))


def test_json_without_binary_part_and_json_array() -> None:
    text = b'{"asset":{"version":"2.0"}} '
    head = struct.pack("<4sII", b"glTF", 2, 20 + len(text)) + struct.pack("<I4s", len(text), b"JSON")
    assert glb.read(memoryview(head + text)) == []
    with pytest.raises(glb.GlbError, match="JSON object"):
        glb.read(memoryview(head + b"[" + b" " * (len(text) - 2) + b"]"))


def test_a_file_cannot_unfold_to_more_than_it_holds() -> None:
    root, binary = gltf([FLOOR * 100])
    root["meshes"][0]["primitives"] *= 40
    with pytest.raises(glb.GlbError, match="reuse"):
        glb.read(memoryview(pack_glb(root, binary)))


def test_contents_of_the_small_tileset(tmp_path: Path) -> None:
    root, binary = gltf(Small().objects)
    root["nodes"][0]["scale"] = [2, 2, 2]
    assert failures(Small(glb=pack_glb(root, binary)).write(tmp_path), rays=0) == ["core/content-gltf"]
    off = [[(0, 0, 0), (1, 0, 0), (2, 2.0**-11, 0)]]
    assert failures(Small(objects=[FLOOR, WALL, off]).write(tmp_path), rays=0) == ["core/on-grid"]
    far = [[(0, 0, 0), (8192, 0, 0), (2, 1, 0)]]
    assert failures(Small(objects=[FLOOR, WALL, far]).write(tmp_path), rays=0) == ["core/on-grid"]
    small = Small()
    small.root["boundingVolume"] = {"box": [0, 0, 2, 8, 0, 0, 0, 8, 0, 0, 0, 1.99]}
    assert failures(small.write(tmp_path), rays=0) == ["core/tile-volume-bounds"]
    small.root["boundingVolume"] = {"box": [0, 0, 2, 8, 0, 0, 0, 8, 0, 0, 0, 2 - 2.0**-10]}
    assert failures(small.write(tmp_path), rays=0) == []


def test_vertices_that_no_index_names_are_on_the_grid_too(tmp_path: Path) -> None:
    root, binary = gltf(Small().objects)
    spare = struct.pack("<3f", 0, 2.0**-11, 0)
    start = len(binary)
    last = root["accessors"][2]
    points = binary[root["bufferViews"][2]["byteOffset"] :] + spare
    last["count"] += 1
    last["bufferView"] = 3
    root["bufferViews"] += [
        {"buffer": 0, "byteOffset": start, "byteLength": len(points)},
        {"buffer": 0, "byteOffset": start + len(points), "byteLength": 6},
    ]
    root["accessors"].append({"bufferView": 4, "componentType": 5123, "count": 3, "type": "SCALAR"})
    root["meshes"][0]["primitives"][2]["indices"] = 3
    whole = binary + points + struct.pack("<3H", 0, 1, 2)
    root["buffers"] = [{"byteLength": len(whole)}]
    assert failures(Small(glb=pack_glb(root, whole)).write(tmp_path), rays=0) == ["core/on-grid"]


def coarse(small: Small, folder: Path, objects: list[Any], **facts: int) -> None:
    """Add a content of level 1."""
    data = pack_glb(*gltf(objects))
    folder.mkdir(exist_ok=True)
    (folder / "coarse.glb").write_bytes(data)
    nav = {"contentId": 0, "level": 1, "sha256": hashlib.sha256(data).hexdigest(), **facts}
    content = {"uri": "coarse.glb", "extensions": {"3DTILES_nav": nav}}
    small.tileset["root"] = {**small.root, "content": content, "children": [small.root]}


def test_counts_and_volumes_of_a_coarse_content(tmp_path: Path) -> None:
    off = [[(0, 0, 0), (1, 0, 0), (2, 2.0**-11, 0)]]
    for objects, faces, parts, expected in (
        ([FLOOR, off], 3, 2, []),
        ([FLOOR, off], 2, 2, ["core/face-count"]),
        ([FLOOR, off], 3, 1, ["core/face-count"]),
        ([FLOOR, [[(0, 0, 0), (1, 0, 0), (9, 0, 0)]]], 3, 2, ["core/tile-volume-bounds"]),
    ):
        small = Small()
        coarse(small, tmp_path, objects, faceCount=faces, objectCount=parts)
        assert failures(small.write(tmp_path), rays=0) == expected


def test_the_volume_of_a_content_is_not_judged(tmp_path: Path) -> None:
    small = Small()
    small.root["content"]["boundingVolume"] = {"box": [99] * 12}
    assert failures(small.write(tmp_path), rays=0) == []


@pytest.mark.parametrize("name", ["faceCount", "objectCount"])
def test_counts(tmp_path: Path, name: str) -> None:
    small = Small()
    small.root["content"]["extensions"]["3DTILES_nav"][name] += 1
    assert failures(small.write(tmp_path), rays=0) == ["core/face-count"]
    small = Small()
    small.extension[name] += 1
    assert failures(small.write(tmp_path), rays=0) == ["core/face-count"]


def test_a_coarse_content_that_needs_a_decoder_is_not_read(tmp_path: Path) -> None:
    small = Small()
    path = small.write(tmp_path)
    (tmp_path / "coarse.glb").write_bytes(b"whatever")
    digest = "85738f8f9a7f1b04b5329c590ebcb9e425925c6d0984089c43a022de4f19c281"
    nav = {"contentId": 0, "level": 1, "faceCount": 5, "objectCount": 3, "sha256": digest}
    small.root["contents"] = [
        small.root.pop("content"),
        {"uri": "coarse.glb", "extensions": {"3DTILES_nav": nav}},
    ]
    assert failures(small.write(path.parent), rays=0) == []
    nav["sha256"] = digest[::-1]
    assert failures(small.write(path.parent), rays=0) == ["core/content-digest"]


def test_numbering_of_contents(tmp_path: Path) -> None:
    small = Small()
    small.root["content"]["extensions"]["3DTILES_nav"]["contentId"] = 1
    assert failures(small.write(tmp_path), rays=0) == ["core/content-ids-dense"]
