"""Reading the container of nav files and face maps: every bound is checked before it is used as one."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.fields import JSON_LIMIT, Fields, parse_object

HEADER = struct.Struct("<4sIQQ")
NAV_MAGIC = b"nav1"
FACE_MAP_MAGIC = b"fmap"

Bytes = NDArray[np.uint8]


@dataclass(frozen=True)
class Container:
    """A nav file or a face map in memory, or mapped into it."""

    source: str
    members: Fields
    """The JSON part."""
    binary: Bytes
    """The buffer, without padding."""
    views: tuple[tuple[int, int], ...]
    """First byte of each buffer view in the buffer, and the byte behind its last."""

    def table(self, owner: Fields, name: str, dtype: str, shape: tuple[int, ...]) -> NDArray[Any]:
        """Return the table that a member refers to; no byte is copied.

        Parameters
        ----------
        owner : Fields
            Object with the member.
        name : str
            The member.
        dtype : str
            Little-endian element type such as ``"<u4"``.
        shape : tuple of int
            Of the table; its byte length must be that of the buffer view.

        Raises
        ------
        TilesetError
            When there is no such buffer view or its length is another.
        """
        view = owner.integer(name, 0, len(self.views) - 1)
        first, last = self.views[view]
        length = int(np.dtype(dtype).itemsize)
        for extent in shape:
            length *= extent
        if last - first != length:
            raise owner.error(
                name, f"buffer view {view} of {last - first} bytes", f"{length} bytes, for {shape}"
            )
        return self.binary[first:last].view(dtype).reshape(shape)


def map_container(path: Path, magic: bytes = NAV_MAGIC) -> Container:
    """Map a nav file, or a file with another magic, into memory, read-only.

    Raises
    ------
    TilesetError
        When the file is not a sound container.
    """
    try:
        if path.stat().st_size < HEADER.size:
            raise TilesetError(str(path), "header", f"{path.stat().st_size} bytes", f"at least {HEADER.size}")
        data = np.asarray(np.memmap(path, dtype=np.uint8, mode="r"))
    except OSError as error:
        raise TilesetError(str(path), "file", error.strerror or "an error", "a readable file") from error
    return parse_container(data, str(path), magic)


def parse_container(data: Bytes, source: str, magic: bytes = NAV_MAGIC) -> Container:
    """Check header, padding and buffer views of a nav file, or of a file with another magic.

    Parameters
    ----------
    data : (L,) uint8
        The whole file.
    source : str
        Its name, for errors.
    magic : bytes
        The four bytes that it has to begin with.

    Raises
    ------
    TilesetError
        Naming what is wrong.
    """
    json_length, binary_length = _header(data, source, magic)
    json_end = HEADER.size + json_length
    members = parse_object(data[HEADER.size : json_end].tobytes(), source)
    buffers = members.list_of_fields("buffers")
    if len(buffers) != 1 or buffers[0].has("uri"):
        raise members.error("buffers", f"{len(buffers)} buffers", "exactly one, without uri")
    used = buffers[0].integer("byteLength", 0, binary_length)
    if binary_length - used >= 8 or np.any(data[json_end + used :]):
        raise TilesetError(
            source, "binary part", f"{used} of {binary_length} bytes used", "less than 8 zero bytes behind"
        )
    return Container(source, members, data[json_end : json_end + used], _views(members, used))


def _header(data: Bytes, source: str, allowed: bytes) -> tuple[int, int]:
    if len(data) < HEADER.size:
        raise TilesetError(source, "header", f"{len(data)} bytes", f"at least {HEADER.size}")
    magic, version, json_length, binary_length = HEADER.unpack(data[: HEADER.size].tobytes())
    if magic != allowed:
        raise TilesetError(source, "magic", repr(magic), repr(allowed))
    if version != 1:
        raise TilesetError(source, "version", str(version), "1")
    if json_length % 8 or binary_length % 8:
        raise TilesetError(source, "header", f"lengths {json_length} and {binary_length}", "multiples of 8")
    if json_length > JSON_LIMIT:
        raise TilesetError(source, "header", f"a JSON part of {json_length} bytes", f"at most {JSON_LIMIT}")
    if HEADER.size + json_length + binary_length != len(data):
        claimed = HEADER.size + json_length + binary_length
        raise TilesetError(
            source, "header", f"a claim of {claimed} bytes", f"{len(data)}, the length of the file"
        )
    return json_length, binary_length


def _views(members: Fields, limit: int) -> tuple[tuple[int, int], ...]:
    views = []
    for view in members.list_of_fields("bufferViews"):
        view.integer("buffer", 0, 0)
        length = view.integer("byteLength", 0, limit)
        # An empty view may begin where the padding ends; it has no byte that could be read from there.
        first = view.integer("byteOffset", 0, limit - length if length else -(-limit // 8) * 8)
        if first % 8:
            raise view.error("byteOffset", first, "a multiple of 8")
        views.append((first, first + length))
    filled = sorted(view for view in views if view[0] < view[1])
    for before, after in pairwise(filled):
        if after[0] < before[1]:
            raise members.error(
                "bufferViews", f"bytes {after[0]} to {before[1] - 1} twice", "views that do not overlap"
            )
    return tuple(views)
