"""What a file claims about itself, checked against its size before any parser allocates for it."""

from __future__ import annotations

import re
import struct
from pathlib import Path

from tilesnav_ref.scene.errors import SceneError

PLY_HEADER_LIMIT = 1 << 20
"""Bytes; real headers have a few hundred."""

NUMBER = re.compile(rb"-?[0-9]{1,18}")
"""A vertex number of an OBJ file."""

PLY_BYTES = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16"), 2),
    **dict.fromkeys(("int", "uint", "float", "int32", "uint32", "float32"), 4),
    **dict.fromkeys(("double", "float64", "int64", "uint64"), 8),
}


def check_claims(path: Path, data: bytes, max_faces: int) -> int | None:
    """Check signature and claimed counts of a file that trimesh reads.

    Parameters
    ----------
    path : Path
        Named in errors; its suffix is the format.
    data : bytes
        The whole file.
    max_faces : int
        Greatest count of vertices or faces.

    Returns
    -------
    int or None
        Number of faces that the file claims, where its format has such a number.

    Raises
    ------
    SceneError
        When the signature is wrong or a count cannot be true for a file of this size.
    """
    source, suffix = str(path), path.suffix.lower()
    if not data:
        raise SceneError(source, "file", "0 bytes", "a mesh")
    if suffix == ".ply":
        return _check_ply(source, data, max_faces)
    if suffix == ".stl":
        _check_stl(source, data, max_faces)
    if suffix == ".obj":
        _check_obj(source, data)
    if suffix == ".off" and b"OFF" not in data[:4096]:
        raise SceneError(source, "header", repr(data[:16]), "OFF or COFF, as the file is named .off")
    return None


def _check_ply(source: str, data: bytes, max_faces: int) -> int:
    """Sum the least size of every element and compare it with the body."""
    if data[:4] not in (b"ply\n", b"ply\r"):
        raise SceneError(source, "header", repr(data[:16]), "'ply' and a line end, as the file is named .ply")
    end = data.find(b"end_header", 0, PLY_HEADER_LIMIT)
    if end < 0:
        raise SceneError(source, "header", "no end_header", f"end_header within {PLY_HEADER_LIMIT} bytes")
    ascii_body = b"ascii" in data[:end]
    need, counts, count, element = 0, {"vertex": 0, "face": 0}, 0, ""
    for number, line in enumerate(data[:end].decode("latin-1").splitlines(), 1):
        words = line.split()
        if words[:1] == ["element"]:
            element, count = _ply_element(source, number, words, max_faces)
            counts[element] = count
        elif words[:1] == ["property"]:
            need += count * _ply_row_bytes(source, number, words, element, ascii_body)
    body = len(data) - end - len("end_header")
    if need > body + 1:  # the last line of a text need not end
        claim = ", ".join(f"{n} {name}" for name, n in counts.items())
        raise SceneError(
            source,
            "header",
            f"{claim} in a body of {body} bytes",
            f"no more than fits; these take {need} or more",
        )
    return counts["face"]


def _ply_element(source: str, number: int, words: list[str], max_faces: int) -> tuple[str, int]:
    place = f"header line {number}"
    if len(words) != 3 or not words[2].isdecimal():
        raise SceneError(source, place, repr(" ".join(words)[:80]), "element NAME COUNT")
    count = int(words[2][:20])
    if count > max_faces:
        raise SceneError(source, place, f"{count} elements", f"at most {max_faces} (max_faces)")
    return words[1], count


def _ply_row_bytes(source: str, number: int, words: list[str], element: str, ascii_body: bool) -> int:
    """Least bytes that one row of a property takes; a number in a text takes two with its space."""
    types = words[2:4] if words[1:2] == ["list"] else words[1:2]
    if (
        not types
        or any(t not in PLY_BYTES for t in types)
        or len(words) != len(types) + 2 + (len(types) == 2)
    ):
        place = f"header line {number}"
        raise SceneError(
            source, place, repr(" ".join(words)[:80]), "property TYPE NAME or property list TYPE TYPE NAME"
        )
    sizes = [2] * len(types) if ascii_body else [PLY_BYTES[t] for t in types]
    if len(types) == 1:
        return sizes[0]
    corners = 3 if element == "face" and words[4] in ("vertex_indices", "vertex_index") else 0
    return sizes[0] + corners * sizes[1]


def is_binary_stl(data: bytes) -> bool:
    """Whether the count in the header fits the size; a binary file may begin with the word of texts too."""
    return len(data) >= 84 and len(data) == 84 + 50 * int(struct.unpack_from("<I", data, 80)[0])


def _check_stl(source: str, data: bytes, max_faces: int) -> None:
    if is_binary_stl(data):
        count = (len(data) - 84) // 50
        if count > max_faces:
            raise SceneError(source, "header", f"{count} faces", f"at most {max_faces} (max_faces)")
    elif data.lstrip()[:5].lower() != b"solid":
        found = f"{len(data)} bytes that begin with {data[:16]!r}"
        allowed = (
            "84 + 50 bytes a face with the number of faces at byte 80, or a text that begins with 'solid'"
        )
        raise SceneError(source, "header", found, allowed)


def _check_obj(source: str, data: bytes) -> None:
    """Check the vertex numbers of every face, which the parser would wrap, or misplace in its message."""
    vertices = 0
    faces: list[tuple[int, int, bytes]] = []
    for number, line in enumerate(data.splitlines(), 1):
        if line.startswith((b"v ", b"v\t")):
            vertices += 1
        elif line.startswith((b"f ", b"f\t")):
            faces.append((number, vertices, line))
    for number, before, line in faces:
        for word in line.split(b"#")[0].split()[1:]:
            text = word.split(b"/")[0]
            if text == b"\\":  # the line goes on
                continue
            value = int(text) if NUMBER.fullmatch(text) else 0
            if value == 0 or value > vertices or value < -before:
                found = "vertex number " + repr(text[:20].decode("latin-1"))
                raise SceneError(source, f"line {number}", found, f"1 to {vertices}, or -{before} to -1")
