"""A small valid tileset, packed by hand from the layout in the specification.

A floor (object 0, faces 0 and 1, z = 0), a wall (object 1, faces 2 and 3, x = 4) and a face without area
(object 2, face 4). Cell 0 is -4 <= x <= 0, cell 1 is 0 <= x <= 3, both -2 <= y <= 2 and 1 <= z <= 3, with a
portal at x = 0. Cell 0 lists face 4 too, which is more than need be; so the delta is not empty.

Largest L: floor 1 / 1 m from both cells, wall 1 / 4 m and 1 / 1 m, face 4 none. With reference 3 and base 2
the codes are floor(log2 3) = 1, floor(log2 12) = 3, 1, and the last one, 15.
"""

from __future__ import annotations

import hashlib
import json
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tilesnav_validator.findings import Settings
from tilesnav_validator.runner import Result, judge

FLOOR = [[(-8, -8, 0), (8, -8, 0), (8, 8, 0)], [(-8, -8, 0), (8, 8, 0), (-8, 8, 0)]]
WALL = [[(4, -4, 0), (4, 4, 0), (4, 4, 4)], [(4, -4, 0), (4, 4, 4), (4, -4, 4)]]
FLAT = [[(0, 0, 0), (1, 0, 0), (2, 0, 0)]]

TYPES = {
    "planes": "<f8",
    "vertices": "<f8",
    "kinds": "u1",
    "digests": "u1",
    "codes": "u1",
    "switchCodes": "u1",
}


def box_planes(low: tuple[float, ...], high: tuple[float, ...]) -> list[list[float]]:
    """Planes of an axis-aligned box: for each axis the lower side, then the upper side."""
    planes = []
    for axis in range(3):
        for sign, bound in ((-1.0, low[axis]), (1.0, high[axis])):
            normal = [0.0, 0.0, 0.0]
            normal[axis] = sign
            planes.append([*normal, -sign * bound])
    return planes


def state_digest(faces: list[int], objects: list[int], codes: list[int]) -> list[int]:
    """SHA-256 of the canonical bytes, written out as the specification does."""
    text = struct.pack(f"<I{len(faces)}I", len(faces), *faces) + struct.pack(
        f"<I{len(objects)}I", len(objects), *objects
    )
    return list(hashlib.sha256(text + bytes(codes)).digest())


def pack_glb(root: dict[str, Any], binary: bytes) -> bytes:
    """A binary glTF of a JSON part and a binary part."""
    text = json.dumps(root).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    body = (
        struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    )
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def gltf(objects: list[list[list[tuple[float, ...]]]]) -> tuple[dict[str, Any], bytes]:
    """JSON and binary part of a glTF with one primitive for each object, without indices, y up."""
    binary, views, accessors, primitives = b"", [], [], []
    for number, triangles in enumerate(objects):
        points = [(x, z, -y) for triangle in triangles for x, y, z in triangle]
        data = np.array(points, dtype="<f4").tobytes()
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        accessors.append({"bufferView": number, "componentType": 5126, "count": len(points), "type": "VEC3"})
        primitives.append({"attributes": {"POSITION": number}})
        binary += data
    root = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": primitives}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    return root, binary


def tables() -> dict[str, dict[str, Any]]:
    """Tables of the small tileset, by group and member; numbers that are counts are computed when packed."""
    return {
        "cells": {
            "planes": [box_planes((-4, -2, 1), (0, 2, 3)), box_planes((0, -2, 1), (3, 2, 3))],
            "kinds": [0, 1],
        },
        "portals": {
            "offsets": [0, 1, 2],
            "targets": [1, 0],
            "polygons": [0, 0],
            "polygonOffsets": [0, 4],
            "vertices": [[0, -2, 1], [0, 2, 1], [0, 2, 3], [0, -2, 3]],
        },
        "pvs": {
            "offsets": [0, 5, 9],
            "faces": [0, 1, 2, 3, 4, 0, 1, 2, 3],
            "provenVisible": [4, 4],
            "digests": [
                state_digest([0, 1, 2, 3, 4], [0, 1, 2], [1, 3, 15]),
                state_digest([0, 1, 2, 3], [0, 1], [1, 1]),
            ],
        },
        "lod": {"offsets": [0, 3, 5], "objects": [0, 1, 2, 0, 1], "codes": [1, 3, 15, 1, 1]},
        "deltas": {
            "enteredOffsets": [0, 0, 1],
            "entered": [4],
            "leftOffsets": [0, 1, 1],
            "left": [4],
            "switchOffsets": [0, 1, 3],
            "switchObjects": [1, 1, 2],
            "switchCodes": [1, 3, 15],
        },
    }


