"""Compressed geometry of glTF: Draco and meshopt, decoded by libraries that the extra `tiles` installs."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.gltf.values import Value

DRACO = "KHR_draco_mesh_compression"
MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
FILTERS = ("NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL")
DRACO_FAILURES = (ValueError, TypeError, RuntimeError, MemoryError, AttributeError, OverflowError)
"""What the decoder raises on broken data."""


@dataclass(frozen=True)
class DracoMesh:
    """What a Draco buffer holds."""

    faces: NDArray[np.int64]
    """(F, 3)."""
    attributes: dict[int, NDArray[np.generic]]
    """By unique id: (V, components)."""


def decode_draco(place: Value, data: memoryview, most: tuple[int, int]) -> DracoMesh:
    """Decode a mesh of KHR_draco_mesh_compression.

    Parameters
    ----------
    place : Value
        Named in errors.
    data : memoryview
        The compressed buffer.
    most : (faces, vertices)
        Most that it may claim.

    Raises
    ------
    SceneError
        When the decoder is not installed, or the buffer is broken or claims more.
    """
    library = _library(place, "DracoPy", "Draco")
    faces, points = _draco_claims(place, bytes(data[:64]))
    if faces > most[0] or points > most[1]:
        found = f"{faces} faces and {points} points claimed"
        raise place.error(found, f"at most the {most[0]} and {most[1]} of the accessors")
    try:
        mesh = library.decode(bytes(data))
        triangles = np.asarray(mesh.faces, np.int64).reshape(-1, 3)
        attributes = {int(one["unique_id"]): np.asarray(one["data"]) for one in mesh.attributes}
    except (*DRACO_FAILURES, library.FileTypeException) as error:
        raise place.error(f"{type(error).__name__}: {error}", "a Draco mesh") from error
    return DracoMesh(triangles, attributes)


def _draco_claims(place: Value, head: bytes) -> tuple[int, int]:
    """Faces and points that the head of a Draco buffer claims (Draco bitstream 2.2, sections 4 and 5)."""
    allowed = "a Draco mesh of version 2.2 without metadata"
    if len(head) < 13 or head[:5] != b"DRACO":
        raise place.error(repr(head[:16]), allowed)
    version, kind, method, flags = (head[5], head[6]), head[7], head[8], int.from_bytes(head[9:11], "little")
    if version != (2, 2) or kind != 1 or method > 1 or flags & 0x8000:
        found = f"version {version[0]}.{version[1]}, type {kind}, method {method}, flags {flags:#x}"
        raise place.error(found, allowed)
    start = 11 + method  # edge breaker has the kind of its traversal first
    first, start = _varint(place, head, start)
    second, _ = _varint(place, head, start)
    # sequential: faces, points; edge breaker: vertices, faces
    return (first, second) if method == 0 else (second, first)


def _varint(place: Value, data: bytes, start: int) -> tuple[int, int]:
    value = 0
    for k in range(5):
        if start + k >= len(data):
            break
        value |= (data[start + k] & 127) << (7 * k)
        if data[start + k] < 128:
            return value, start + k + 1
    raise place.error("a number without an end", "a Draco mesh")


def decode_meshopt(packed: Value, data: memoryview, limit: int, room: int) -> bytes:
    """Decode a buffer view of EXT_meshopt_compression.

    Parameters
    ----------
    packed : Value
        The extension object of the buffer view.
    data : memoryview
        The compressed bytes.
    limit : int
        Most elements.
    room : int
        Most bytes that may come of it.

    Raises
    ------
    SceneError
        When the decoder is not installed, or the data is broken or would take too much.
    """
    library = _library(packed, "meshopt", "meshopt")
    count = packed.need("count").integer(1, limit)
    stride = packed.need("byteStride").integer(1, 256)
    mode = packed.need("mode").one_of(("ATTRIBUTES", "TRIANGLES", "INDICES"))
    given = packed.member("filter")
    chosen = "NONE" if given is None else given.one_of(FILTERS)
    if count * stride > room:
        raise packed.error(f"{count} elements of {stride} bytes", f"at most {room} bytes")
    try:
        decoded = library.decode_gltf_buffer(bytes(data), count, stride, mode, chosen)
    except (ValueError, TypeError, RuntimeError, MemoryError) as error:
        raise packed.error(f"{type(error).__name__}: {error}", "meshopt data as it is stated") from error
    return np.ascontiguousarray(decoded).tobytes()


def _library(place: Value, name: str, format_name: str) -> Any:
    """Import a decoder, which only compressed files need."""
    try:
        return import_module(name)
    except ImportError as error:
        raise SceneError(
            place.source,
            place.place,
            f"geometry compressed with {format_name}, and no {name}",
            f"{name} installed (pip install 'tilesnav[tiles]'), or glTF that is not compressed",
        ) from error
