"""Reading of mesh files: glTF by this package, all others through trimesh."""

from __future__ import annotations

import io
import json
import logging
import struct
import warnings
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from tilesnav_ref.scene.claims import check_claims, is_binary_stl
from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.gltf import read_gltf
from tilesnav_ref.scene.gltf.files import FILE_BYTES_LIMIT
from tilesnav_ref.scene.materials import material_names, with_named_materials
from tilesnav_ref.scene.parts import MeshFile, Part

GLTF_SUFFIXES = (".glb", ".gltf")
SUFFIXES = (".ply", ".obj", ".stl", *GLTF_SUFFIXES, ".off")

PARSER_FAILURES = (
    ValueError,
    TypeError,
    LookupError,
    AttributeError,
    ArithmeticError,
    AssertionError,
    NameError,
    RuntimeError,
    OSError,
    EOFError,
    ImportError,
    MemoryError,
    struct.error,
    zlib.error,
    json.JSONDecodeError,
)
"""What trimesh has been seen to raise on broken files; it has no error of its own."""


def read_mesh(path: Path, max_faces: int, with_materials: bool = False) -> MeshFile:
    """Read every triangle of a file.

    Parameters
    ----------
    path : Path
        File with one of the names in SUFFIXES.
    max_faces : int
        Greatest number of faces and of vertices, instances counted.
    with_materials : bool
        Whether the labels of parts hold the names of their materials.

    Raises
    ------
    SceneError
        When the file cannot be read, is not what its name says, claims more than it holds, has no face, or
        has a vertex that is not finite or an index out of range.
    """
    source, suffix = str(path), path.suffix.lower()
    if suffix not in SUFFIXES:
        raise SceneError(source, "name", repr(suffix), ", ".join(SUFFIXES))
    data = _read_bytes(path)
    claimed = None
    if suffix in GLTF_SUFFIXES:
        parts, skipped = read_gltf(path, data, max_faces, with_materials)
    else:
        claimed = check_claims(path, data, max_faces)
        scene = _parse(path, suffix, data, with_materials)
        materials = material_names(scene) if with_materials and suffix == ".obj" else {}
        parts, skipped = _placed_parts(source, scene, max_faces, materials)
    count = sum(len(p.faces) for p in parts)
    if claimed is not None and count < claimed:
        raise SceneError(source, "faces", f"{count} of the {claimed} that the header claims", "all of them")
    if not count:
        found = f"no face ({skipped} sets of points or lines)" if skipped else "no face"
        raise SceneError(source, "file", found, "a mesh with one triangle or more")
    return MeshFile(parts, skipped)


def _read_bytes(path: Path) -> bytes:
    try:
        size = path.stat().st_size
        if size > FILE_BYTES_LIMIT:
            raise SceneError(str(path), "file", f"{size} bytes", f"at most {FILE_BYTES_LIMIT}; divide it")
        return path.read_bytes()
    except OSError as error:
        raise SceneError(str(path), "file", error.strerror or str(error), "a readable file") from error


def _parse(path: Path, suffix: str, data: bytes, with_materials: bool) -> trimesh.Scene:
    """Hand the bytes to trimesh; from memory, so that no claimed length allocates more than there is."""
    options: dict[str, Any] = {"skip_materials": True}
    resolver: trimesh.resolvers.Resolver = trimesh.resolvers.FilePathResolver(str(path.resolve()))
    if suffix == ".obj":
        options.update(split_objects=True, maintain_order=True)
        if with_materials:
            data, resolver = with_named_materials(data)
            options["skip_materials"] = False
    try:
        with warnings.catch_warnings(), _silent(logging.getLogger("trimesh")):
            warnings.simplefilter("ignore")
            return trimesh.load_scene(
                io.BytesIO(_as_utf8(suffix, data)),
                file_type=suffix[1:],
                resolver=resolver,
                process=False,
                **options,
            )
    except PARSER_FAILURES as error:
        found = f"{type(error).__name__}: {error}"[:200]
        raise SceneError(str(path), "content", found, f"a valid {suffix[1:].upper()} file") from error


@contextmanager
def _silent(log: logging.Logger) -> Iterator[None]:
    """Hold back what trimesh says on the way to an error; the error says it."""
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        log.setLevel(level)


def _as_utf8(suffix: str, data: bytes) -> bytes:
    """Texts in other encodings have odd names only; trimesh would ask for a package to guess the encoding."""
    if suffix not in (".obj", ".off", ".stl") or (suffix == ".stl" and data[:5].lower() != b"solid"):
        return data
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return data if suffix == ".stl" and is_binary_stl(data) else data.decode("latin-1").encode("utf-8")
    return data


def _placed_parts(
    source: str, scene: trimesh.Scene, max_faces: int, materials: dict[str, str]
) -> tuple[tuple[Part, ...], int]:
    meshes = {n: g for n, g in scene.geometry.items() if isinstance(g, trimesh.Trimesh) and len(g.faces)}
    placed = []
    for node in sorted(scene.graph.nodes_geometry, key=str):
        matrix, name = scene.graph[node]
        if name in meshes:
            labels = (str(node), str(name), *([materials[name]] if name in materials else []))
            placed.append((labels, np.asarray(matrix, np.float64), meshes[name]))
    for what, count in (
        ("faces", sum(len(mesh.faces) for _, _, mesh in placed)),
        ("vertices", sum(len(mesh.vertices) for _, _, mesh in placed)),
    ):
        if count > max_faces:
            raise SceneError(
                source, "scene", f"{count} {what}, instances counted", f"at most {max_faces} (max_faces)"
            )
    parts = tuple(_part(source, labels, matrix, mesh) for labels, matrix, mesh in placed)
    return parts, len(scene.geometry) - len(meshes)


def _part(source: str, labels: tuple[str, ...], matrix: NDArray[np.float64], mesh: trimesh.Trimesh) -> Part:
    name = labels[0]
    vertices = np.asarray(mesh.vertices, np.float64)
    faces = np.asarray(mesh.faces, np.int64)
    if vertices.shape[1:] != (3,) or faces.shape[1:] != (3,):
        found = f"vertices of shape {vertices.shape}, faces of shape {faces.shape}"
        raise SceneError(source, name, found, "three coordinates a vertex, three corners a face")
    wrong = np.flatnonzero(((faces < 0) | (faces >= len(vertices))).any(axis=1))
    if len(wrong):
        first = f"{name}: face {wrong[0]}"
        raise SceneError(
            source, first, f"vertex indices {faces[wrong[0]].tolist()}", f"0 to {len(vertices) - 1}"
        )
    infinite = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(infinite):
        first = f"{name}: vertex {infinite[0]}"
        raise SceneError(source, first, f"{vertices[infinite[0]].tolist()}", "finite coordinates")
    if not np.array_equal(matrix, np.eye(4)):
        with np.errstate(over="ignore", invalid="ignore"):  # refused below
            vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
        if not np.isfinite(vertices).all():
            raise SceneError(
                source, f"node {name}", "a transform with non-finite result", "finite coordinates"
            )
    return Part(name, vertices, faces, labels)
