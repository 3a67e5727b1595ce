"""Contents that others wrote: what our reader takes and what it refuses."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.glb import open_glb

POSITIONS = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [1, 2, -3]], dtype="<f4")
INDICES = np.array([0, 1, 2, 2, 1, 3], dtype="<u2")


def _document() -> dict[str, Any]:
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 60}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 12},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    }


def _write(path: Path, document: dict[str, Any], binary: bytes) -> Path:
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = (
        struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    )
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
    return path


BINARY = POSITIONS.tobytes() + INDICES.tobytes()


def test_indexed_without_the_members_that_have_defaults(tmp_path: Path) -> None:
    glb = open_glb(_write(tmp_path / "a.glb", _document(), BINARY))
    assert glb.face_counts == (2,)
    # glTF (x, y, z) is nav (x, -z, y).
    assert glb.corners(0).tolist() == [
        [[0, 0, 0], [1, 0, 0], [0, 0, 2]],
        [[0, 0, 2], [1, 0, 0], [1, 3, 2]],
    ]


def test_not_indexed(tmp_path: Path) -> None:
    document = _document()
    del document["meshes"][0]["primitives"][0]["indices"]
    document["accessors"][0]["count"] = 3
    glb = open_glb(_write(tmp_path / "a.glb", document, BINARY))
    assert glb.face_counts == (1,)
    assert glb.corners(0).tolist() == [[[0, 0, 0], [1, 0, 0], [0, 0, 2]]]


def test_interleaved(tmp_path: Path) -> None:
    document = _document()
    rows = np.zeros((4, 5), dtype="<f4")
    rows[:, 1:4] = POSITIONS
    document["bufferViews"][0] = {"buffer": 0, "byteLength": 80, "byteStride": 20}
    document["bufferViews"][1]["byteOffset"] = 80
    document["accessors"][0]["byteOffset"] = 4
    glb = open_glb(_write(tmp_path / "a.glb", document, rows.tobytes() + INDICES.tobytes()))
    assert glb.corners(0)[1].tolist() == [[0, 0, 2], [1, 0, 0], [1, 3, 2]]


BAD: dict[str, tuple[Callable[[dict[str, Any]], Any], str]] = {
    "lines": (lambda d: d["meshes"][0]["primitives"][0].update(mode=1), "TRIANGLES"),
    "no such accessor": (lambda d: d["meshes"][0]["primitives"][0].update(indices=2), "indices: found 2"),
    "five corners": (lambda d: d["accessors"][1].update(count=5), "multiple of 3"),
    "beyond the view": (lambda d: d["accessors"][1].update(count=9), "18 bytes"),
    "claims billions": (lambda d: d["accessors"][0].update(count=2**31), "length of the buffer view"),
    "view beyond the buffer": (lambda d: d["bufferViews"][0].update(byteLength=100), "byteLength: found 100"),
    "positions of another type": (lambda d: d["accessors"][0].update(componentType=5123), "not sparse"),
    "indices of another type": (lambda d: d["accessors"][1].update(componentType=5126), "not sparse"),
    "sparse": (lambda d: d["accessors"][0].update(sparse={}), "not sparse"),
    "other buffer": (lambda d: d["bufferViews"][0].update(buffer=1), "buffer: found 1"),
    "no positions": (lambda d: d["meshes"][0]["primitives"][0].update(attributes={}), "required"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_documents(tmp_path: Path, name: str) -> None:
    change, message = BAD[name]
    document = _document()
    change(document)
    glb = open_glb(_write(tmp_path / "a.glb", document, BINARY))

    def read() -> object:
        return glb.face_counts, glb.corners(0)

    with pytest.raises(TilesetError, match=message):
        read()


def test_an_index_beyond_the_positions(tmp_path: Path) -> None:
    wrong = POSITIONS.tobytes() + np.array([0, 1, 2, 2, 1, 4], dtype="<u2").tobytes()
    glb = open_glb(_write(tmp_path / "a.glb", _document(), wrong))
    with pytest.raises(TilesetError, match="indices: found 4; allowed: numbers less than 4"):
        glb.corners(0)


@pytest.mark.parametrize(
    ("offset", "data"),
    [(0, b"GLTF"), (4, b"\1"), (8, b"\0"), (12, b"\xff\xff\xff\x7f"), (16, b"BIN\0")],
)
def test_bad_headers(tmp_path: Path, offset: int, data: bytes) -> None:
    path = _write(tmp_path / "a.glb", _document(), BINARY)
    old = path.read_bytes()
    path.write_bytes(old[:offset] + data + old[offset + len(data) :])
    with pytest.raises(TilesetError, match=r"header|chunk"):
        open_glb(path)
