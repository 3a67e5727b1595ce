"""Bad tilesets: each error names the file, the place, what was found and what is allowed."""

from __future__ import annotations

import struct
import tracemalloc
from pathlib import Path
from typing import Any

import pytest
from tileset_fixture import b3dm, cmpt, glb, model, subtree, tile, tileset, write

from tilesnav_ref.scene import SceneError, SceneSettings, load_scene
from tilesnav_ref.scene.tiles import read_tileset

ONE = glb(*model())
B3DM = b3dm(ONE)


def one(data: bytes, uri: str = "a.b3dm") -> dict[str, Any]:
    return {"tileset.json": tileset(tile(uri)), uri: data}


def patched(data: bytes, offset: int, value: int) -> bytes:
    return data[:offset] + struct.pack("<I", value) + data[offset + 4 :]


def changed(**members: Any) -> dict[str, Any]:
    """A content whose document has other members."""
    document, binary = model()
    return one(glb({**document, **members}, binary), "a.glb")


def accessor(**members: Any) -> dict[str, Any]:
    document, binary = model()
    document["accessors"][0].update(members)
    return one(glb(document, binary), "a.glb")


def float_indices() -> dict[str, Any]:
    document, binary = model()
    document["accessors"][1].update(bufferView=0, componentType=5126)
    return one(glb(document, binary), "a.glb")


def nested(depth: int) -> dict[str, Any]:
    inner = tile("a.glb")
    for _ in range(depth):
        inner = tile(children=[inner])
    return tileset(inner)


def implicit(data: bytes, **tiling: Any) -> dict[str, Any]:
    tiling = {
        "subdivisionScheme": "QUADTREE",
        "availableLevels": 2,
        "subtreeLevels": 2,
        "subtrees": {"uri": "{level}.{x}.{y}.subtree"},
        **tiling,
    }
    return {
        "tileset.json": tileset(tile("{level}.{x}.{y}.glb", implicitTiling=tiling)),
        "0.0.0.subtree": data,
    }


NONE = {"tileAvailability": {"constant": 0}, "childSubtreeAvailability": {"constant": 0}}
ALL = {"tileAvailability": {"constant": 1}, "contentAvailability": [{"constant": 1}]}
STREAM = {**NONE, "contentAvailability": [{"bitstream": 0}], "tileAvailability": {"constant": 1}}

