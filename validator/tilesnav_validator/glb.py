"""Reading triangles out of a binary glTF, by hand, with every bound checked before use."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator import strictjson

_INDEX_TYPES = {5121: "<u1", 5123: "<u2", 5125: "<u4"}
_FLOAT = 5126
_TRIANGLES = 4
_TRANSFORMS = ("matrix", "translation", "rotation", "scale")


class GlbError(ValueError):
    """The file is not such a glTF as the specification asks for; ``where`` is a JSON pointer or a byte."""

    def __init__(self, where: str, measured: str, allowed: str) -> None:
        super().__init__(f"{where}: {measured}, allowed is {allowed}")
        self.where, self.measured, self.allowed = where, measured, allowed


@dataclass(frozen=True)
class Primitive:
    """Triangles of one primitive.

    Attributes
    ----------
    positions : ndarray of float64, shape (v, 3)
        Every vertex of the accessor, nav frame (z up), metres; float32 values exactly.
    triangles : ndarray of int64, shape (t, 3)
    """

    positions: NDArray[np.float64]
    triangles: NDArray[np.int64]


def _need(condition: bool, where: str, measured: object, allowed: str) -> None:
    if not condition:
        raise GlbError(where, str(measured)[:200], allowed)


def _integer(value: Any, where: str, below: int) -> int:
    """A JSON integer from 0 to ``below`` - 1."""
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    is_count = isinstance(value, int) and not isinstance(value, bool) and 0 <= value < below
    _need(is_count, where, value, f"an integer from 0 to {below - 1}")
    return int(value)


def _items(parent: dict[str, Any], name: str, where: str = "") -> list[dict[str, Any]]:
    """A list of objects, empty when missing."""
    value = parent.get(name, [])
    good = isinstance(value, list) and all(isinstance(item, dict) for item in value)
    _need(good, f"{where}/{name}", type(value).__name__, "an array of objects")
    return list(value)


def _object(parent: dict[str, Any], name: str, where: str) -> dict[str, Any]:
    value = parent.get(name, {})
    _need(isinstance(value, dict), f"{where}/{name}", type(value).__name__, "an object")
    return dict(value)


def _chunks(data: memoryview) -> tuple[dict[str, Any], memoryview]:
    """The JSON part and the binary part."""
    _need(len(data) >= 20, "byte 0", f"{len(data)} bytes", "a header and a chunk, 20 bytes")
    magic, version, length = struct.unpack_from("<4sII", data)
    _need(magic == b"glTF", "byte 0", f"magic {magic!r}", "b'glTF'")
    _need(version == 2, "byte 4", f"version {version}", "2")
    _need(length == len(data), "byte 8", f"length {length}", f"{len(data)}, the length of the file")
    size, kind = struct.unpack_from("<I4s", data, 12)
    _need(kind == b"JSON", "byte 16", f"chunk {kind!r}", "b'JSON'")
    _need(20 + size <= len(data), "byte 12", f"chunk of {size} bytes", f"at most {len(data) - 20}")
    try:
        root = strictjson.parse_view(data, 20, 20 + size)
    except strictjson.JsonError as error:
        raise GlbError("byte 20", str(error), "JSON") from None
    _need(isinstance(root, dict), "byte 20", type(root).__name__, "a JSON object")
    start = 20 + size
    if start == len(data):
        return root, memoryview(b"")
    _need(start + 8 <= len(data), f"byte {start}", f"{len(data) - start} bytes", "a chunk header, 8 bytes")
    size, kind = struct.unpack_from("<I4s", data, start)
    _need(kind == b"BIN\0", f"byte {start + 4}", f"chunk {kind!r}", "b'BIN\\x00'")
    rest = len(data) - start - 8
    _need(size <= rest, f"byte {start}", f"chunk of {size} bytes", f"at most {rest}")
    return root, data[start + 8 : start + 8 + size]


class _Document:
    """The arrays of a glTF and its binary part."""

    def __init__(self, root: dict[str, Any], binary: memoryview) -> None:
        self.views, self.accessors = _items(root, "bufferViews"), _items(root, "accessors")
        buffers = _items(root, "buffers")
        self.binary = memoryview(b"")
        for index, view in enumerate(self.views):
            _integer(view.get("buffer"), f"/bufferViews/{index}/buffer", min(len(buffers), 1))
        if self.views:  # else no buffer is in use
            _need("uri" not in buffers[0], "/buffers/0/uri", "a uri", "none: the binary part of the file")
            size = _integer(buffers[0].get("byteLength"), "/buffers/0/byteLength", len(binary) + 1)
            self.binary = binary[:size]

    def _view(self, index: int) -> tuple[memoryview, int | None]:
        """Bytes and stride of a buffer view."""
        where, view = f"/bufferViews/{index}", self.views[index]
        _need(
            "EXT_meshopt_compression" not in _object(view, "extensions", where),
            where,
            "compressed",
            "uncompressed",
        )
        start = _integer(view.get("byteOffset", 0), f"{where}/byteOffset", len(self.binary) + 1)
        size = _integer(view.get("byteLength"), f"{where}/byteLength", len(self.binary) - start + 1)
        stride = view.get("byteStride")
        if stride is not None:
            stride = _integer(stride, f"{where}/byteStride", 253)
        return self.binary[start : start + size], stride

    def read(self, value: Any, where: str, types: dict[int, str], kind: str) -> NDArray[Any]:
        """Elements of an accessor, shape (count, 1 or 3)."""
        index = _integer(value, where, len(self.accessors))
        where, accessor = f"/accessors/{index}", self.accessors[index]
        code = accessor.get("componentType")
        _need(
            isinstance(code, int) and code in types, f"{where}/componentType", code, f"one of {list(types)}"
        )
        _need(accessor.get("type") == kind, f"{where}/type", accessor.get("type"), kind)
        _need("sparse" not in accessor, f"{where}/sparse", "a sparse accessor", "none")
        _need(not accessor.get("normalized"), f"{where}/normalized", "true", "false")
        dtype, width = np.dtype(types[int(code or 0)]), 3 if kind == "VEC3" else 1
        view = _integer(accessor.get("bufferView"), f"{where}/bufferView", len(self.views))
        data, stride = self._view(view)
        step = stride or dtype.itemsize * width
        _need(step >= dtype.itemsize * width, f"/bufferViews/{view}/byteStride", step, "at least an element")
        start = _integer(accessor.get("byteOffset", 0), f"{where}/byteOffset", len(data) + 1)
        room = (len(data) - start - dtype.itemsize * width) // step + 1 if len(data) > start else 0
        count = _integer(accessor.get("count"), f"{where}/count", max(room, 0) + 1)
        if not count:
            return np.zeros((0, width), dtype)
        return np.ndarray((count, width), dtype, data, start, (step, dtype.itemsize)).copy()


def _links(parent: dict[str, Any], name: str, where: str, below: int) -> list[int]:
    """A list of indices, empty when missing."""
    value = parent.get(name, [])
    _need(isinstance(value, list), f"{where}/{name}", type(value).__name__, "an array of integers")
    return [_integer(item, f"{where}/{name}/{place}", below) for place, item in enumerate(value)]


def _shown_nodes(root: dict[str, Any], nodes: list[dict[str, Any]]) -> list[int]:
    """Nodes of the scene of the file, each once: ``scene``, or the first where that is left out."""
    scenes = _items(root, "scenes")
    if not scenes:
        return []
    scene = _integer(root.get("scene", 0), "/scene", len(scenes))
    pending = _links(scenes[scene], "nodes", f"/scenes/{scene}", len(nodes))
    shown: dict[int, None] = {}
    while pending:
        index = pending.pop()
        _need(index not in shown, f"/nodes/{index}", "reached twice from the scene", "once: a strict tree")
        shown[index] = None
        pending += _links(nodes[index], "children", f"/nodes/{index}", len(nodes))
    return list(shown)


def _check_nodes(root: dict[str, Any], mesh_count: int) -> None:
    """Every mesh is shown by exactly one node of the scene, and no node moves anything."""
    used = [0] * mesh_count
    nodes = _items(root, "nodes")
    shown = set(_shown_nodes(root, nodes))
    for index, node in enumerate(nodes):
        where = f"/nodes/{index}"
        for name in (*_TRANSFORMS, "skin"):
            _need(name not in node, f"{where}/{name}", "present", "no transform")
        extensions = _object(node, "extensions", where)
        _need("EXT_mesh_gpu_instancing" not in extensions, f"{where}/extensions", "instancing", "none")
        if "mesh" in node:
            used[_integer(node["mesh"], f"{where}/mesh", mesh_count)] += index in shown
    for index, count in enumerate(used):
        _need(count == 1, f"/meshes/{index}", f"shown by {count} nodes of the scene", "exactly one")


def _read_primitive(document: _Document, primitive: dict[str, Any], where: str) -> Primitive:
    mode = primitive.get("mode", _TRIANGLES)
    _need(mode == _TRIANGLES, f"{where}/mode", mode, "4 (TRIANGLES)")
    compressed = "KHR_draco_mesh_compression" in _object(primitive, "extensions", where)
    _need(not compressed, f"{where}/extensions", "compressed", "uncompressed")
    _need(not primitive.get("targets"), f"{where}/targets", "morph targets", "none")
    attribute = _object(primitive, "attributes", where).get("POSITION")
    raw = document.read(attribute, f"{where}/attributes/POSITION", {_FLOAT: "<f4"}, "VEC3")
    _need(bool(np.isfinite(raw).all()), f"{where}/attributes/POSITION", "NaN or infinity", "finite numbers")
    positions = np.stack([raw[:, 0], -raw[:, 2], raw[:, 1]], axis=1).astype(np.float64)  # y up -> z up
    if "indices" in primitive:
        indices = document.read(primitive["indices"], f"{where}/indices", _INDEX_TYPES, "SCALAR")[
            :, 0
        ].astype(np.int64)
    else:
        indices = np.arange(len(positions), dtype=np.int64)
    whole = len(indices) > 0 and len(indices) % 3 == 0
    _need(whole, f"{where}/indices", f"{len(indices)} indices", "a multiple of 3 above 0")
    top = int(indices.max(initial=-1))
    _need(top < len(positions), f"{where}/indices", f"index {top}", f"less than {len(positions)}")
    return Primitive(positions, indices.reshape(-1, 3))


def read(data: memoryview) -> list[Primitive]:
    """Return the primitives of a file in document order.

    Parameters
    ----------
    data : memoryview
        The whole file.

    Raises
    ------
    GlbError
        If the file is not a binary glTF 2.0 of plain triangles as core/content-gltf asks.
    """
    root, binary = _chunks(data)
    version = _object(root, "asset", "").get("version")
    _need(version == "2.0", "/asset/version", version, "2.0")
    meshes = _items(root, "meshes")
    _check_nodes(root, len(meshes))
    document = _Document(root, binary)
    primitives: list[Primitive] = []
    elements = 0
    for index, mesh in enumerate(meshes):
        for number, primitive in enumerate(_items(mesh, "primitives", f"/meshes/{index}")):
            where = f"/meshes/{index}/primitives/{number}"
            primitives.append(_read_primitive(document, primitive, where))
            elements += primitives[-1].triangles.size + len(primitives[-1].positions)
            _need(
                elements <= len(data),
                where,
                f"{elements} elements from a file of {len(data)} bytes",
                "no such reuse",
            )
    return primitives
