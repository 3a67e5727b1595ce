"""Writing the sample scene."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import numpy as np
import trimesh
from trimesh.exchange.ply import export_ply

from tilesnav_ref.scene import Scene
from tilesnav_ref.scene.sample import TRAINING_SITE, TownSettings, make_town
from tilesnav_ref.tileset.errors import OutputError

SIZES = {"small": TownSettings(), "full": TRAINING_SITE}
"""Extents of the town by the name of the option."""


def write_sample(out: Path, settings: TownSettings) -> str:
    """Write the sample town as binary PLY, in metres, and return a line that says what it is.

    Raises
    ------
    OutputError
        When the file exists already, is not named .ply, or its folder does not exist.
    """
    if out.suffix.lower() != ".ply":
        raise OutputError(f"{out}: found the ending {out.suffix!r}; allowed: .ply")
    if not out.parent.is_dir():
        raise OutputError(f"{out}: its parent {out.parent} is not a folder")
    if out.exists():
        raise OutputError(f"{out}: exists already")
    scene = make_town(settings)
    with tempfile.TemporaryDirectory(prefix=f".{out.name}.", dir=out.parent) as folder:
        part = Path(folder) / "part.ply"
        part.write_bytes(ply_bytes(scene))
        os.link(part, out)  # unlike a rename, this fails when something has appeared there
    return f"{out}: {scene.face_count} faces, {len(scene.vertices)} vertices, {scene.object_count} objects"


def ply_bytes(scene: Scene) -> bytes:
    """Binary PLY of a scene; float32 holds grid coordinates exactly."""
    metres = scene.vertices * np.float64(scene.step)
    mesh = trimesh.Trimesh(metres, scene.faces, process=False)
    data: bytes = export_ply(mesh, vertex_normal=False)
    return data
