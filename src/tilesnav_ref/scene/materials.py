"""Names of the materials of a file, without reading the materials themselves."""

from __future__ import annotations

import json
import re
import struct
from typing import Any

import trimesh

LINES_AND_POINTS = range(4)
"""Modes of glTF that make no faces."""
USE_MATERIAL = re.compile(rb"^[ \t]*usemtl[ \t]+(\S[^\r\n]*?)[ \t]*\r?$", re.MULTILINE)


class NamesOnly(trimesh.resolvers.Resolver):
    """Gives, for any library of materials, one that names some materials and says nothing else of them."""

    def __init__(self, names: list[bytes]) -> None:
        self._library = b"".join(b"newmtl " + name + b"\n" for name in names)

    def get(self, name: str) -> bytes:  # noqa: ARG002
        """Return the library, whatever its name."""
        return self._library

    def namespaced(self, namespace: str) -> NamesOnly:  # noqa: ARG002
        """Return this: there are no folders."""
        return self

    def write(self, name: str, data: bytes) -> None:
        """Write nothing."""

    def keys(self) -> list[str]:
        """Return no names: whatever is asked for is there."""
        return []


def with_named_materials(data: bytes) -> tuple[bytes, NamesOnly]:
    """Make an OBJ file name a library of materials, and give the resolver that makes it up."""
    names = list(dict.fromkeys(USE_MATERIAL.findall(data)))
    return b"mtllib names.mtl\n" + data, NamesOnly(names)


def material_names(suffix: str, data: bytes, scene: trimesh.Scene) -> dict[str, str]:
    """Name of the material of each geometry of a parsed file, as far as it has one."""
    if suffix in (".glb", ".gltf"):
        return _of_gltf(suffix, data, scene)
    found = {}
    for name, geometry in scene.geometry.items():
        material = getattr(getattr(geometry, "visual", None), "material", None)
        label = getattr(material, "name", None)
        if suffix == ".obj" and label:
            found[name] = str(label)
    return found


def _of_gltf(suffix: str, data: bytes, scene: trimesh.Scene) -> dict[str, str]:
    """Geometries come in the order of meshes and primitives; where they do not, no name is given."""
    length = struct.unpack_from("<I", data, 12)[0] if suffix == ".glb" else 0
    document: dict[str, Any] = json.loads(data[20 : 20 + length] if length else data)
    primitives = [p for mesh in document.get("meshes", []) for p in mesh.get("primitives", [])]
    if len(primitives) != len(scene.geometry):
        return {}
    materials = document.get("materials", [])
    found = {}
    for name, primitive in zip(scene.geometry, primitives, strict=True):
        makes_faces = primitive.get("mode", 4) not in LINES_AND_POINTS
        if makes_faces != isinstance(scene.geometry[name], trimesh.Trimesh):
            return {}
        material = primitive.get("material")
        if isinstance(material, int) and 0 <= material < len(materials) and "name" in materials[material]:
            found[name] = str(materials[material]["name"])
    return found
