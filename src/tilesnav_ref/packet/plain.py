"""Codec 0: the change between two lists of parts as plain numbers in a zlib stream (RFC 1950)."""

from __future__ import annotations

import zlib
from struct import Struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.packet.model import Limits, ObjectFaces, PacketError
from tilesnav_ref.packet.state import Parts, ascending, same_part

CHANGE = Struct("<IBBH")
"""Object, level, flags, mode."""
COUNT = Struct("<I")
WITHIN, ANEW = 0, 1
"""Modes: change within the level that is held; replacement of what is held."""
FACE_BYTES = 40
"""Index and nine coordinates."""
LEAST_CHANGE = CHANGE.size + 2 * COUNT.size
INFLATED_LIMIT = 1 << 28
INFLATION = 1032
"""No deflate stream inflates to more bytes for each of its own."""


def encode_plain(before: Parts, after: Parts) -> bytes:
    """Encode the change from parts that are held to others.

    Parameters
    ----------
    before, after : tuple of ObjectFaces
        Sound: see `check_parts`.

    Returns
    -------
    bytes
        Body of a packet with codec 0.
    """
    held = {part.object: part for part in before}
    staying = {part.object for part in after}
    gone = np.array([number for number in held if number not in staying], "<u4")
    changes = [
        _change(held.get(part.object), part)
        for part in after
        if part.object not in held or not same_part(held[part.object], part)
    ]
    raw = b"".join((COUNT.pack(len(gone)), gone.tobytes(), COUNT.pack(len(changes)), *changes))
    if len(raw) > INFLATED_LIMIT:
        raise PacketError(f"{len(raw)} bytes in a body; allowed: {INFLATED_LIMIT} or less")
    return COUNT.pack(len(raw)) + zlib.compress(raw, 9)


def _change(held: ObjectFaces | None, part: ObjectFaces) -> bytes:
    """Entry of an object that comes or is not the same: as a change of what is held where that is shorter."""
    if held is not None and (held.level, held.flags) == (part.level, part.flags):
        leave = held.faces[~np.isin(held.faces, part.faces, assume_unique=True)]
        enters = ~np.isin(part.faces, held.faces, assume_unique=True)
        stay = part.corners[~enters], held.corners[np.isin(held.faces, part.faces, assume_unique=True)]
        saved = FACE_BYTES * int((~enters).sum()) - COUNT.size * len(leave)
        if saved > 0 and np.array_equal(*stay):
            return _entry(part, WITHIN, leave, enters)
    return _entry(part, ANEW, np.empty(0, np.uint32), np.ones(len(part.faces), bool))


def _entry(part: ObjectFaces, mode: int, leave: NDArray[np.uint32], enters: NDArray[np.bool_]) -> bytes:
    enter = part.faces[enters]
    return b"".join(
        (
            CHANGE.pack(part.object, part.level, part.flags, mode),
            COUNT.pack(len(leave)),
            leave.astype("<u4").tobytes(),
            COUNT.pack(len(enter)),
            enter.astype("<u4").tobytes(),
            part.corners[enters].astype("<i4").tobytes(),
        )
    )