BAD: dict[str, tuple[dict[str, Any], str, str, str]] = {
    # case: files, file at fault, place, found
    "no_json": ({"tileset.json": b"{"}, "tileset.json", "file", "no JSON"),
    "array": ({"tileset.json": b"[1]"}, "tileset.json", "file", "[1]"),
    "deep_json": ({"tileset.json": b'{"a":' * 99_999}, "tileset.json", "file", "no JSON"),
    "no_root": ({"tileset.json": {"asset": {}}}, "tileset.json", "file", "no member 'root'"),
    "root_text": ({"tileset.json": {"asset": {}, "root": "x"}}, "tileset.json", "root", "'x'"),
    "required": (
        {"tileset.json": tileset(tile(), extensionsRequired=["X_secret"])},
        "tileset.json",
        "extensionsRequired[0]",
        "'X_secret'",
    ),
    "missing": (
        {"tileset.json": tileset(tile("no.glb"))},
        "tileset.json",
        "root.content.uri",
        "'no.glb', which is",
    ),
    "network": (
        {"tileset.json": tileset(tile("https://example.com/a.glb"))},
        "tileset.json",
        "root.content.uri",
        "'https://example.com/a.glb'; allowed: a file in the folder of the entry tileset, or below",
    ),
    "file_scheme": ({"tileset.json": tileset(tile("file:///etc/passwd"))}, "tileset.json", "root.", "'file:"),
    "outside": (
        {"in/tileset.json": tileset(tile("../b.glb")), "b.glb": ONE},
        "tileset.json",
        "root.",
        "outside",
    ),
    "absolute": ({"tileset.json": tileset(tile("/etc/passwd"))}, "tileset.json", "root.", "outside"),
    "zero_byte": ({"tileset.json": tileset(tile("a%00b"))}, "tileset.json", "root.content.uri", "'a%00b'"),
    "uri_number": (
        {"tileset.json": tileset(tile(content={"uri": 3}))},
        "tileset.json",
        "root.content.uri",
        "3",
    ),
    "no_uri": (
        {"tileset.json": tileset(tile(content={}))},
        "tileset.json",
        "root.content",
        "no member 'url'",
    ),
    "refine": ({"tileset.json": tileset(tile(refine="SWAP"))}, "tileset.json", "root.refine", "'SWAP'"),
    "transform": (
        {"tileset.json": tileset(tile(transform=[1, 2]))},
        "tileset.json",
        "root.transform",
        "[1, 2]",
    ),
    "projective": (
        {"tileset.json": tileset(tile(transform=[1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]))},
        "tileset.json",
        "root.transform",
        "last row [1.0, 0.0, 0.0, 1.0]",
    ),
    "huge_number": (
        {"tileset.json": tileset(tile(transform=[10**400] * 16))},
        "tileset.json",
        "root.transform",
        "[1000",
    ),
    "deep_tree": ({"tileset.json": nested(150)}, "tileset.json", "root.children[0]", "101 tiles above"),
    "cycle": (
        {"tileset.json": tileset(tile("b.json")), "b.json": tileset(tile("tileset.json"))},
        "tileset.json",
        "file",
        "tileset.json -> b.json -> tileset.json",
    ),
    "chain": (
        {f"{k or 'tileset'}.json": tileset(tile(f"{k + 1}.json")) for k in range(40)},
        "33.json",
        "file",
        "33 tilesets around",
    ),
    "magic": (one(b"abcd" * 9), "a.b3dm", "magic", "b'abcd'"),
    "empty": (one(b""), "a.b3dm", "file", "0 bytes"),
    "short_b3dm": (one(B3DM[:20]), "a.b3dm", "b3dm header", "20 bytes"),
    "cut_b3dm": (one(B3DM[:-4]), "a.b3dm", "b3dm header", f"length {len(B3DM)}"),
    "version": (one(patched(B3DM, 4, 7)), "a.b3dm", "b3dm header", "version 7"),
    "long_table": (one(patched(B3DM, 12, 2**32 - 1)), "a.b3dm", "b3dm header", "tables to byte 4294967"),
    "bad_table": (one(B3DM.replace(b'{"BATCH', b'["BATCH')), "a.b3dm", "b3dm feature table", "no JSON"),
    "center": (one(b3dm(ONE, {"RTC_CENTER": [1, 2]})), "a.b3dm", "feature table.RTC_CENTER", "[1, 2]"),
    "center_offset": (
        one(b3dm(ONE, {"RTC_CENTER": {"byteOffset": 99}}, feature_binary=bytes(12))),
        "a.b3dm",
        "RTC_CENTER.byteOffset",
        "99",
    ),
    "old_gltf": (one(patched(B3DM, B3DM.index(b"glTF") + 4, 1)), "a.b3dm", "glTF header", "version 1"),
    "long_chunk": (one(patched(ONE, 12, 2**31), "a.glb"), "a.glb", "glTF first chunk", "2147483648 bytes"),
    "cmpt_count": (
        one(patched(cmpt(B3DM), 12, 9), "a.cmpt"),
        "a.cmpt",
        "cmpt tile 1",
        f"of {16 + len(B3DM)}",
    ),
    "cmpt_length": (
        one(patched(cmpt(B3DM), 24, 2**30), "a.cmpt"),
        "a.cmpt",
        "cmpt tile 0",
        "length 1073741824",
    ),
    "cmpt_zero": (one(patched(cmpt(B3DM), 24, 0), "a.cmpt"), "a.cmpt", "cmpt tile 0", "length 0"),
    "unknown": (changed(extensionsRequired=["X_y"]), "a.glb", "glTF.extensionsRequired[0]", "'X_y'"),
    "node_cycle": (
        changed(nodes=[{"children": [1]}, {"children": [0], "mesh": 0}]),
        "a.glb",
        "glTF.nodes[1].children[0]",
        "node 0 a second time",
    ),
    "node_range": (changed(scenes=[{"nodes": [5]}]), "a.glb", "glTF.scenes[0].nodes[0]", "5"),
    "rotation": (
        changed(nodes=[{"mesh": 0, "rotation": [0, 0, 0, 0]}]),
        "a.glb",
        "glTF.nodes[0]",
        "length 0",
    ),
    "mesh_range": (changed(nodes=[{"mesh": 1}]), "a.glb", "glTF.nodes[0].mesh", "1"),
    "count": (accessor(count=2**40), "a.glb", "glTF.accessors[0].count", "1099511627776"),
    "count_beyond": (accessor(count=1000), "a.glb", "glTF.accessors[0]", "1000 elements"),
    "offset": (accessor(byteOffset=2**40), "a.glb", "glTF.accessors[0].byteOffset", "1099511627776"),
    "kind": (accessor(type="VEC2"), "a.glb", "glTF.accessors[0]", "type VEC2"),
    "component": (accessor(componentType=5130), "a.glb", "glTF.accessors[0].componentType", "5130"),
    "float_indices": (float_indices(), "a.glb", "glTF.accessors[1].componentType", "5126"),
    "no_view": (accessor(bufferView=9), "a.glb", "glTF.accessors[0].bufferView", "9"),
    "buffer": (changed(buffers=[{"byteLength": 2**30}]), "a.glb", "glTF.buffers[0]", "byteLength 1073741824"),
    "buffer_file": (
        changed(buffers=[{"byteLength": 42, "uri": "../../etc/passwd"}]),
        "a.glb",
        "glTF.buffers[0].uri",
        "outside",
    ),
    "base64": (
        changed(buffers=[{"byteLength": 42, "uri": "data:;base64,!"}]),
        "a.glb",
        "glTF.buffers[0].uri",
        "base64",
    ),
    "index": (one(glb(*model(faces=[[0, 1, 3]])), "a.glb"), "a.glb", "primitives[0]", "vertices [0, 1, 3]"),
    "infinite": (
        one(glb(*model([[0, 0, 0], [1, 0, 0], [0, float("inf"), 0]])), "a.glb"),
        "a.glb",
        "primitives[0]",
        "inf",
    ),
    "batch": (
        one(glb(*model(batch=[0, float("nan"), 0])), "a.glb"),
        "a.glb",
        "primitives[0]",
        "3 feature ids",
    ),
    "scale": (
        changed(nodes=[{"mesh": 0, "scale": [1e308, 1e308, 1e308]}]),
        "a.glb",
        "transform",
        "not finite",
    ),
    "no_subtree": (implicit(b"") | {"0.0.0.subtree": b"{}"}, "0.0.0.subtree", "file", "no member 'tileAv"),
    "subtree_header": (implicit(b"subt" + bytes(4)), "0.0.0.subtree", "header", "8 bytes"),
    "subtree_length": (
        implicit(subtree(NONE, lengths=(2**40, 0))),
        "0.0.0.subtree",
        "header",
        "1099511627776 + 0 bytes",
    ),
    "subtree_stream": (implicit(subtree(STREAM, [b""])), "0.0.0.subtree", "bufferViews[0]", "0 bytes"),
    "subtree_levels": (
        implicit(subtree(NONE), subtreeLevels=30, availableLevels=30),
        "tileset.json",
        "root.implicitTiling.subtreeLevels",
        "30 levels",
    ),
    "available": (
        implicit(subtree(NONE), availableLevels=10**9),
        "tileset.json",
        "root.implicitTiling.availableLevels",
        "1000000000",
    ),
    "scheme": (
        implicit(b"", subdivisionScheme="HEX"),
        "tileset.json",
        "implicitTiling.subdivisionScheme",
        "'HEX'",
    ),
    "next_subtree": (
        implicit(subtree({**NONE, "childSubtreeAvailability": {"constant": 1}}), availableLevels=4),
        "tileset.json",
        "root.implicitTiling.subtrees.uri",
        "'2.0.0.subtree', which is not there",
    ),
    "tile_file": (
        implicit(subtree({**ALL, "childSubtreeAvailability": {"constant": 0}})),
        "tileset.json",
        "root.content.uri",
        "'1.0.0.glb', which is not there",
    ),
    "contents": (
        implicit(subtree({**NONE, "contentAvailability": [{"constant": 0}] * 2})),
        "0.0.0.subtree",
        "file",
        "2 of contentAvailability",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_tilesets(name: str, tmp_path: Path) -> None:
    files, file, place, found = BAD[name]
    path = write(tmp_path / "set", files)
    tracemalloc.start()
    try:
        with pytest.raises(SceneError) as caught:
            read_tileset(path, "auto", 100_000)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert Path(caught.value.source).name == file
    assert place in caught.value.place
    assert found in str(caught.value)
    assert "; allowed: " in str(caught.value)
    # the largest inputs here are of 600 kB: what is claimed beyond that is never allocated
    assert peak < 32 << 20


def test_faces_are_counted_with_all_their_instances(tmp_path: Path) -> None:
    root = tile(children=[tile("a.glb") for _ in range(20)])
    path = write(tmp_path, {"tileset.json": tileset(root), "a.glb": ONE})
    assert len(read_tileset(path, "auto", 20).parts) == 20
    with pytest.raises(SceneError, match=r"1 faces, instances counted; allowed: at most 0 more"):
        read_tileset(path, "auto", 19)


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"tileset.json: file: found no file"):
        load_scene(tmp_path / "tileset.json")


def test_units_are_metres(tmp_path: Path) -> None:
    path = write(tmp_path, one(B3DM))
    with pytest.raises(SceneError, match="units: found ft; allowed: m"):
        load_scene(path, SceneSettings(units="ft"))
