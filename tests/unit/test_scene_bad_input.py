"""Bad files: each error names the file, the place, what was found and what is allowed."""

from __future__ import annotations

import json
import random
import struct
from pathlib import Path

import pytest
import trimesh

from tilesnav_ref.scene import SceneError, SceneSettings, load_scene
from tilesnav_ref.scene.read import read_mesh

PLY = (
    "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n"
    "element face {faces}\nproperty list uchar int vertex_indices\nend_header\n{body}"
)
POINTS = "0 0 0\n1 0 0\n0 1 0\n"


def ply(body: str, vertices: object = 3, faces: object = 1) -> bytes:
    return PLY.format(vertices=vertices, faces=faces, body=body).encode()


def binary_ply(vertices: int, faces: int, body: bytes) -> bytes:
    text = PLY.format(vertices=vertices, faces=faces, body="").replace("ascii", "binary_little_endian")
    return text.encode() + body


def glb(document: object, binary: bytes = b"") -> bytes:
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if binary:
        chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


ACCESSOR = {"count": 3, "type": "VEC3", "componentType": 5126}
ASSET = {"version": "2.0"}


def used(**members: object) -> dict[str, object]:
    """A document whose scene needs all of its buffer."""
    return {
        "asset": ASSET,
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{**ACCESSOR, "bufferView": 0}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36}],
        **members,
    }


def text(**buffer: object) -> bytes:
    return json.dumps(used(buffers=[{"byteLength": 36, **buffer}])).encode()


