"""Writing of a scene as a mesh file that people can open."""

from __future__ import annotations

import os
from os import PathLike
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.exchange.gltf import export_glb
from trimesh.exchange.ply import export_ply

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.model import Scene

SUFFIXES = (".ply", ".glb")
"""Both hold float32, which is exact for grid coordinates of 24 bits."""


def write_mesh(scene: Scene, path: str | PathLike[str]) -> None:
    """Write a scene as PLY (one mesh, z up) or GLB (one node an object, y up as glTF wants it); metres, nav
    frame.

    Parameters
    ----------
    scene : Scene
    path : str or path
        File to write; replaced only when the new one is complete.

    Raises
    ------
    SceneError
        When the name ends otherwise, or the file cannot be written.

    Notes
    -----
    Reading the file again gives the same faces exactly.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise SceneError(str(path), "name", repr(path.suffix), " or ".join(SUFFIXES))
    data = _ply(scene) if suffix == ".ply" else _glb(scene)
    unfinished = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        unfinished.write_bytes(data)
        unfinished.replace(path)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise SceneError(str(path), "file", error.strerror or str(error), "a place to write to") from error


def _metres(vertices: NDArray[np.int64], exponent: int) -> NDArray[np.float64]:
    return np.ldexp(vertices.astype(np.float64), exponent)


def _ply(scene: Scene) -> bytes:
    mesh = trimesh.Trimesh(_metres(scene.vertices, scene.grid_exponent), scene.faces, process=False)
    return bytes(export_ply(mesh, vertex_normal=False))


def _glb(scene: Scene) -> bytes:
    y_up = np.array(((1, 0, 0), (0, 0, 1), (0, -1, 0)))
    document = trimesh.Scene()
    bounds = np.searchsorted(scene.face_object, np.arange(scene.object_count + 1))
    for k, name in enumerate(scene.object_names):
        faces = scene.faces[bounds[k] : bounds[k + 1]]
        used, local = np.unique(faces, return_inverse=True)
        vertices = _metres(scene.vertices[used] @ y_up.T, scene.grid_exponent)
        mesh = trimesh.Trimesh(vertices, local.reshape(-1, 3), process=False)
        document.add_geometry(mesh, node_name=f"{k:05d} {name}", geom_name=f"{k:05d} {name}")
    return bytes(export_glb(document, include_normals=False))  # type: ignore[no-untyped-call]
