"""Triangles of a glTF document, placed by its nodes, in float64."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.gltf.accessors import Arrays
from tilesnav_ref.scene.gltf.files import Files
from tilesnav_ref.scene.gltf.nodes import placed_meshes
from tilesnav_ref.scene.gltf.primitives import Primitive, read_mesh_primitives
from tilesnav_ref.scene.gltf.values import Value, parse

HEADER = struct.Struct("<4sIIII")
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
EXTENSIONS = frozenset(
    {
        "CESIUM_RTC",
        "CESIUM_primitive_outline",
        "EXT_mesh_features",
        "EXT_mesh_gpu_instancing",
        "EXT_instance_features",
        "EXT_meshopt_compression",
        "KHR_meshopt_compression",
        "EXT_feature_metadata",
        "EXT_structural_metadata",
        "EXT_texture_webp",
        "KHR_draco_mesh_compression",
        "KHR_mesh_quantization",
        "KHR_techniques_webgl",
        "KHR_texture_basisu",
        "KHR_texture_transform",
        "KHR_blend",
    }
)
"""Extensions of glTF that may be required, beside all materials: they are read, or say nothing about where
faces are."""


@dataclass(frozen=True)
class Budget:
    """What a document may hold."""

    faces: int
    """Faces left, instances counted."""
    elements: int
    """Elements that an accessor may have."""
    materials: bool
    """Whether the names of materials are wanted."""


@dataclass(frozen=True)
class Geometry:
    """A placed primitive."""

    primitive: Primitive
    matrix: NDArray[np.float64]
    """(4, 4) from the primitive to the axes of the result."""
    labels: tuple[str, ...]
    """Names of node, mesh and material, as far as they have some."""


@dataclass(frozen=True)
class Model:
    """Placed triangles of a document."""

    geometries: tuple[Geometry, ...]
    skipped: int
    """Primitives of points or lines."""


def split_glb(source: str, place: str, data: memoryview) -> tuple[Value, memoryview]:
    """Give document and binary chunk of a binary glTF (glTF 2.0, section 4.4).

    Raises
    ------
    SceneError
        When the header or a chunk does not fit.
    """
    if len(data) < HEADER.size:
        raise SceneError(source, f"{place} header", f"{len(data)} bytes", f"{HEADER.size} of glTF or more")
    magic, version, length, chunk, kind = HEADER.unpack_from(data)
    if magic != b"glTF":
        raise SceneError(source, f"{place} header", repr(bytes(data[:16])), "that of binary glTF")
    if version != 2 or length > len(data):
        found = f"version {version}, length {length} in {len(data)} bytes"
        raise SceneError(source, f"{place} header", found, "version 2, length within the file")
    if kind != JSON_CHUNK or HEADER.size + chunk > length:
        raise SceneError(source, f"{place} first chunk", f"type {kind:#x} of {chunk} bytes", "JSON that fits")
    start = HEADER.size + chunk
    document = parse(source, place, bytes(data[HEADER.size : start]).rstrip(b" \0"))
    while start + 8 <= length:
        size, kind = struct.unpack_from("<II", data, start)
        if start + 8 + size > length:
            raise SceneError(source, f"{place} chunk at byte {start}", f"{size} bytes", "a chunk that fits")
        if kind == BINARY_CHUNK:
            return document, data[start + 8 : start + 8 + size]
        start += 8 + size
    return document, memoryview(b"")


def read_model(
    files: Files, path: Path, content: tuple[Value, memoryview], up: str | None, budget: Budget
) -> Model:
    """Read the scene of a document.

    Parameters
    ----------
    files : Files
    path : Path
        File that it is in.
    content : (Value, memoryview)
        Document and binary chunk.
    up : str or None
        Axis that points up, y by the definition of glTF: the result has z up, and CESIUM_RTC applied.
        None: the axes of the file, as it is.
    budget : Budget

    Raises
    ------
    SceneError
        When the document is wrong, or there are more faces.
    """
    document, binary = content
    for extension in document.items("extensionsRequired"):
        if extension.text() not in EXTENSIONS and not extension.raw.startswith("KHR_materials_"):
            raise extension.error(repr(extension.raw), ", ".join(sorted(EXTENSIONS)))
    arrays = Arrays(files, path, document, binary, budget.elements)
    upright = np.eye(4) if up is None else _center(document) @ _turn(up)
    primitives: dict[int, list[Primitive]] = {}
    found: list[Geometry] = []
    skipped = count = 0
    meshes = document.items("meshes")
    for node in placed_meshes(document, arrays, budget.faces):
        number = node.mesh.integer(0, len(meshes) - 1)
        if number not in primitives:
            primitives[number], points = read_mesh_primitives(document, meshes[number], arrays, budget)
            skipped += points
        for primitive in primitives[number]:
            count += len(primitive.faces) * len(node.matrices)
            if count > budget.faces:
                many = f"{count} faces, instances counted"
                raise node.mesh.error(many, f"at most {budget.faces} more (max_faces)")
            labels = (*node.labels, *_name(meshes[number]), *primitive.labels)
            found += [Geometry(primitive, upright @ matrix, labels) for matrix in node.matrices]
    return Model(tuple(found), skipped)


def _turn(up: str) -> NDArray[np.float64]:
    """Matrix that makes an axis point along z, as in 3D Tiles 1.1, section 6.7.1.6."""
    matrix = np.eye(4)
    matrix[:3, :3] = {
        "x": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
        "y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
        "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    }[up]
    return matrix


def _center(document: Value) -> NDArray[np.float64]:
    """Translation of CESIUM_RTC; like that of b3dm, it comes after the turn."""
    extensions = document.member("extensions")
    extension = None if extensions is None else extensions.member("CESIUM_RTC")
    matrix = np.eye(4)
    if extension is not None:
        matrix[:3, 3] = extension.need("center").numbers(3)
    return matrix


def _name(value: Value) -> Iterator[str]:
    name = value.member("name")
    if name is not None and isinstance(name.raw, str) and name.raw:
        yield name.raw