BAD = {
    "empty.ply": (b"", "file", "0 bytes"),
    "text.ply": (b"not a mesh at all\n", "header", "not a mesh"),
    "no_end.ply": (b"ply\nformat ascii 1.0\n", "header", "no end_header"),
    "nan.ply": (ply("0 0 0\nnan 0 0\n0 1 0\n3 0 1 2\n"), "vertex 1", "nan"),
    "inf.ply": (ply("0 0 0\n1 0 0\n0 inf 0\n3 0 1 2\n"), "vertex 2", "inf"),
    "index_high.ply": (ply(POINTS + "3 0 1 7\n"), "face 0", "[0, 1, 7]"),
    "index_negative.ply": (ply(POINTS + "3 0 1 -1\n"), "face 0", "[0, 1, -1]"),
    "no_faces.ply": (ply(POINTS, faces=0), "file", "no face"),
    "truncated.ply": (ply(POINTS + "3 0 1 2       \n", faces=2), "faces", "1 of the 2"),
    "ten_gigabytes.ply": (binary_ply(10**7, 10**7, bytes(36)), "header", "in a body of 37 bytes"),
    "beyond_limit.ply": (binary_ply(10**12, 1, bytes(36)), "header line 3", "1000000000000 elements"),
    "huge_number.ply": (ply(POINTS, vertices="9" * 5000), "header line 3", "elements"),
    "negative_count.ply": (ply(POINTS, vertices=-3), "header line 3", "-3"),
    "odd_type.ply": (ply(POINTS).replace(b"float x", b"complex x"), "header line 4", "complex"),
    "flat.ply": (ply("0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n"), "faces", "none with area"),
    "far.ply": (ply("690000 0 0\n690001 0 0\n690000 1 0\n3 0 1 2\n"), "vertex at (690000", "2^23"),
    "beyond_float.ply": (
        ply("1e300 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").replace(b"float", b"double"),
        "vertex 0",
        "1.e+300",
    ),
    "empty.stl": (b"", "file", "0 bytes"),
    "text.stl": (b"hello", "header", "hello"),
    "claims.stl": (bytes(80) + struct.pack("<I", 2**31) + bytes(50), "header", "134 bytes"),
    "nan.stl": (
        bytes(80) + struct.pack("<I12fH", 1, *(9 * [0.0]), *(3 * [float("nan")]), 0),
        "vertex 2",
        "nan",
    ),
    "index_high.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "line 4", "'9'"),
    "index_zero.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "line 4", "'0'"),
    "index_back.obj": (b"v 0 0 0\nv 1 0 0\nf -3 1 2\nv 0 1 0\n", "line 3", "'-3'"),
    "index_word.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n", "line 4", "'x'"),
    "lines.obj": (b"v 0 0 0\nv 1 0 0\nl 1 2\n", "file", "no face"),
    "text.obj": (b"hello\n", "file", "no face"),
    "text.off": (b"hello\n", "header", "hello"),
    "index_high.off": (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 5\n", "content", "ValueError"),
    "claims.off": (b"OFF\n3000000000 1 0\n0 0 0\n", "content", "ValueError"),
    "text.glb": (b"hello, this is no glTF file", "header", "hello"),
    "version.glb": (struct.pack("<4sIIII", b"glTF", 1, 20, 0, 0), "header", "version 1"),
    "length.glb": (struct.pack("<4sIIII", b"glTF", 2, 10**9, 0, 0x4E4F534A), "header", "length 1000000000"),
    "chunk.glb": (
        struct.pack("<4sIIII", b"glTF", 2, 20, 10**9, 0x4E4F534A),
        "first chunk",
        "1000000000 bytes",
    ),
    "list.glb": (glb([1, 2]), "glTF", "[1, 2]"),
    "buffer.glb": (glb(used(buffers=[{"byteLength": 10**9}])), "buffers[0]", "byteLength 1000000000"),
    "negative.glb": (glb(used(buffers=[{"byteLength": -1}])), "buffers[0].byteLength", "-1"),
    "zeros.glb": (glb(used(accessors=[{**ACCESSOR, "count": 10**9}])), "accessors[0].count", "1000000000"),
    "typeless.glb": (glb(used(accessors=[{"count": 1}])), "accessors[0]", "no member 'componentType'"),
    "no_data.glb": (glb(used(accessors=[ACCESSOR])), "accessors[0]", "neither bufferView nor sparse"),
    "unknown.glb": (glb(used(extensionsRequired=["X_secret"])), "extensionsRequired[0]", "X_secret"),
    "meshless.glb": (glb({"asset": ASSET, "scenes": [{"nodes": []}], "scene": 0}), "file", "no face"),
    "escape.gltf": (text(uri="../../secret.bin"), "buffers[0].uri", "secret"),
    "absent.gltf": (text(uri="a.bin"), "buffers[0].uri", "a.bin"),
    "uri.gltf": (text(uri=7), "buffers[0].uri", "7"),
    "text.gltf": (b"{", "file", "Expecting"),
    "members.glb": (glb(used(buffers={})), "buffers", "an object"),
    "mesh.xyz": (b"0 0 0\n", "name", ".xyz"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_file_is_refused_with_its_place(tmp_path: Path, name: str) -> None:
    data, place, found = BAD[name]
    path = tmp_path / name
    path.write_bytes(data)
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    error = caught.value
    assert error.source == str(path)
    assert place in error.place
    assert found in error.found
    assert error.allowed
    assert str(error) == f"{error.source}: {error.place}: found {error.found}; allowed: {error.allowed}"


def test_absent_file_and_folder_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="No such file"):
        load_scene(tmp_path / "absent.ply")
    folder = tmp_path / "folder.ply"
    folder.mkdir()
    with pytest.raises(SceneError, match="Is a directory"):
        load_scene(folder)


def test_far_scene_is_told_its_middle(tmp_path: Path) -> None:
    path = tmp_path / "far.ply"
    path.write_bytes(BAD["far.ply"][0])
    with pytest.raises(SceneError, match=r"--origin \(to the middle: 690000,0,0 m\)"):
        load_scene(path)


def test_instances_are_counted_before_they_are_made(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    box = trimesh.creation.box()
    scene.add_geometry(box, geom_name="box")
    for k in range(9):
        scene.graph.update(
            f"copy {k}", geometry="box", matrix=trimesh.transformations.translation_matrix((k, 0, 0))
        )
    path = tmp_path / "many.glb"
    path.write_bytes(scene.export(file_type="glb"))
    assert len(read_mesh(path, 120).parts) == 10
    with pytest.raises(SceneError, match="120 faces, instances counted"):
        read_mesh(path, 119)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("units", "furlong"),
        ("up", "w"),
        ("grid_exponent", 1),
        ("grid_exponent", -21),
        ("region", (0.0, 0.0, 0.0, 1.0)),
        ("region", (0.0, 0.0, float("nan"), 1.0)),
        ("region_margin", -1.0),
        ("origin", (0.0, float("inf"), 0.0)),
        ("object_faces_min", 0),
        ("object_faces_max", 15),
        ("object_reach", float("nan")),
        ("content_faces", 0),
        ("max_faces", 2**31),
    ],
)
def test_bad_setting_is_named(name: str, value: object) -> None:
    with pytest.raises(SceneError) as caught:
        SceneSettings(**{name: value})  # type: ignore[arg-type]
    assert (caught.value.source, caught.value.place) == ("settings", name)


