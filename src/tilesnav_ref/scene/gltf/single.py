"""A glTF file that is a scene of its own."""

from __future__ import annotations

from pathlib import Path

from tilesnav_ref.scene.gltf.files import Files
from tilesnav_ref.scene.gltf.grouping import Grouped
from tilesnav_ref.scene.gltf.model import Budget, Geometry, read_model, split_glb
from tilesnav_ref.scene.gltf.values import parse
from tilesnav_ref.scene.parts import Part


def read_gltf(path: Path, data: bytes, max_faces: int, with_materials: bool) -> tuple[tuple[Part, ...], int]:
    """Read a file named .glb or .gltf.

    Parameters
    ----------
    path : Path
        Buffers that it names lie in its folder or below.
    data : bytes
        Its content.
    max_faces : int
        Greatest number of faces, instances counted.
    with_materials : bool
        Whether the labels of parts hold the names of their materials.

    Returns
    -------
    parts : tuple of Part
        In the axes of the file; one for each placed primitive, or for each of its features. Named after
        node or mesh; later ones of the same name are numbered.
    skipped : int
        Primitives of points or lines.

    Raises
    ------
    SceneError
        Naming the place.
    """
    source = str(path)
    if path.suffix.lower() == ".glb":
        content = split_glb(source, "glTF", memoryview(data))
    else:
        content = parse(source, "", data), memoryview(b"")
    model = read_model(Files(path), path, content, None, Budget(max_faces, 3 * max_faces, with_materials))
    grouped, used = Grouped(), dict[str, int]()
    for geometry in model.geometries:
        grouped.add(source, _unique(geometry, path.stem, used), geometry, geometry.matrix)
    return tuple(grouped.parts()), model.skipped


def _unique(geometry: Geometry, default: str, used: dict[str, int]) -> str:
    """Give a name that no part has yet."""
    first = geometry.labels[0] if geometry.labels else default
    name = first
    while name in used:
        used[first] += 1
        name = f"{first}_{used[first]}"
    used[name] = 0
    return name
