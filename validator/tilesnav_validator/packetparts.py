"""What a vehicle holds: parts of objects, the marks of states, and the rules that every body has to keep."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FaceArray = NDArray[np.uint32]
CornerArray = NDArray[np.int32]

REACH = 2**23
"""Bound of the magnitude of corners, in grid steps."""
FLAGS = 3
"""Bits of the flags of an object: porous, one-sided."""
FACE_BYTES = 40
"""Bytes of a face in a state: its index, and nine coordinates."""
MAX_FACES = 2**22
"""Most faces of a state."""

_PART = struct.Struct("<IBBI")


class BodyError(ValueError):
    """A body is not what its codec asks for."""

    def __init__(self, where: str, measured: object, allowed: str) -> None:
        super().__init__(f"{where}: {measured}, allowed is {allowed}")
        self.where, self.measured, self.allowed = where, str(measured)[:200], allowed


class BeyondTilesetError(BodyError):
    """A body names more than the tileset has; it is not read further."""


@dataclass(frozen=True, eq=False)
class Part:
    """The part of an object that is held.

    Attributes
    ----------
    item : int
        Number of the object.
    level, flags : int
    faces : ndarray of uint32, shape (n,)
        Numbers of faces within the object at the level, ascending.
    corners : ndarray of int32, shape (n, 3, 3)
        Grid steps, nav frame; turned to the smallest row of nine numbers.
    """

    item: int
    level: int
    flags: int
    faces: FaceArray
    corners: CornerArray

    @property
    def size(self) -> int:
        """Bytes in the canonical form of a state."""
        return _PART.size + FACE_BYTES * len(self.faces)


Parts = Mapping[int, Part]
"""Held parts by the number of their object."""


def size(parts: Iterable[Part]) -> int:
    """Bytes of the canonical form of a state with these parts."""
    return 20 + sum(part.size for part in parts)


def mark(of_map: bytes, cell: int, exact: bool, parts: Parts) -> bytes:
    """First 8 bytes of the SHA-256 of the canonical form of a state.

    Parameters
    ----------
    of_map : bytes
        The 8 bytes of the map.
    cell : int
    exact : bool
        Whether the state is said to hold nothing without need.
    parts : mapping
    """
    digest = hashlib.sha256(of_map + struct.pack("<III", cell, exact, len(parts)))
    for item in sorted(parts):
        part = parts[item]
        digest.update(_PART.pack(item, part.level, part.flags, len(part.faces)))
        digest.update(np.ascontiguousarray(part.faces, "<u4").data)
        digest.update(np.ascontiguousarray(part.corners, "<i4").data)
    return digest.digest()[:8]


def ascending(values: NDArray[np.uint32]) -> bool:
    """Whether numbers ascend strictly."""
    return bool((values[1:] > values[:-1]).all())


def precedes(left: CornerArray, right: CornerArray) -> NDArray[np.bool_]:
    """Whether rows of numbers are smaller than others in lexicographic order, shapes (n, k)."""
    differ = left != right
    place = np.argmax(differ, axis=1)[:, None]
    smaller = np.take_along_axis(left, place, 1) < np.take_along_axis(right, place, 1)
    return np.asarray(smaller[:, 0])  # where no number differs, those at 0 are equal


def turned(corners: CornerArray) -> CornerArray:
    """Faces, each turned until the row of its nine numbers is the smallest.

    Parameters
    ----------
    corners : ndarray of int32, shape (n, 3, 3)

    Returns
    -------
    ndarray of int32, shape (n, 3, 3)
    """
    best = corners.reshape(-1, 9)
    for turn in (3, 6):
        other = np.roll(corners.reshape(-1, 9), -turn, axis=1)
        best = np.where(precedes(other, best)[:, None], other, best)
    return best.reshape(-1, 3, 3)


def need_corners(entering: Sequence[tuple[int, CornerArray]]) -> None:
    """Refuse corners that are out of reach or not turned, of all faces that enter by their objects."""
    counts = np.array([len(corners) for _, corners in entering], np.int64)
    items = np.repeat(np.array([item for item, _ in entering], np.int64), counts)
    corners = np.concatenate([np.zeros((0, 3, 3), np.int32), *(corners for _, corners in entering)])
    far = np.flatnonzero(((corners <= -REACH) | (corners >= REACH)).any(axis=(1, 2)))
    if len(far):
        raise BodyError(f"object {items[far[0]]}", corners[far[0]].tolist(), "magnitudes less than 2^23")
    wanted = turned(corners)
    other = np.flatnonzero((wanted != corners).any(axis=(1, 2)))
    if len(other):
        allowed = f"{wanted[other[0]].tolist()}, the smallest row"
        raise BodyError(f"object {items[other[0]]}", corners[other[0]].tolist(), allowed)


def _places(faces: FaceArray, sought: FaceArray) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Where faces are, or would be, among others that ascend, and whether they are there."""
    places = np.searchsorted(faces, sought)
    return places, faces[np.minimum(places, len(faces) - 1)] == sought


def joined(part: Part, leave: FaceArray, enter: FaceArray, corners: CornerArray) -> Part:
    """A part after faces have left and others entered.

    Raises
    ------
    BodyError
        Where a face leaves that is not held, enters that is held, or none is left.
    """
    where = f"object {part.item}"
    places, there = _places(part.faces, leave)
    if not there.all():
        raise BodyError(where, f"face {leave[~there][0]} leaves", "faces that are held")
    _, there = _places(part.faces, enter)
    if there.any():
        raise BodyError(where, f"face {enter[there][0]} enters", "faces that are not held")
    stays = np.ones(len(part.faces), bool)
    stays[places] = False
    faces = np.concatenate((part.faces[stays], enter))
    if not len(faces):
        raise BodyError(where, "no face is left", "one at least, or the object goes")
    order = np.argsort(faces)
    together = np.concatenate((part.corners[stays], corners))
    return Part(part.item, part.level, part.flags, faces[order], together[order])


def need_room(parts: Iterable[Part]) -> None:
    """Refuse more faces than a state may have."""
    count = sum(len(part.faces) for part in parts)
    if count > MAX_FACES:
        raise BodyError("body", f"{count} faces are held", f"at most {MAX_FACES}")
