"""Availability in a subtree file of implicit tiling (3D Tiles 1.1, section 11)."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.gltf.files import Files
from tilesnav_ref.scene.gltf.values import Value, integer_or, parse

HEADER = struct.Struct("<4sIQQ")
NODES_LIMIT = 1 << 24
"""Tiles that a subtree has room for, available or not."""
BYTES_LIMIT = 2 << 30


@dataclass(frozen=True)
class Shape:
    """How a subtree is divided."""

    dimensions: int
    """2 for a quadtree, 3 for an octree."""
    levels: int
    """Levels of a subtree."""

    @property
    def nodes(self) -> int:
        """Tiles that a subtree has room for."""
        return ((1 << self.dimensions * self.levels) - 1) // ((1 << self.dimensions) - 1)

    @property
    def roots_below(self) -> int:
        """Subtrees that may follow."""
        return 1 << self.dimensions * self.levels

    def first(self, level: int) -> int:
        """Place of the first tile of a level."""
        return ((1 << self.dimensions * level) - 1) // ((1 << self.dimensions) - 1)


@dataclass(frozen=True)
class Subtree:
    """What is available in a subtree, in the order of its bitstreams: by level, then in Morton order."""

    content: NDArray[np.bool_]
    """(C, nodes) for each content of a tile; contents of tiles that are not available are not either."""
    below: NDArray[np.bool_]
    """(roots_below,) subtrees that follow."""


def read_subtree(files: Files, path: Path, shape: Shape, contents: int) -> Subtree:
    """Read a subtree, binary or JSON.

    Parameters
    ----------
    files : Files
    path : Path
        The file.
    shape : Shape
        With no more than NODES_LIMIT nodes.
    contents : int
        Contents that a tile may have.

    Raises
    ------
    SceneError
        When a length does not fit.
    """
    source, data = str(path), files.read(path)
    document, binary = _document(source, data)
    streams = _Streams(files, path, document, binary)
    tile = streams.bits(document.need("tileAvailability"), shape.nodes)
    given = document.member("contentAvailability")
    listed = [] if given is None else given.elements() if isinstance(given.raw, list) else [given]
    if len(listed) > contents:
        raise document.error(f"{len(listed)} of contentAvailability", f"at most {contents}, as the tile says")
    rows = [tile & streams.bits(value, shape.nodes) for value in listed]
    below = streams.bits(document.need("childSubtreeAvailability"), shape.roots_below)
    none = np.zeros((0, shape.nodes), np.bool_)
    return Subtree(np.stack(rows) if rows else none, below)


def _document(source: str, data: bytes) -> tuple[Value, memoryview]:
    if data[:4] != b"subt":
        return parse(source, "", data), memoryview(b"")
    if len(data) < HEADER.size:
        raise SceneError(source, "header", f"{len(data)} bytes", f"{HEADER.size} of a subtree or more")
    _, version, text, binary = HEADER.unpack_from(data)
    if version != 1 or HEADER.size + text + binary > len(data):
        found = f"version {version}, {text} + {binary} bytes in a file of {len(data)}"
        raise SceneError(source, "header", found, "version 1, lengths within the file")
    start = HEADER.size + text
    document = parse(source, "", data[HEADER.size : start].rstrip(b" \0"))
    return document, memoryview(data)[start : start + binary]


class _Streams:
    """Bitstreams of a subtree."""

    def __init__(self, files: Files, path: Path, document: Value, binary: memoryview) -> None:
        self._files, self._path, self._binary = files, path, binary
        self._views = document.items("bufferViews")
        self._buffers = document.items("buffers")
        self._read: dict[int, memoryview] = {}

    def bits(self, availability: Value, count: int) -> NDArray[np.bool_]:
        """Availability as a flag for each of `count` places."""
        constant = availability.member("constant")
        if constant is not None:
            return np.full(count, constant.integer(0, 1) == 1)
        # drafts of the format said bufferView
        stream = availability.member("bitstream") or availability.need("bufferView")
        if not self._views:
            raise stream.error("no bufferViews", "a bitstream in one of them")
        view = self._views[stream.integer(0, len(self._views) - 1)]
        data = self._bytes(view)
        if len(data) * 8 < count:
            raise view.error(f"{len(data)} bytes", f"{(count + 7) // 8} for {count} bits")
        packed = np.frombuffer(data, np.uint8, (count + 7) // 8)
        return np.unpackbits(packed, count=count, bitorder="little").astype(np.bool_)

    def _bytes(self, view: Value) -> memoryview:
        if not self._buffers:
            raise view.error("no buffers", "one that holds it")
        number = view.need("buffer").integer(0, len(self._buffers) - 1)
        start = integer_or(view.member("byteOffset"), 0, BYTES_LIMIT)
        length = view.need("byteLength").integer(0, BYTES_LIMIT)
        buffer = self._buffer(number)
        if start + length > len(buffer):
            raise view.error(f"bytes {start} to {start + length}", f"within the {len(buffer)} of the buffer")
        return buffer[start : start + length]

    def _buffer(self, number: int) -> memoryview:
        if number not in self._read:
            buffer = self._buffers[number]
            uri = buffer.member("uri")
            if uri is None:
                data = self._binary
            else:
                data = memoryview(self._files.read(self._files.named(uri, self._path)))
            length = buffer.need("byteLength").integer(0, BYTES_LIMIT)
            if length > len(data):
                raise buffer.error(f"byteLength {length}", f"at most the {len(data)} bytes that are there")
            self._read[number] = data[:length]
        return self._read[number]


def deinterleave(index: NDArray[np.int64], dimensions: int, level: int) -> NDArray[np.int64]:
    """Coordinates of Morton numbers; bit 0 is of x, bit 1 of y, bit 2 of z of an octree.

    Parameters
    ----------
    index : (N,) int64
        Numbers within a level.
    dimensions : int
    level : int
        Bits of each coordinate.

    Returns
    -------
    (N, dimensions) int64
    """
    found = np.zeros((len(index), dimensions), np.int64)
    for bit in range(level):
        for axis in range(dimensions):
            found[:, axis] |= ((index >> (dimensions * bit + axis)) & 1) << bit
    return found
