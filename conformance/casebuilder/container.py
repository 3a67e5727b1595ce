"""Nav file and binary glTF, written byte by byte."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np

from casebuilder.state import COUNTS, Tables
from casebuilder.world import Triangle, World

Json = dict[str, Any]


def dumps(value: object) -> bytes:
    """JSON without blanks, members in the order in which they were added."""
    return json.dumps(value, separators=(",", ":")).encode()


def padded(data: bytes, fill: bytes, multiple: int) -> bytes:
    """Data filled up to a multiple of a length."""
    return data + fill * (-len(data) % multiple)


def nav_parts(tables: Tables, first_cell: int, cell_count: int) -> tuple[Json, bytes]:
    """JSON part and unpadded binary part of a nav file."""
    views: list[Json] = []
    groups: Json = {}
    binary = b""
    for name, table in tables.items():
        group, member = name.split(".")
        binary = padded(binary, b"\0", 8)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": table.nbytes})
        groups.setdefault(group, {})[member] = len(views) - 1
        binary += table.tobytes()
    for name, counted in COUNTS.items():
        group, member = name.split(".")
        groups[group][member] = len(tables[counted])
    groups["portals"]["polygonCount"] = len(tables["portals.polygonOffsets"]) - 1
    groups["portals"]["vertexCount"] = len(tables["portals.vertices"])
    head = {
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": views,
        "sector": {"firstCell": first_cell, "cellCount": cell_count},
    }
    return {**head, **groups}, binary


def nav_bytes(part: Json | bytes, binary: bytes) -> bytes:
    """Nav file of a JSON part, which may be given as bytes, and a binary part."""
    return container_bytes(b"nav1", part, binary)


def container_bytes(magic: bytes, part: Json | bytes, binary: bytes) -> bytes:
    """Nav file, or another container with the same header."""
    text = padded(part if isinstance(part, bytes) else dumps(part), b" ", 8)
    body = padded(binary, b"\0", 8)
    return struct.pack("<4sIQQ", magic, 1, len(text), len(body)) + text + body


def _primitive(
    gltf: Json, binary: bytes, triangles: tuple[Triangle, ...], world: World, *, indexed: bool
) -> bytes:
    step = float(world.step)
    # glTF is y-up: nav (x, y, z) is glTF (x, z, -y); adding 0.0 turns -0.0 into 0.0.
    corners = [(x * step, z * step, -y * step + 0.0) for face in triangles for x, y, z in face]
    points = list(dict.fromkeys(corners)) if indexed else corners
    positions = np.array(points, dtype="<f4")
    low, high = positions.min(axis=0).tolist(), positions.max(axis=0).tolist()
    gltf["accessors"].append(
        {
            "bufferView": len(gltf["bufferViews"]),
            "componentType": 5126,
            "count": len(points),
            "type": "VEC3",
            "min": low,
            "max": high,
        }
    )
    primitive: Json = {"attributes": {"POSITION": len(gltf["accessors"]) - 1}}
    gltf["bufferViews"].append(
        {"buffer": 0, "byteOffset": len(binary), "byteLength": positions.nbytes, "target": 34962}
    )
    binary += positions.tobytes()
    if indexed:
        indices = np.array([points.index(c) for c in corners], dtype="<u2")
        gltf["accessors"].append(
            {
                "bufferView": len(gltf["bufferViews"]),
                "componentType": 5123,
                "count": len(corners),
                "type": "SCALAR",
            }
        )
        primitive["indices"] = len(gltf["accessors"]) - 1
        gltf["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(binary), "byteLength": indices.nbytes, "target": 34963}
        )
        binary = padded(binary + indices.tobytes(), b"\0", 4)
    gltf["meshes"][0]["primitives"].append(primitive)
    return binary


def glb_parts(world: World, content: int) -> tuple[Json, bytes]:
    """JSON and binary chunk of a content; contents with an even number have indices."""
    gltf: Json = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": []}],
        "buffers": [],
        "bufferViews": [],
        "accessors": [],
    }
    binary = b""
    for item in world.objects:
        if item.content == content:
            binary = _primitive(gltf, binary, item.triangles, world, indexed=content % 2 == 0)
    gltf["buffers"] = [{"byteLength": len(binary)}]
    return gltf, binary


def glb_bytes(gltf: Json, binary: bytes) -> bytes:
    """Binary glTF 2.0 file."""
    text, body = padded(dumps(gltf), b" ", 4), padded(binary, b"\0", 4)
    length = 12 + 8 + len(text) + 8 + len(body)
    head = struct.pack("<4sII", b"glTF", 2, length)
    return (
        head
        + struct.pack("<I4s", len(text), b"JSON")
        + text
        + struct.pack("<I4s", len(body), b"BIN\0")
        + body
    )
