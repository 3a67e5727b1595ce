"""What a glTF file claims about its buffers and accessors."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from tilesnav_ref.scene.errors import SceneError

JSON_LIMIT = 256 << 20
"""Bytes of JSON; a scene of a million nodes has less."""

UNREAD_EXTENSIONS = frozenset(
    {
        "KHR_draco_mesh_compression",
        "EXT_meshopt_compression",
        "KHR_meshopt_compression",
        "EXT_mesh_gpu_instancing",
    }
)
"""Extensions that hold geometry which would be missed."""

COMPONENT_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


def check_glb(path: Path, data: bytes, max_faces: int) -> None:
    """Check the header, the chunk lengths and the JSON chunk of a binary glTF file.

    Raises
    ------
    SceneError
        Naming what does not fit.
    """
    source = str(path)
    if len(data) < 20 or data[:4] != b"glTF":
        raise SceneError(source, "header", repr(data[:12]), "that of binary glTF, as the file is named .glb")
    version, length, chunk, kind = struct.unpack_from("<IIII", data, 4)
    if version != 2 or length > len(data):
        found = f"version {version}, length {length} in {len(data)} bytes"
        raise SceneError(source, "header", found, "version 2, length of the file")
    if kind != 0x4E4F534A or chunk > min(length - 20, JSON_LIMIT):
        found = f"type {kind:#x} of {chunk} bytes"
        raise SceneError(source, "first chunk", found, "a JSON chunk within the file")
    _check_document(path, data[20 : 20 + chunk], len(data), max_faces)


def check_gltf(path: Path, data: bytes, max_faces: int) -> None:
    """Check the JSON of a glTF file.

    Raises
    ------
    SceneError
        Naming what does not fit.
    """
    if len(data) > JSON_LIMIT:
        raise SceneError(str(path), "file", f"{len(data)} bytes of JSON", f"at most {JSON_LIMIT}")
    _check_document(path, data, len(data), max_faces)


def _check_document(path: Path, text: bytes, size: int, max_faces: int) -> None:
    """Check extensions, buffers and accessors of a document in a file of a size."""
    source = str(path)
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise SceneError(source, "JSON", str(error)[:120], "a glTF document") from error
    if not isinstance(document, dict):
        raise SceneError(source, "JSON", type(document).__name__, "an object")
    used = [*_members(source, document, "extensionsUsed"), *_members(source, document, "extensionsRequired")]
    unread = sorted(UNREAD_EXTENSIONS.intersection(x for x in used if isinstance(x, str)))
    if unread:
        found = ", ".join(unread)
        raise SceneError(source, "extensionsUsed", found, "plain geometry; convert the file first")
    total, available = 0, size
    for i, buffer in enumerate(_members(source, document, "buffers")):
        total += _integer(source, f"buffers[{i}].byteLength", _get(buffer, "byteLength"))
        available += _external_bytes(path, f"buffers[{i}].uri", _get(buffer, "uri"))
    if total > available:
        raise SceneError(
            source, "buffers", f"{total} bytes claimed", f"at most the {available} that are there"
        )
    for i, accessor in enumerate(_members(source, document, "accessors")):
        _check_accessor(source, f"accessors[{i}]", accessor, (total, 3 * max_faces))


def _external_bytes(path: Path, place: str, uri: Any) -> int:
    """Size of the file that a buffer names; it has to be in the folder of the document, or below."""
    if uri is None or (isinstance(uri, str) and uri.startswith("data:")):
        return 0
    allowed = "a file in the folder of the document, or below"
    if not isinstance(uri, str):
        raise SceneError(str(path), place, type(uri).__name__, allowed)
    folder = path.resolve().parent
    try:
        target = (folder / unquote(uri)).resolve()
        if not target.is_relative_to(folder) or not target.is_file():
            raise SceneError(str(path), place, repr(uri)[:80], allowed)
        return target.stat().st_size
    except (OSError, ValueError) as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(str(path), place, repr(uri)[:80], allowed) from error


def _check_accessor(source: str, place: str, accessor: Any, limits: tuple[int, int]) -> None:
    """Refuse accessors that are larger than all buffers; those without a buffer view are all zero."""
    total, most = limits
    count = _integer(source, f"{place}.count", _get(accessor, "count"))
    kind, component = _get(accessor, "type"), _get(accessor, "componentType")
    if not isinstance(kind, str) or not isinstance(component, int):
        raise SceneError(source, place, f"type {kind!r}, componentType {component!r}", "those of glTF 2.0")
    size = count * COMPONENTS.get(kind, 16) * COMPONENT_BYTES.get(component, 4)
    if count > most or size > total:
        limit = f"at most the {total} bytes of all buffers"
        raise SceneError(source, f"{place}.count", f"{count}, {size} bytes", limit)
    if _get(accessor, "normalized") and kind == "VEC3" and component != 5126:
        # the parser ignores their scale; harmless uses such as normals are not told apart here
        raise SceneError(source, place, "normalized integers", "float32; convert the file first")


def _members(source: str, document: dict[str, Any], name: str) -> list[Any]:
    value = document.get(name, [])
    if not isinstance(value, list):
        raise SceneError(source, name, type(value).__name__, "an array")
    return value


def _get(value: Any, name: str) -> Any:
    return value.get(name) if isinstance(value, dict) else None


def _integer(source: str, place: str, value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise SceneError(source, place, repr(value)[:40], "an integer of 0 or more")
    return value
