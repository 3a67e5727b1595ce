"""Triangles and feature ids of the primitives of a glTF mesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.gltf.accessors import Arrays
from tilesnav_ref.scene.gltf.compressed import DRACO, DracoMesh, decode_draco
from tilesnav_ref.scene.gltf.values import Value

TRIANGLES, STRIP, FAN = 4, 5, 6


class Wanted(Protocol):
    """What is wanted of a document."""

    @property
    def faces(self) -> int:
        """Faces that are left."""

    @property
    def materials(self) -> bool:
        """Whether the names of materials are wanted."""


@dataclass(frozen=True)
class Primitive:
    """Triangles of one material."""

    vertices: NDArray[np.float64]
    """(V, 3) axes of the mesh, finite."""
    faces: NDArray[np.int64]
    """(F, 3) within range."""
    feature: NDArray[np.int64] | None
    """(F,) feature id of each face, where the primitive has some."""
    labels: tuple[str, ...]
    """Name of the material, if it is wanted and has one."""


def read_mesh_primitives(
    document: Value, mesh: Value, arrays: Arrays, wanted: Wanted
) -> tuple[list[Primitive], int]:
    """Read the triangles of a mesh.

    Returns
    -------
    primitives : list of Primitive
    skipped : int
        Primitives of points or lines.

    Raises
    ------
    SceneError
        When an index is out of range, or a coordinate is not finite.
    """
    found, skipped = [], 0
    for primitive in mesh.need("primitives").elements():
        mode = primitive.member("mode")
        kind = TRIANGLES if mode is None else mode.integer(0, FAN)
        if kind < TRIANGLES:
            skipped += 1
            continue
        labels = _material(document, primitive) if wanted.materials else ()
        found.append(_read(primitive, kind, arrays, labels, wanted.faces))
    return found, skipped


def _read(primitive: Value, kind: int, arrays: Arrays, labels: tuple[str, ...], limit: int) -> Primitive:
    attributes = primitive.need("attributes")
    position = attributes.need("POSITION")
    extensions = primitive.member("extensions")
    draco = None if extensions is None else extensions.member(DRACO)
    ids = _ids(primitive, attributes)
    feature: NDArray[np.generic] | None
    if draco is None:
        vertices = arrays.array(position, 3)
        indices = primitive.member("indices")
        flat = np.arange(len(vertices)) if indices is None else arrays.indices(indices)
        faces = _triangles(primitive, kind, flat)
        feature = None if ids is None else arrays.array(ids, 1)[:, 0]
    else:
        mesh = _decoded(primitive, draco, arrays, limit)
        vertices = np.asarray(_attribute(draco, mesh, "POSITION", 3), np.float64)
        faces = mesh.faces
        name = "" if ids is None else ids.place.rpartition(".")[2]
        stored = bool(name) and draco.need("attributes").has(name)
        feature = _attribute(draco, mesh, name, 1)[:, 0] if stored else None
    _check(primitive, vertices, faces)
    numbers = _of_faces(primitive, feature, vertices, faces)
    if len(vertices) > 3 * len(faces):  # many primitives may share one large array: keep what each uses
        used, corners = np.unique(faces, return_inverse=True)
        vertices, faces = vertices[used], corners.reshape(-1, 3)
    return Primitive(vertices, faces, numbers, labels)


def _decoded(primitive: Value, draco: Value, arrays: Arrays, limit: int) -> DracoMesh:
    """Decode Draco data, which may hold no more than the accessors of the primitive claim."""
    attributes = primitive.need("attributes")
    points = arrays.count(attributes.need("POSITION"))
    indices = primitive.need("indices")
    faces = arrays.count(indices) // 3
    if faces > limit:
        raise indices.error(f"{faces} faces", f"at most {limit} more (max_faces)")
    return decode_draco(draco, arrays.view(draco.need("bufferView")), (faces, points))


def _attribute(draco: Value, mesh: DracoMesh, name: str, width: int) -> NDArray[np.generic]:
    number = draco.need("attributes").need(name)
    unique = number.integer(0, 2**31 - 1)
    if unique not in mesh.attributes or mesh.attributes[unique].size % width:
        raise number.error(f"attribute {unique}", f"one of {sorted(mesh.attributes)}, {width} components")
    return mesh.attributes[unique].reshape(-1, width)


def _triangles(primitive: Value, kind: int, flat: NDArray[np.int64]) -> NDArray[np.int64]:
    """Corners of the triangles of a list, a strip or a fan (glTF 2.0, section 3.7.2.1)."""
    if kind == TRIANGLES:
        if len(flat) % 3:
            raise primitive.error(f"{len(flat)} indices", "a multiple of three, as the mode is triangles")
        return flat.reshape(-1, 3)
    count = max(0, len(flat) - 2)
    if kind == FAN:
        return np.stack((flat[1 : count + 1], flat[2:], np.repeat(flat[:1], count)), axis=1)
    odd = np.arange(count) % 2
    first = np.arange(count)
    return flat[np.stack((first, first + 1 + odd, first + 2 - odd), axis=1)]


def _check(primitive: Value, vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> None:
    wrong = np.flatnonzero(((faces < 0) | (faces >= len(vertices))).any(axis=1))
    if len(wrong):
        found = f"face {wrong[0]} of vertices {faces[wrong[0]].tolist()}"
        raise primitive.error(found, f"0 to {len(vertices) - 1}")
    infinite = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(infinite):
        found = f"vertex {infinite[0]} at {vertices[infinite[0]].tolist()}"
        raise primitive.error(found, "finite coordinates")


def _ids(primitive: Value, attributes: Value) -> Value | None:
    """Accessor of the feature ids: the first set that is an attribute, else that of 3D Tiles 1.0."""
    extensions = primitive.member("extensions")
    features = None if extensions is None else extensions.member("EXT_mesh_features")
    for one in [] if features is None else features.items("featureIds"):
        number = one.member("attribute")
        if number is not None:
            return attributes.need(f"_FEATURE_ID_{number.integer(0, 1 << 16)}")
    for name in ("_FEATURE_ID_0", "_BATCHID", "BATCHID"):  # the last is of files before 1.0
        if attributes.has(name):
            return attributes.need(name)
    return None


def _of_faces(
    primitive: Value,
    feature: NDArray[np.generic] | None,
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
) -> NDArray[np.int64] | None:
    """Feature id of the first corner of every face; compressed ids are fractions near integers."""
    if feature is None:
        return None
    values = np.asarray(feature, np.float64)
    # 2^53: above it float64 does not hold every integer
    if len(values) != len(vertices) or not (np.abs(values) < 2.0**53).all():
        raise primitive.error(f"{len(values)} feature ids", f"{len(vertices)} numbers, one for each vertex")
    return np.rint(values)[faces[:, 0]].astype(np.int64)


def _material(document: Value, primitive: Value) -> tuple[str, ...]:
    number = primitive.member("material")
    materials = document.items("materials")
    if number is None or not materials:
        return ()
    name = materials[number.integer(0, len(materials) - 1)].member("name")
    return (name.raw,) if name is not None and isinstance(name.raw, str) and name.raw else ()