@pytest.mark.parametrize(
    ("settings", "place"),
    [
        ({"crs": "enu"}, "origin"),
        ({"crs": "enu", "origin": (181.0, 0.0, 0.0)}, "origin"),
        ({"crs": "EPSG:25832", "units": "ft"}, "units"),
    ],
)
def test_settings_that_contradict_are_refused(settings: dict[str, object], place: str) -> None:
    with pytest.raises(SceneError) as caught:
        SceneSettings(**settings)  # type: ignore[arg-type]
    assert caught.value.place == place


def _damaged(generator: random.Random, data: bytes) -> bytes:
    """Change, cut, overwrite or insert a few bytes."""
    words = (b"nan", b"-1", b"99999999999", b"1e308", b"\0\0\0\0", b"\xff\xff\xff\xff", b"null", b"{}")
    damaged = bytearray(data)
    for _ in range(generator.randint(1, 4)):
        at = generator.randrange(len(damaged) + 1)
        word = generator.choice(words)
        match generator.randrange(4):
            case 0:
                damaged[at : at + 1] = bytes([generator.randrange(256)])
            case 1:
                del damaged[at:]
            case 2:
                damaged[at : at + len(word)] = word
            case _:
                damaged[at:at] = word
    return bytes(damaged)


@pytest.mark.parametrize("suffix", ["ply", "stl", "obj", "off", "glb"])
def test_damaged_files_give_a_scene_or_a_scene_error(tmp_path: Path, suffix: str) -> None:
    exported = trimesh.creation.box((2, 3, 4)).export(file_type=suffix)
    data = exported.encode() if isinstance(exported, str) else exported
    generator = random.Random(5)
    path = tmp_path / f"damaged.{suffix}"
    refused = accepted = 0
    for _ in range(60):
        path.write_bytes(_damaged(generator, data))
        try:
            scene, _ = load_scene(path)
        except SceneError as error:
            refused += str(path) in str(error)
        else:
            accepted += scene.face_count > 0
    assert refused + accepted == 60
    assert refused > 20


def test_stl_of_more_faces_than_allowed_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "box.stl"
    path.write_bytes(trimesh.creation.box().export(file_type="stl"))
    with pytest.raises(SceneError, match="12 faces; allowed: at most 11"):
        load_scene(path, SceneSettings(max_faces=11))


def test_face_of_obj_that_goes_on_in_the_next_line_is_checked(tmp_path: Path) -> None:
    path = tmp_path / "long.obj"
    path.write_bytes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 7 \\\n3\n")
    with pytest.raises(SceneError, match="line 4"):
        load_scene(path)


def test_text_stl_in_another_encoding_is_read(tmp_path: Path) -> None:
    path = tmp_path / "named.stl"
    text = trimesh.exchange.stl.export_stl_ascii(trimesh.creation.box())
    path.write_bytes(text.replace("solid", "solid h\xe4user", 1).encode("latin-1"))
    assert load_scene(path)[0].face_count == 12
