"""Writing the sample scene."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import cast

import numpy as np
import trimesh

from tilesnav_ref.scene import Scene
from tilesnav_ref.scene.sample import TRAINING_SITE, TownSettings, make_town
from tilesnav_ref.tileset.errors import OutputError

SIZES = {"small": TownSettings(), "full": TRAINING_SITE}
"""Extents of the town by the name of the option."""


def write_sample(out: Path, settings: TownSettings) -> str:
    """Write the sample town, in metres, and return a line that says what it is.

    Raises
    ------
    OutputError
        When the file exists already, has another ending, or its folder does not exist.
    """
    encoder = FORMATS.get(out.suffix.lower())
    if encoder is None:
        raise OutputError(f"{out}: found the ending {out.suffix!r}; allowed: {', '.join(FORMATS)}")
    if not out.parent.is_dir():
        raise OutputError(f"{out}: its parent {out.parent} is not a folder")
    if out.exists():
        raise OutputError(f"{out}: exists already")
    scene = make_town(settings)
    with tempfile.TemporaryDirectory(prefix=f".{out.name}.", dir=out.parent) as folder:
        part = Path(folder) / out.name
        part.write_bytes(encoder(scene))
        os.link(part, out)  # unlike a rename, this fails when something has appeared there
    return f"{out}: {scene.face_count} faces, {len(scene.vertices)} vertices, {scene.object_count} objects"


def ply_bytes(scene: Scene) -> bytes:
    """Binary PLY of a scene; float32 holds grid coordinates exactly."""
    metres = scene.vertices * np.float64(scene.step)
    mesh = trimesh.Trimesh(metres, scene.faces, process=False)
    return cast(bytes, mesh.export(file_type="ply", vertex_normal=False))


def glb_bytes(scene: Scene) -> bytes:
    """Binary glTF of a scene with a mesh for each object, which PLY cannot tell apart; exact like PLY."""
    y_up = np.stack((scene.vertices[:, 0], scene.vertices[:, 2], -scene.vertices[:, 1]), axis=1)
    meshes = trimesh.Scene()
    for number, name in enumerate(scene.object_names):
        faces = scene.faces[scene.face_object == number]
        used, corners = np.unique(faces, return_inverse=True)
        mesh = trimesh.Trimesh(y_up[used] * np.float64(scene.step), corners.reshape(-1, 3), process=False)
        meshes.add_geometry(mesh, node_name=f"{number} {name}", geom_name=f"{number} {name}")
    data = meshes.export(file_type="glb", include_normals=False)  # type: ignore[no-untyped-call, unused-ignore]
    return cast(bytes, data)


FORMATS = {".ply": ply_bytes, ".glb": glb_bytes}
