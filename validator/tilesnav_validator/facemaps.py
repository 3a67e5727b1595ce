"""Face maps: their tables, and what their numbers stand for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator import glb, ragged
from tilesnav_validator.findings import Finding
from tilesnav_validator.navfile import Layout, NavFile, TableType
from tilesnav_validator.tables import Ragged
from tilesnav_validator.tiles import Content

IntArray = NDArray[np.int64]

TABLES = {
    "faceMap/objects": TableType("<u4", (), "objects"),
    "faceMap/errors": TableType("<f8", (), "objects"),
    "faceMap/offsets": TableType("<u4", (), "faces+1"),
    "faceMap/faces": TableType("<u4", (), "listed"),
}
"""Tables of a face map by group and member, as the specification lists them."""

_COUNTS = {
    "objects": ("faceMap", "objectCount"),
    "faces": ("faceMap", "faceCount"),
    "listed": ("faceMap", "count"),
}

FMAP = Layout(b"fmap", TABLES, {"faceMap/offsets": "listed"}, _COUNTS)


@dataclass(frozen=True)
class FaceMap:
    """The face map of a content with k primitives and c faces.

    Attributes
    ----------
    name : str
        Uri of the file.
    objects : ndarray of int64, shape (k,)
        Object that each primitive stands for.
    errors : ndarray of float64, shape (k,)
        Metres.
    listed : Ragged
        Faces of level 0 of each face.
    """

    name: str
    objects: IntArray
    errors: NDArray[np.float64]
    listed: Ragged


@dataclass(frozen=True)
class Coarse:
    """A coarse content with the file that it names."""

    content: Content
    file: NavFile


def read(file: NavFile) -> FaceMap:
    """Take the tables of a face map; views, lengths and offsets must have been checked."""
    return FaceMap(
        name=file.name,
        objects=file.table("faceMap/objects").astype(np.int64),
        errors=file.table("faceMap/errors").astype(np.float64),
        listed=Ragged(
            file.table("faceMap/offsets").astype(np.int64), file.table("faceMap/faces").astype(np.int64)
        ),
    )


def number_faults(found: FaceMap, object_count: int, face_count: int) -> Iterator[Finding]:
    """Numbers out of range, and lists that do not ascend."""
    whole = np.array([0, len(found.objects)])
    lists = (
        ("objects", found.objects, whole, object_count),
        ("faces", found.listed.values, found.listed.offsets, face_count),
    )
    for name, values, offsets, limit in lists:
        for index in np.flatnonzero(values >= limit):
            yield Finding(f"{found.name} {name}[{index}]", str(values[index]), f"less than {limit}")
        for index in ragged.not_ascending(values, offsets):
            measured = f"{values[index]} after {values[index - 1]}"
            yield Finding(f"{found.name} {name}[{index}]", measured, "strictly ascending")
    for index in np.flatnonzero(~(np.isfinite(found.errors) & (found.errors >= 0))):
        yield Finding(f"{found.name} errors[{index}]", str(found.errors[index]), "finite, 0 or more")


def primitive_of(primitives: list[glb.Primitive]) -> IntArray:
    """Primitive of each face of a content."""
    counts = [len(part.triangles) for part in primitives]
    return np.repeat(np.arange(len(counts), dtype=np.int64), counts)


def corners_of(primitives: list[glb.Primitive]) -> NDArray[np.float64]:
    """Corners of each face of a content, shape (c, 3, 3), metres, nav frame."""
    return np.concatenate([np.zeros((0, 3, 3)), *(p.positions[p.triangles] for p in primitives)])
