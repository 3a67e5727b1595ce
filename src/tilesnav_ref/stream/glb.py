"""Reading the faces of a binary glTF content: its counts first, its geometry when it is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from struct import Struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.fields import JSON_LIMIT, Fields, parse_object

HEADER = Struct("<4sIII4s")
"""Magic, version and length of the file; length and type of its first chunk."""
CHUNK = Struct("<I4s")
TRIANGLES = 4
COMPONENTS = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}


@dataclass(frozen=True)
class Glb:
    """A binary glTF, mapped into memory."""

    source: str
    document: Fields
    binary: NDArray[np.uint8]

    @cached_property
    def primitives(self) -> tuple[Fields, ...]:
        """All primitives in document order."""
        return tuple(
            p for mesh in self.document.list_of_fields("meshes") for p in mesh.list_of_fields("primitives")
        )

    @cached_property
    def accessors(self) -> list[Fields]:
        """Accessors of the document."""
        return self.document.list_of_fields("accessors")

    @cached_property
    def views(self) -> list[Fields]:
        """Buffer views of the document."""
        return self.document.list_of_fields("bufferViews")

    @property
    def face_counts(self) -> tuple[int, ...]:
        """Number of triangles of every primitive."""
        return tuple(self._face_count(primitive) for primitive in self.primitives)

    def corners(self, primitive_index: int) -> NDArray[np.float32]:
        """Corners of the faces of one primitive.

        Returns
        -------
        (F, 3, 3) float32
            Metres, nav frame.

        Raises
        ------
        TilesetError
            When an accessor is outside of its buffer view, or an index outside of the positions.
        """
        primitive = self.primitives[primitive_index]
        turned = self._read(primitive.fields("attributes"), "POSITION", 3)
        positions = np.stack((turned[:, 0], -turned[:, 2] + 0.0, turned[:, 1]), axis=1)
        if primitive.has("indices"):
            indices = self._read(primitive, "indices", 1)[:, 0]
            if indices.size and int(indices.max()) >= len(positions):
                raise primitive.error("indices", int(indices.max()), f"numbers less than {len(positions)}")
            positions = positions[indices]
        return positions.reshape(-1, 3, 3).astype(np.float32)

    def _face_count(self, primitive: Fields) -> int:
        if primitive.has("mode") and primitive.integer("mode") != TRIANGLES:
            raise primitive.error("mode", primitive.integer("mode"), "4, TRIANGLES")
        owner, name = (
            (primitive, "indices")
            if primitive.has("indices")
            else (primitive.fields("attributes"), "POSITION")
        )
        count = self._accessor(owner, name).integer("count")
        if count % 3:
            raise owner.error(name, f"{count} corners", "a multiple of 3")
        return count // 3

    def _accessor(self, owner: Fields, name: str) -> Fields:
        return self.accessors[owner.integer(name, 0, len(self.accessors) - 1)]

    def _read(self, owner: Fields, name: str, width: int) -> NDArray[Any]:
        accessor = self._accessor(owner, name)
        allowed = (5126,) if width == 3 else (5121, 5123, 5125)
        component = accessor.integer("componentType")
        kind = accessor.text("type")
        if component not in allowed or kind != ("VEC3" if width == 3 else "SCALAR") or accessor.has("sparse"):
            raise owner.error(
                name, f"{kind} of component type {component}", f"component type {allowed}, not sparse"
            )
        view = self.views[accessor.integer("bufferView", 0, len(self.views) - 1)]
        view.integer("buffer", 0, 0)
        begin = view.integer("byteOffset", 0, len(self.binary)) if view.has("byteOffset") else 0
        data = self.binary[begin : begin + view.integer("byteLength", 0, len(self.binary) - begin)]
        return _strided(owner, name, accessor, view, data)


def _strided(
    owner: Fields, name: str, accessor: Fields, view: Fields, data: NDArray[np.uint8]
) -> NDArray[Any]:
    dtype = np.dtype(COMPONENTS[accessor.integer("componentType")])
    width = 3 if accessor.text("type") == "VEC3" else 1
    count = accessor.integer("count", 1)
    stride = view.integer("byteStride", 4, 252) if view.has("byteStride") else width * dtype.itemsize
    first = accessor.integer("byteOffset", 0, len(data)) if accessor.has("byteOffset") else 0
    end = first + stride * (count - 1) + width * dtype.itemsize
    if end > len(data):
        raise owner.error(name, f"{end} bytes", f"{len(data)}, the length of the buffer view")
    return np.ndarray((count, width), dtype, data[first:end].tobytes(), 0, (stride, dtype.itemsize))


def open_glb(path: Path) -> Glb:
    """Map a binary glTF into memory and parse its JSON chunk.

    Raises
    ------
    TilesetError
        When header or chunks do not fit the file.
    """
    source = str(path)
    try:
        size = path.stat().st_size
        if size < HEADER.size:
            raise TilesetError(source, "header", f"{size} bytes", f"at least {HEADER.size}")
        data = np.asarray(np.memmap(path, dtype=np.uint8, mode="r"))
    except OSError as error:
        raise TilesetError(source, "file", error.strerror or "an error", "a readable file") from error
    magic, version, length, json_length, json_type = HEADER.unpack(data[: HEADER.size].tobytes())
    if (magic, version, length, json_type) != (b"glTF", 2, len(data), b"JSON"):
        raise TilesetError(
            source, "header", f"{magic!r}, version {version}, {length} bytes", f"b'glTF', 2, {len(data)}"
        )
    end = HEADER.size + json_length
    if json_length > JSON_LIMIT or end > len(data):
        raise TilesetError(
            source, "JSON chunk", f"{json_length} bytes", f"at most {min(JSON_LIMIT, len(data))}"
        )
    document = parse_object(data[HEADER.size : end].tobytes(), source)
    return Glb(source, document, _binary_chunk(data[end:], source))


def _binary_chunk(rest: NDArray[np.uint8], source: str) -> NDArray[np.uint8]:
    if len(rest) == 0:
        return rest
    length, kind = CHUNK.unpack(rest[: CHUNK.size].tobytes()) if len(rest) >= CHUNK.size else (0, b"")
    if kind != b"BIN\0" or CHUNK.size + length > len(rest):
        raise TilesetError(
            source, "binary chunk", f"{kind!r} of {length} bytes", f"at most {len(rest)} bytes"
        )
    return rest[CHUNK.size : CHUNK.size + length]
