"""The tile formats of 3D Tiles 1.0 that hold glTF: b3dm, and cmpt with others in it."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.gltf.values import Value, parse

B3DM_HEADER = struct.Struct("<4s6I")
CMPT_HEADER = struct.Struct("<4s3I")
COMPOSITE_DEPTH = 8
"""Composites within composites."""
BATCHES_LIMIT = 1 << 24
"""Rows of a batch table."""


@dataclass(frozen=True)
class Batched:
    """What a b3dm tile holds."""

    glb: memoryview
    """Binary glTF."""
    center: NDArray[np.float64]
    """(3,) RTC_CENTER, metres, axes of the tile (z up)."""
    texts: tuple[tuple[str, ...], ...]
    """Texts that the batch table says of each batch id; empty when it says none."""


def open_b3dm(source: str, place: str, data: memoryview) -> Batched:
    """Open a batched 3D model (3D Tiles 1.0, section 9.1).

    Parameters
    ----------
    source, place : str
        File, and place in it, named in errors.
    data : memoryview
        From the magic on; bytes behind the stated length are not looked at.

    Raises
    ------
    SceneError
        When header, lengths or tables are wrong.
    """
    if len(data) < B3DM_HEADER.size:
        raise SceneError(source, f"{place} header", f"{len(data)} bytes", f"{B3DM_HEADER.size} or more")
    magic, version, length, *tables = B3DM_HEADER.unpack_from(data)
    ends = np.cumsum([B3DM_HEADER.size, *tables]).tolist()
    if magic != b"b3dm" or version != 1:
        raise SceneError(source, f"{place} header", f"{magic!r}, version {version}", "b3dm, version 1")
    if length > len(data) or ends[-1] > length:
        found = f"length {length}, tables to byte {ends[-1]}, in {len(data)} bytes"
        raise SceneError(source, f"{place} header", found, "lengths within the file")
    feature = _table(source, f"{place} feature table", data[ends[0] : ends[1]])
    batch = _table(source, f"{place} batch table", data[ends[2] : ends[3]])
    center = _center(feature, data[ends[1] : ends[2]])
    return Batched(data[ends[4] : length], center, _texts(batch))


def _table(source: str, place: str, text: memoryview) -> Value:
    stripped = bytes(text).rstrip(b" \0")
    return parse(source, place, stripped) if stripped else Value(source, place, {})


def _center(feature: Value, binary: memoryview) -> NDArray[np.float64]:
    value = feature.member("RTC_CENTER")
    if value is None:
        return np.zeros(3)
    if not isinstance(value.raw, dict):
        return value.numbers(3)
    if len(binary) < 12:
        raise value.error(f"{len(binary)} bytes of binary table", "three float32 within it")
    offset = value.need("byteOffset").integer(0, len(binary) - 12)
    center = np.frombuffer(binary, "<f4", 3, offset).astype(np.float64)
    if not np.isfinite(center).all():
        raise value.error(str(center.tolist()), "finite coordinates")
    return center


def _texts(batch: Value) -> tuple[tuple[str, ...], ...]:
    """Texts of every row; numbers, and properties in the binary table, name nothing."""
    columns = [value for value in batch.raw.values() if isinstance(value, list)]
    rows = max((len(column) for column in columns), default=0)
    if rows > BATCHES_LIMIT:
        raise batch.error(f"{rows} rows", f"at most {BATCHES_LIMIT}")
    found = []
    for k in range(rows):
        values = [column[k] for column in columns if k < len(column)]
        found.append(tuple(value for value in values if isinstance(value, str) and value))
    return tuple(found)


def open_cmpt(source: str, place: str, data: memoryview, depth: int = 0) -> Iterator[tuple[str, memoryview]]:
    """Give place and bytes of every tile in a composite (3D Tiles 1.0, section 9.4), those within others too.

    Raises
    ------
    SceneError
        When header or lengths are wrong, or composites are nested too deep.
    """
    if len(data) < CMPT_HEADER.size:
        raise SceneError(source, f"{place} header", f"{len(data)} bytes", f"{CMPT_HEADER.size} or more")
    _, version, length, count = CMPT_HEADER.unpack_from(data)
    if version != 1 or length > len(data) or depth > COMPOSITE_DEPTH:
        found = f"version {version}, length {length} in {len(data)} bytes, depth {depth}"
        raise SceneError(source, f"{place} header", found, f"1, within the file, at most {COMPOSITE_DEPTH}")
    start = CMPT_HEADER.size
    for k in range(count):
        inner = f"{place} tile {k}"
        if start + 12 > length:
            raise SceneError(source, inner, f"byte {start} of {length}", f"{count} tiles within it")
        size = struct.unpack_from("<I", data, start + 8)[0]
        if size < 12 or start + size > length:
            raise SceneError(source, inner, f"length {size} at byte {start} of {length}", "one that fits")
        tile = data[start : start + size]
        if bytes(tile[:4]) == b"cmpt":
            yield from open_cmpt(source, inner, tile, depth + 1)
        else:
            yield inner, tile
        start += size
