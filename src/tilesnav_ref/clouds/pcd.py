"""PCD files, version 0.7: ascii, binary and binary_compressed.

References
----------
"The PCD (Point Cloud Data) file format", documentation of the Point Cloud Library.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.clouds.lzf import expand
from tilesnav_ref.clouds.model import Chunk, CloudFile
from tilesnav_ref.clouds.records import binary_chunks, chunk_of, header_lines, text_chunks
from tilesnav_ref.scene.errors import SceneError

KINDS = ("I1", "I2", "I4", "I8", "U1", "U2", "U4", "U8", "F4", "F8")
COLUMNS_MAX = 1000
"""Most numbers of a point; descriptors of points may have hundreds."""
EXPANDED_MAX = 1 << 33
"""Most bytes that a compressed file may expand to: the format has one block, which must be in memory."""


def open_pcd(path: Path, size: int) -> CloudFile:
    """Read the header of a PCD file.

    Raises
    ------
    SceneError
        When the header is broken, or claims more than the file holds.
    """
    with path.open("rb") as file:
        lines = header_lines(path, file, "DATA")
        start = file.tell()
    words = {line.split()[0]: line.split()[1:] for line in lines if line and not line.startswith("#")}
    try:
        record, names = _record(words)
        count = int(words["WIDTH"][0]) * int(words["HEIGHT"][0])
        if int(words.get("POINTS", [f"{count}"])[0]) != count:
            raise ValueError(f"{words['POINTS'][0]} points where width times height is {count}")
        data = words["DATA"][0]
        origin = np.array([float(word) for word in words.get("VIEWPOINT", ["0", "0", "0"])[:3]])
    except (LookupError, ValueError, TypeError) as error:
        raise SceneError(str(path), "header", f"{error}"[:100], "the header of a PCD file") from error
    if not {"x", "y", "z"} <= set(names) or not 0 <= count < 1 << 40:
        found = f"{count} points of {', '.join(names)}"
        raise SceneError(str(path), "header", found, "points with x, y and z")
    chunks = _chunks(path, (data, start, count), (record, names), size)
    known = origin.shape == (3,) and np.isfinite(origin).all() and origin.any()
    return CloudFile(str(path), count, chunks, scan_origins=origin[None] if known else None)


def _record(words: dict[str, list[str]]) -> tuple[np.dtype[Any], list[str]]:
    """Layout of a point, and a name for each column."""
    names = []
    layout: list[Any] = []
    counts = words.get("COUNT", ["1"] * len(words["FIELDS"]))
    rows = zip(words["FIELDS"], words["SIZE"], words["TYPE"], counts, strict=True)
    for number, (name, size, kind, many) in enumerate(rows):
        if f"{kind}{size}" not in KINDS or not 0 < int(many) <= COLUMNS_MAX:
            raise ValueError(f"field {name!r} of type {kind}, size {size}, count {many}")
        own = f"{number}" if name == "_" else name  # padding
        for part in range(int(many)):
            names.append(own if int(many) == 1 else f"{own} {part}")
            layout.append((names[-1], f"<{kind.lower()}{size}"))
    if len(layout) > COLUMNS_MAX:
        raise ValueError(f"{len(layout)} numbers a point")
    return np.dtype(layout), names


def _chunks(
    path: Path, place: tuple[str, int, int], layout: tuple[np.dtype[Any], list[str]], size: int
) -> Iterator[Chunk]:
    """Points from a place in the file: the kind of data, the first byte, the count."""
    data, start, count = place
    record, names = layout
    held = path.stat().st_size - start
    if data == "ascii":
        return text_chunks(path, (start, count), names, size)
    if data == "binary":
        if held < count * record.itemsize:
            found = f"{held} bytes where {count} points need {count * record.itemsize}"
            raise SceneError(str(path), "length", found, "a whole file")
        return binary_chunks(path, start, record, count, size)
    if data == "binary_compressed":
        return _expanded(path, (start, held, count), record, size)
    raise SceneError(str(path), "header", f"DATA {data[:40]}", "ascii, binary or binary_compressed")


def _expanded(path: Path, place: tuple[int, int, int], record: np.dtype[Any], size: int) -> Iterator[Chunk]:
    """Points of one compressed block, which has the columns one after the other."""
    start, held, count = place
    columns = _block(path, start, (held, count * record.itemsize))
    tables = {}
    at = 0
    for name in record.names or ():
        kind = record[name]
        tables[name] = columns[at : at + count * kind.itemsize].view(kind)
        at += count * kind.itemsize
    for begin in range(0, count, size):
        yield chunk_of({name: column[begin : begin + size] for name, column in tables.items()})


def _block(path: Path, start: int, lengths: tuple[int, int]) -> NDArray[np.uint8]:
    """Bytes of the block; `lengths` are those that the file holds and that the points need."""
    held, needed = lengths
    with path.open("rb") as file:
        file.seek(start)
        head = file.read(8)
        packed, raw = struct.unpack("<II", head) if len(head) == 8 else (0, 0)
        if raw != needed or packed > held - 8 or raw > EXPANDED_MAX:
            found = f"{packed} bytes for {raw} (the file has {held}, the points need {needed})"
            raise SceneError(str(path), "compressed block", found, "lengths that fit the points and the file")
        block = np.frombuffer(file.read(packed), np.uint8)
    out = np.empty(raw, np.uint8)
    if expand(block, out) != raw:
        raise SceneError(str(path), "compressed block", "data that do not expand to the points", "LZF")
    return out
