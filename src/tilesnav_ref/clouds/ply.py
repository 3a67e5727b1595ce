"""PLY files: the vertices of any layout without lists before or in them.

References
----------
G. Turk, "The PLY polygon file format", 1994.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tilesnav_ref.clouds.model import CloudFile
from tilesnav_ref.clouds.records import binary_chunks, header_lines, text_chunks
from tilesnav_ref.scene.errors import SceneError

TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}

Element = tuple[str, int, list[tuple[str, str]]]
"""Name, count, and names and types of the properties."""


def open_ply(path: Path, size: int) -> CloudFile:
    """Read the header of a PLY file.

    Raises
    ------
    SceneError
        When the header is broken, or there is no vertex with x, y and z.
    """
    with path.open("rb") as file:
        if file.readline(8).strip() != b"ply":
            raise SceneError(str(path), "header", "no line 'ply' at the start", "a PLY file")
        lines = header_lines(path, file, "end_header")
        start = file.tell()
    order, elements = _parsed(path, lines)
    skipped = 0
    for name, count, properties in elements:
        if name == "vertex":
            return _opened(path, (order, start, skipped), (count, properties), size)
        if any(kind not in TYPES.values() for _, kind in properties):
            raise SceneError(str(path), "header", f"a list in {name!r} before the vertices", "vertices first")
        skipped += count if not order else count * _record(properties, order).itemsize
    raise SceneError(str(path), "header", "no element 'vertex'", "a PLY file with vertices")


def _opened(
    path: Path, place: tuple[str, int, int], vertex: tuple[int, list[tuple[str, str]]], size: int
) -> CloudFile:
    order, start, skipped = place
    count, properties = vertex
    names = [name for name, _ in properties]
    lists = [name for name, kind in properties if kind not in TYPES.values()]
    if lists:
        raise SceneError(str(path), "header", f"a list {lists[0]!r} in the vertices", "numbers only")
    if not {"x", "y", "z"} <= {name.lower() for name in names} or len(set(names)) < len(names):
        raise SceneError(str(path), "header", f"the properties {', '.join(names)}", "x, y, z, each name once")
    if not order:
        if skipped:
            raise SceneError(str(path), "header", "rows before the vertices", "vertices first")
        return CloudFile(str(path), count, text_chunks(path, (start, count), names, size))
    record = _record(properties, order)
    held = path.stat().st_size - start - skipped
    if held < count * record.itemsize:
        found = f"{held} bytes where {count} points need {count * record.itemsize}"
        raise SceneError(str(path), "length", found, "a whole file")
    return CloudFile(str(path), count, binary_chunks(path, start + skipped, record, count, size))


def _record(properties: list[tuple[str, str]], order: str) -> np.dtype[Any]:
    return np.dtype([(name, order + kind) for name, kind in properties])


def _parsed(path: Path, lines: list[str]) -> tuple[str, list[Element]]:
    """Byte order and elements."""
    order = None
    elements: list[Element] = []
    for line in lines:
        words = line.split()
        try:
            if words[:1] == ["format"]:
                order = FORMATS[words[1]]
            elif words[:1] == ["element"]:
                elements.append((words[1], _count(words[2]), []))
            elif words[:1] == ["property"]:
                kind = "list" if words[1] == "list" else TYPES[words[1]]
                elements[-1][2].append((words[-1], kind))
        except (LookupError, ValueError):
            raise SceneError(str(path), "header", repr(line[:60]), "a line of a PLY header") from None
    if order is None:
        raise SceneError(str(path), "header", "no line 'format'", ", ".join(FORMATS))
    return order, elements


def _count(word: str) -> int:
    count = int(word)
    if not 0 <= count < 1 << 40:
        raise ValueError(word)
    return count
