"""Small tilesets, written byte by byte."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

A, B = 6378137.0, 6356752.314245179
"""Axes of the WGS 84 ellipsoid, metres."""
TRIANGLE = np.array(((0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (0.0, 0.0, -3.0)))
"""Corners in the axes of glTF (y up): flat on the ground, 4 m along x and 3 m along y of the tile."""
Y_UP_TO_Z_UP = np.array(((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0)))


def padded(data: bytes, fill: bytes = b"\0", to: int = 4) -> bytes:
    return data + fill * (-len(data) % to)


def glb(document: dict[str, Any], binary: bytes = b"") -> bytes:
    text = padded(json.dumps(document).encode(), b" ")
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if binary:
        binary = padded(binary)
        chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def model(
    vertices: np.ndarray = TRIANGLE,
    faces: Iterable[Iterable[int]] = ((0, 1, 2),),
    batch: Iterable[float] | None = None,
    node: dict[str, Any] | None = None,
    **members: Any,
) -> tuple[dict[str, Any], bytes]:
    """Document and binary chunk of one mesh in one node."""
    arrays = {
        "POSITION": np.asarray(vertices, "<f4").tobytes(),
        "indices": np.asarray(faces, "<u2").tobytes(),
    }
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"},
        {"bufferView": 1, "componentType": 5123, "count": np.size(faces), "type": "SCALAR"},
    ]
    attributes = {"POSITION": 0}
    if batch is not None:
        arrays["batch"] = np.asarray(batch, "<f4").tobytes()
        accessors.append({"bufferView": 2, "componentType": 5126, "count": len(vertices), "type": "SCALAR"})
        attributes["_BATCHID"] = 2
    views, binary = [], b""
    for data in arrays.values():
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        binary = padded(binary + data)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, **(node or {})}],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 1}]}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
        **members,
    }
    return document, binary


def b3dm(
    content: bytes,
    feature: dict[str, Any] | None = None,
    batch: dict[str, Any] | None = None,
    feature_binary: bytes = b"",
) -> bytes:
    tables = [
        padded(json.dumps(feature or {"BATCH_LENGTH": 0}).encode(), b" "),
        padded(feature_binary),
        padded(json.dumps(batch).encode(), b" ") if batch else b"",
        b"",
    ]
    lengths = [len(table) for table in tables]
    return (
        struct.pack("<4s6I", b"b3dm", 1, 28 + sum(lengths) + len(content), *lengths)
        + b"".join(tables)
        + content
    )


def cmpt(*tiles: bytes) -> bytes:
    body = b"".join(tiles)
    return struct.pack("<4s3I", b"cmpt", 1, 16 + len(body), len(tiles)) + body


def other_tile(magic: bytes) -> bytes:
    return struct.pack("<4s2I", magic, 1, 32) + bytes(20)


def tileset(root: dict[str, Any], **members: Any) -> dict[str, Any]:
    return {
        "asset": {"version": "1.1"},
        "geometricError": 100.0,
        "root": {"refine": "ADD", **tile(), **root},
        **members,
    }


def tile(uri: str | None = None, **members: Any) -> dict[str, Any]:
    """A tile whose declared volume is a lie: it bounds nothing of the content."""
    content = {} if uri is None else {"content": {"uri": uri}}
    volume = {"box": [1e5, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]}
    return {"boundingVolume": volume, "geometricError": 1.0, **content, **members}


def write(folder: Path, files: dict[str, Any]) -> Path:
    """Write files, dictionaries as JSON; the first is the entry."""
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data if isinstance(data, bytes) else json.dumps(data).encode())
    return folder / next(iter(files))


def moved(x: float, y: float, z: float = 0.0) -> list[float]:
    """Transform of a tile: a translation, by columns."""
    return [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1]


def subtree(
    document: dict[str, Any], streams: Iterable[bytes] = (), lengths: tuple[int, int] | None = None
) -> bytes:
    """A binary subtree whose buffer view k is stream k."""
    views, binary = [], b""
    for stream in streams:
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(stream)})
        binary = padded(binary + stream, to=8)
    document = {"buffers": [{"byteLength": len(binary)}], "bufferViews": views, **document}
    text = padded(json.dumps(document).encode(), b" ", 8)
    sizes = lengths or (len(text), len(binary))
    return struct.pack("<4sIQQ", b"subt", 1, *sizes) + text + binary


def ecef(longitude: float, latitude: float, height: float) -> np.ndarray:
    """Earth-centred position from the two axes of the ellipsoid, in degrees and metres."""
    lon, lat = np.radians(longitude), np.radians(latitude)
    normal = A**2 / np.sqrt((A * np.cos(lat)) ** 2 + (B * np.sin(lat)) ** 2)
    flat = (normal + height) * np.cos(lat)
    polar = ((B / A) ** 2 * normal + height) * np.sin(lat)
    return np.array((flat * np.cos(lon), flat * np.sin(lon), polar))


def axes(longitude: float, latitude: float) -> np.ndarray:
    """(3, 3) rows east, north, up: up by the definition of latitude, the others by cross products."""
    lon, lat = np.radians(longitude), np.radians(latitude)
    up = np.array((np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)))
    east = np.cross((0.0, 0.0, 1.0), up)
    east /= np.linalg.norm(east)
    return np.array((east, np.cross(up, east), up))


def earth_transform(longitude: float, latitude: float, height: float) -> list[float]:
    """Transform of a tile whose axes are east, north and up there, by columns."""
    matrix = np.eye(4)
    matrix[:3, :3] = axes(longitude, latitude).T
    matrix[:3, 3] = ecef(longitude, latitude, height)
    return matrix.T.ravel().tolist()
