"""What a vehicle holds in a cell, and the mark that binds it."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from struct import Struct

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.packet.geometry_order import find_turned, first_beyond
from tilesnav_ref.packet.model import Limits, ObjectFaces, PacketError

Buffer = bytes | memoryview
Parts = tuple[ObjectFaces, ...]
"""Of different objects, ascending."""

NAME_BYTES = 8
"""Bytes of the name of a map, and of a mark."""
KNOWN_FLAGS = 3
"""Bit 0 porous, bit 1 one-sided."""
STATE = Struct("<8sIII")
"""Map, cell, exact or not, number of objects."""
PART = Struct("<IBBI")
"""Object, level, flags, number of faces."""


@dataclass(frozen=True)
class HeldState:
    """What a vehicle holds, and for which cell of which map."""

    map_name: bytes
    """First 8 bytes of the SHA-256 of the entry tileset file."""
    cell: int
    exact: bool
    """Whether nothing is held that the cell does not call for."""
    parts: Parts

    @property
    def face_count(self) -> int:
        """Faces held in all."""
        return face_count(self.parts)

    def canonical_bytes(self) -> bytes:
        """Map, cell, exactness and parts, little-endian, as the specification lays them down."""
        chunks: list[Buffer] = [STATE.pack(self.map_name, self.cell, self.exact, len(self.parts))]
        for part in self.parts:
            chunks.append(PART.pack(part.object, part.level, part.flags, len(part.faces)))
            chunks.append(np.ascontiguousarray(part.faces, "<u4").data)
            chunks.append(np.ascontiguousarray(part.corners, "<i4").data)
        return b"".join(chunks)

    @cached_property
    def mark(self) -> bytes:
        """First 8 bytes of the SHA-256 of the canonical bytes."""
        return hashlib.sha256(self.canonical_bytes()).digest()[:NAME_BYTES]


def face_count(parts: Sequence[ObjectFaces]) -> int:
    """Faces of all parts."""
    return sum(len(part.faces) for part in parts)


def same_part(one: ObjectFaces, other: ObjectFaces) -> bool:
    """Whether two parts hold the same of the same object."""
    return one is other or (
        (one.object, one.level, one.flags) == (other.object, other.level, other.flags)
        and np.array_equal(one.faces, other.faces)
        and np.array_equal(one.corners, other.corners)
    )


def check_parts(parts: Sequence[ObjectFaces], limits: Limits) -> None:
    """Refuse what is no list of held parts.

    Parameters
    ----------
    parts : sequence of ObjectFaces
    limits : Limits
        Faces and objects that may be held.

    Raises
    ------
    PacketError
        Naming the object and what is wrong with it.
    """
    if len(parts) > limits.objects:
        raise PacketError(f"{len(parts)} objects held; allowed: {limits.objects} or less")
    total = face_count(parts)
    if total > limits.faces:
        raise PacketError(f"{total} faces held; allowed: {limits.faces} or less")
    last = -1
    for part in parts:
        if part.object <= last:
            raise PacketError(f"object {part.object} after object {last}; allowed: ascending ones")
        last = part.object
        _check_part(part)


def _check_part(part: ObjectFaces) -> None:
    where = f"object {part.object}"
    if part.object >= 1 << 32 or not 0 <= part.level < 256:
        raise PacketError(f"{where}: level {part.level}; allowed: objects below 2^32, levels 0 to 255")
    if not 0 <= part.flags <= KNOWN_FLAGS:
        raise PacketError(f"{where}: flags {part.flags:#04x}; allowed: bits 0 and 1")
    count = len(part.faces)
    if not count or part.corners.shape != (count, 3, 3):
        found = f"{count} faces with corners of shape {part.corners.shape}"
        raise PacketError(f"{where}: {found}; allowed: one face at least, nine coordinates each")
    if not ascending(part.faces):
        raise PacketError(f"{where}: faces that do not ascend; allowed: strictly ascending ones")
    _check_corners(part)


def _check_corners(part: ObjectFaces) -> None:
    corners = np.ascontiguousarray(part.corners, np.int32)
    bad = first_beyond(corners)
    if bad < len(corners):
        found = max(corners[bad].ravel().tolist(), key=abs)
        where = f"object {part.object}: a coordinate of {found} steps"
        raise PacketError(f"{where}; allowed: magnitudes below 2^23")
    if not is_turned(corners).all():
        what = "corners of a face in another order; allowed: the least of the three rotations"
        raise PacketError(f"object {part.object}: {what}")


def ascending(numbers: NDArray[np.uint32]) -> bool:
    """Whether numbers ascend strictly."""
    return bool((numbers[1:] > numbers[:-1]).all())


def is_turned(corners: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Whether each face begins with the corner that makes its nine numbers the least of the three rotations.

    Parameters
    ----------
    corners : (F, 3, 3) int32

    Returns
    -------
    (F,) bool

    Examples
    --------
    >>> a, b = [0, 0, 0], [0, 0, 1]
    >>> is_turned(np.array([[a, a, b], [a, b, a], [b, a, a]], np.int32)).tolist()
    [True, False, False]
    """
    turned = np.zeros(len(corners), np.bool_)
    find_turned(corners, turned)
    return turned
