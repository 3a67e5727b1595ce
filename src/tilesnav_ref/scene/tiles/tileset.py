"""Reading of a tileset: every triangle of its finest level."""

from __future__ import annotations

import logging
from collections import Counter
from pathlib import Path

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.gltf.files import Files
from tilesnav_ref.scene.parts import MeshFile
from tilesnav_ref.scene.tiles.contents import Contents
from tilesnav_ref.scene.tiles.walk import Walk

LOG = logging.getLogger(__name__)


def read_tileset(path: Path, up: str, max_faces: int, with_materials: bool = False) -> MeshFile:
    """Read the contents of a tileset that nothing finer replaces.

    Parameters
    ----------
    path : Path
        Entry tileset; all that it names lies in its folder or below.
    up : str
        Axis of the contents that points up: "x", "y", "z", or "auto" as the tilesets say, else y.
    max_faces : int
        Greatest number of faces, instances counted.
    with_materials : bool
        Whether the labels of parts hold the names of their materials.

    Returns
    -------
    MeshFile
        In the axes of the entry tileset, z up. A part for each feature of a content, or for each set of
        names in it. Parts follow the order of the tree. Declared volumes and errors are not used.

    Raises
    ------
    SceneError
        Naming the file, the place, what was found and what is allowed.
    """
    if not path.is_file():
        raise SceneError(str(path), "file", "no file", "a readable file")
    files = Files(path)
    contents = Contents(files, max_faces, with_materials)
    walk = Walk(files, contents.read, up)
    parts = walk.entry(files.folder / path.name if not path.is_symlink() else path.resolve())
    for what, count in contents.left_out.items():
        LOG.warning("%d contents of format %s were left out", count, what)
    if not parts:
        found = f"no face ({_listed(contents.left_out)})" if contents.left_out else "no face"
        raise SceneError(str(path), "tileset", found, "contents with one triangle or more: b3dm, cmpt, glTF")
    return MeshFile(tuple(parts), contents.primitives_left_out, _notes(files, contents, walk))


def _notes(files: Files, contents: Contents, walk: Walk) -> tuple[str, ...]:
    notes = [
        f"{files.count} files were read, {contents.count} of them contents with faces;"
        f" SHA-256 over theirs, in order: {files.digest}"
    ]
    if contents.left_out:
        listed = _listed(contents.left_out)
        notes.append(f"contents without triangles that can be read were left out: {listed}")
    if walk.left_out.total():
        notes.append(f"contents were left out: {_listed(walk.left_out)}")
    return tuple(notes)


def _listed(counts: Counter[str]) -> str:
    return ", ".join(f"{count} {what}" for what, count in sorted(counts.items()) if count)
