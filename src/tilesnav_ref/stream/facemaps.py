"""Reading face maps: which faces of level 0 those of a coarse content stand for."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.container import FACE_MAP_MAGIC, map_container
from tilesnav_ref.stream.contents import ContentRef, FaceMapRef
from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.fields import Fields
from tilesnav_ref.stream.tables import Ragged, TableReader, lengths


@dataclass(frozen=True)
class FaceMap:
    """The face map of one coarse content, mapped into memory."""

    path: Path
    objects: NDArray[np.uint32]
    """(K,) object that each primitive stands for, ascending."""
    errors: NDArray[np.float64]
    """(K,) error of each of them, m."""
    faces: Ragged
    """Faces of level 0 that each face of the content stands for; none of these lists is empty."""


def open_face_map(
    content: ContentRef, primitive_offsets: NDArray[np.int64], object_offsets: NDArray[np.int64]
) -> FaceMap:
    """Map the face map of a coarse content into memory.

    Parameters
    ----------
    content : ContentRef
        A content with a face map.
    primitive_offsets : (K + 1,) int64
        First face of each of its primitives, and the number of its faces.
    object_offsets : (N + 1,) int64
        First face of every object of level 0, and the number of faces.

    Returns
    -------
    FaceMap
        Every face of the content stands for one face at least, and only for faces of the object of its
        primitive; every face of each of these objects is stood for.

    Raises
    ------
    TilesetError
        When the file cannot be read, has another digest, or breaks any of this.
    """
    stated = content.face_map
    if stated is None:
        raise ValueError(f"{content.path}: a content of level {content.level} without a face map")
    _check_digest(stated)
    container = map_container(stated.path, FACE_MAP_MAGIC)
    members = container.members.fields("faceMap")
    count = _count(members, "objectCount", content.object_count)
    face_count = _count(members, "faceCount", content.face_count)
    reader = TableReader(container, {})
    objects = reader.plain(members, "objects", "<u4", (count,), len(object_offsets) - 1)
    if np.any(objects[1:] <= objects[:-1]):
        raise members.error("objects", "other numbers", "numbers in strictly ascending order")
    errors = reader.floats(members, "errors", (count,))
    if count and float(errors.min()) < 0.0:
        raise members.error("errors", float(errors.min()), "numbers of 0 or more")
    total, limit = members.integer("count"), int(object_offsets[-1])
    faces = reader.lists(members, ("offsets", "faces"), face_count, total, limit)
    face_map = FaceMap(stated.path, objects, errors, faces)
    _check_cover(members, face_map, primitive_offsets, object_offsets)
    return face_map


def _check_digest(stated: FaceMapRef) -> None:
    try:
        with stated.path.open("rb") as file:
            found = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise TilesetError(
            str(stated.path), "file", error.strerror or "an error", "a readable file"
        ) from error
    if found != stated.sha256:
        allowed = f"{stated.sha256}, as the tileset states"
        raise TilesetError(str(stated.path), "sha256", found, allowed)


def _count(members: Fields, name: str, stated: int) -> int:
    """Return a count that has to be the one which the tileset states, and which the content has been found
    to have: so no table is larger than the file allows and the content needs."""
    found = members.integer(name)
    if found != stated:
        raise members.error(name, found, f"{stated}, as the tileset states")
    return found


def _check_cover(
    members: Fields,
    face_map: FaceMap,
    primitive_offsets: NDArray[np.int64],
    object_offsets: NDArray[np.int64],
) -> None:
    """Check that faces list faces of their object, one at least, and all of them between them."""
    sizes = face_map.faces.lengths()
    if not sizes.all():
        raise members.error(
            "offsets", f"no face for face {int(np.argmin(sizes))}", "one face of level 0 at least"
        )
    objects = face_map.objects.astype(np.int64)
    owner = np.repeat(np.repeat(objects, lengths(primitive_offsets)), sizes)
    listed = face_map.faces.values.astype(np.int64)
    outside = (listed < object_offsets[owner]) | (listed >= object_offsets[owner + 1])
    if outside.any():
        first = int(np.argmax(outside))
        raise members.error("faces", f"{listed[first]} of another object", f"faces of object {owner[first]}")
    stood_for = np.zeros(int(object_offsets[-1]), np.bool_)
    stood_for[listed] = True
    # Lists hold faces of these objects only, so their number tells whether one is missing.
    needed = int((object_offsets[objects + 1] - object_offsets[objects]).sum())
    found = int(np.count_nonzero(stood_for))
    if found != needed:
        raise members.error("faces", f"{found} faces", f"all {needed} faces of the objects")