COUNTS = {
    "portals": {"count": "targets", "polygonCount": "polygonOffsets", "vertexCount": "vertices"},
    "pvs": {"count": "faces"},
    "lod": {"count": "objects"},
    "deltas": {"enteredCount": "entered", "leftCount": "left", "switchCount": "switchObjects"},
}


def pack_tables(groups: dict[str, dict[str, Any]]) -> tuple[dict[str, Any], bytes]:
    """JSON and binary part of a nav file."""
    root: dict[str, Any] = {
        "sector": {"firstCell": 0, "cellCount": len(groups["cells"]["kinds"])},
        "bufferViews": [],
    }
    binary = b""
    for group, members in groups.items():
        root[group] = {}
        for name, values in members.items():
            data = np.array(values, dtype=TYPES.get(name, "<u4")).tobytes()
            binary += b"\0" * (-len(binary) % 8)
            root[group][name] = len(root["bufferViews"])
            root["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
            binary += data
        for count, table in COUNTS.get(group, {}).items():
            root[group][count] = len(members[table]) - (table == "polygonOffsets")
    root["buffers"] = [{"byteLength": len(binary)}]
    return root, binary


def pack_nav(root: dict[str, Any], binary: bytes) -> bytes:
    """A nav file of a JSON part and a binary part."""
    text = json.dumps(root).encode()
    text += b" " * (-len(text) % 8)
    binary += b"\0" * (-len(binary) % 8)
    return struct.pack("<4sIQQ", b"nav1", 1, len(text), len(binary)) + text + binary


@dataclass
class Small:
    """The small tileset; change members, then write it.

    Attributes
    ----------
    glb, nav : bytes or None
        Contents of the files; None to make them of ``objects`` and ``groups``.
    """

    objects: list[Any] = field(default_factory=lambda: [FLOOR, WALL, FLAT])
    groups: dict[str, dict[str, Any]] = field(default_factory=tables)
    glb: bytes | None = None
    nav: bytes | None = None
    transform: list[float] = field(default_factory=lambda: np.eye(4).flatten().tolist())

    def __post_init__(self) -> None:
        volume = {"box": [0, 0, 2, 8, 0, 0, 0, 8, 0, 0, 0, 2]}
        content = {"contentId": 0, "level": 0, "faceCount": 5, "objectCount": 3, "sha256": ""}
        self.root: dict[str, Any] = {
            "boundingVolume": volume,
            "geometricError": 0,
            "refine": "REPLACE",
            "content": {"uri": "0.glb", "extensions": {"3DTILES_nav": content}},
        }
        self.extension: dict[str, Any] = {
            "version": "0.1.0",
            "grid": {"exponent": -10},
            "transform": self.transform,
            "clearance": 0.25,
            "faceCount": 5,
            "objectCount": 3,
            "cellCount": 2,
            "portalCount": 2,
            "sectors": [
                {
                    "uri": "0.nav",
                    "firstCell": 0,
                    "cellCount": 2,
                    "boundingVolume": {"box": [-0.5, 0, 2, 3.5, 0, 0, 0, 2, 0, 0, 0, 1]},
                }
            ],
            "lod": {"reference": 3.0, "base": 2.0, "levelCount": 16},
            "pvs": {"listed": 9, "provenVisible": 8},
            "provenance": {"encoder": "by hand", "parameters": {}, "coverage": 0.5},
        }
        self.tileset: dict[str, Any] = {
            "asset": {"version": "1.1"},
            "extensionsUsed": ["3DTILES_nav"],
            "geometricError": 1,
            "extensions": {"3DTILES_nav": self.extension},
            "root": self.root,
        }

    def write(self, folder: Path) -> Path:
        """Write the files; return the path of the entry tileset."""
        folder.mkdir(parents=True, exist_ok=True)
        glb = pack_glb(*gltf(self.objects)) if self.glb is None else self.glb
        nav = pack_nav(*pack_tables(self.groups)) if self.nav is None else self.nav
        (folder / "0.glb").write_bytes(glb)
        (folder / "0.nav").write_bytes(nav)
        content = self.root.get("content", {}).get("extensions", {}).get("3DTILES_nav")
        if content is not None and content["sha256"] == "":
            content["sha256"] = hashlib.sha256(glb).hexdigest()
        path = folder / "tileset.json"
        path.write_text(json.dumps(self.tileset), encoding="utf-8")
        return path


def failures(path: Path, rays: int = 2000) -> list[str]:
    """Ids of the requirements that fail."""
    return failed(judge(path, Settings(rays=rays)))


def failed(result: Result) -> list[str]:
    """Ids of the requirements that fail in a result."""
    return [judgement.requirement.id for judgement in result.judgements if judgement.verdict == "fail"]