class _Reader:
    """Inflated bytes, and how far they have been read."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.place = 0

    @property
    def rest(self) -> int:
        return len(self.data) - self.place

    def unpack(self, form: Struct, what: str) -> tuple[int, ...]:
        if self.rest < form.size:
            raise PacketError(f"{what}: {self.rest} bytes left in the body; allowed: {form.size} or more")
        self.place += form.size
        return form.unpack_from(self.data, self.place - form.size)

    def count(self, what: str, least: int) -> int:
        """Read a number of things that take so many bytes each at least."""
        (number,) = self.unpack(COUNT, what)
        if number * least > self.rest:
            raise PacketError(f"{what}: {number}, with {self.rest} bytes left; each takes {least} at least")
        return number

    def array(self, dtype: str, count: int) -> NDArray[Any]:
        """Read numbers whose count has been compared with what is left."""
        values = np.frombuffer(self.data, dtype, count, self.place)
        self.place += values.nbytes
        return values


def decode_plain(data: bytes, before: Parts, limits: Limits) -> Parts:
    """Decode a body of codec 0.

    Parameters
    ----------
    data : bytes
        The body, from anywhere.
    before : tuple of ObjectFaces
        What is held; nothing for a key frame.
    limits : Limits
        How much may be held afterwards.

    Returns
    -------
    tuple of ObjectFaces
        Ascending. Faces that enter are taken as they stand: see `check_parts`.

    Raises
    ------
    PacketError
        Where the body is not one that applies to what is held.
    """
    reader = _Reader(_inflated(data, limits))
    held = {part.object: part for part in before}
    parts = dict(held)
    gone = reader.array("<u4", reader.count("objects that go", COUNT.size))
    if not ascending(gone):
        raise PacketError("objects that go: found numbers that do not ascend; allowed: ascending ones")
    for number in gone.tolist():
        if parts.pop(number, None) is None:
            raise PacketError(f"object {number} goes; allowed: objects that are held")
    last = -1
    for _ in range(reader.count("objects that change or come", LEAST_CHANGE)):
        part = _read_change(reader, held)
        if part.object <= last:
            raise PacketError(f"object {part.object} after object {last}; allowed: ascending ones")
        if part.object in held and part.object not in parts:
            raise PacketError(f"object {part.object} goes and changes; allowed: one of both")
        last = part.object
        parts[last] = part
    if reader.rest:
        raise PacketError(f"{reader.rest} bytes behind the last object; allowed: none")
    return tuple(parts[number] for number in sorted(parts))


def _inflated(data: bytes, limits: Limits) -> bytes:
    if len(data) < COUNT.size:
        raise PacketError(f"a body of {len(data)} bytes; allowed: {COUNT.size} or more")
    (stated,) = COUNT.unpack_from(data)
    # What the vehicle may hold, with every object going and coming, bounds what a body says to it.
    needed = (FACE_BYTES + COUNT.size) * limits.faces + (LEAST_CHANGE + COUNT.size) * limits.objects
    allowed = min(INFLATED_LIMIT, INFLATION * (len(data) - COUNT.size + 1), needed + 2 * COUNT.size)
    if stated > allowed:
        raise PacketError(f"a body of {stated} bytes when inflated; allowed: {allowed} or less")
    stream = zlib.decompressobj()
    try:
        # One byte more than stated, so that the stream can come to its end.
        raw = stream.decompress(data[COUNT.size :], stated + 1)
    except zlib.error as error:
        raise PacketError(f"the body is no zlib stream: {error}") from None
    if not stream.eof or len(raw) != stated or stream.unused_data:
        end = f"an end and {len(stream.unused_data)} bytes behind it" if stream.eof else "no end"
        raise PacketError(f"the body inflates to {len(raw)} bytes, {end}; allowed: {stated}, and no more")
    return raw


def _read_change(reader: _Reader, held: dict[int, ObjectFaces]) -> ObjectFaces:
    number, level, flags, mode = reader.unpack(CHANGE, "an object")
    where = f"object {number}"
    leave = reader.array("<u4", reader.count(f"{where}: faces that leave", COUNT.size))
    count = reader.count(f"{where}: faces that enter", FACE_BYTES)
    enter = reader.array("<u4", count).astype(np.uint32)
    corners = reader.array("<i4", 9 * count).reshape(-1, 3, 3).astype(np.int32)
    if not (ascending(leave) and ascending(enter)):
        raise PacketError(f"{where}: faces that do not ascend; allowed: ascending ones")
    if mode == WITHIN:
        return _within(held.get(number), ObjectFaces(number, level, flags, enter, corners), leave)
    if mode != ANEW:
        raise PacketError(f"{where}: mode {mode}; allowed: 0 and 1")
    if len(leave) or not count:
        raise PacketError(f"{where}: {len(leave)} faces leave, {count} enter anew; allowed: 0, 1 or more")
    return ObjectFaces(number, level, flags, enter, corners)


def _within(held: ObjectFaces | None, new: ObjectFaces, leave: NDArray[np.uint32]) -> ObjectFaces:
    """Change what is held of an object by faces that leave and others that enter, both ascending."""
    where = f"object {new.object}"
    if held is None or (held.level, held.flags) != (new.level, new.flags):
        found = "nothing" if held is None else f"level {held.level}, flags {held.flags}"
        raise PacketError(f"{where}: {found} held; the change is of level {new.level}, flags {new.flags}")
    stays = ~np.isin(held.faces, leave, assume_unique=True)
    count = int(stays.sum()) + len(new.faces)
    if len(held.faces) - int(stays.sum()) != len(leave):
        raise PacketError(f"{where}: a face leaves that is not held")
    if not count or not len(leave) + len(new.faces):
        found = f"{len(leave)} faces leave, {len(new.faces)} enter, {count} are left"
        raise PacketError(f"{where}: {found}; allowed: a change, with one face left at least")
    faces = np.concatenate((held.faces[stays], new.faces))
    order = np.argsort(faces, kind="stable")
    faces = faces[order]
    if not ascending(faces):
        raise PacketError(f"{where}: a face enters that is held")
    return ObjectFaces(
        new.object, new.level, new.flags, faces, np.concatenate((held.corners[stays], new.corners))[order]
    )
