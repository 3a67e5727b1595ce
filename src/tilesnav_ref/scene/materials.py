"""Names of the materials of an OBJ file, without reading the materials themselves."""

from __future__ import annotations

import re

import trimesh

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


def material_names(scene: trimesh.Scene) -> dict[str, str]:
    """Name of the material of each geometry of a parsed OBJ file, as far as it has one."""
    found = {}
    for name, geometry in scene.geometry.items():
        material = getattr(getattr(geometry, "visual", None), "material", None)
        label = getattr(material, "name", None)
        if label:
            found[name] = str(label)
    return found
