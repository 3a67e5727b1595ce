"""Bodies of the plain codec: a zlib stream of lists."""

from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator.packetparts import (
    FACE_BYTES,
    FLAGS,
    BeyondTilesetError,
    BodyError,
    CornerArray,
    Part,
    Parts,
    ascending,
    joined,
    need_corners,
    need_room,
)

MAX_INFLATED = 2**28
RATIO = 1032
"""No deflate stream gives more bytes for one of its own."""
WITHIN, ANEW = 0, 1
"""Modes of an object that changes or comes."""

_CHANGE = struct.Struct("<IBBH")
_LEAST_CHANGE = _CHANGE.size + 8


class _Reader:
    """The inflated bytes, and how far they have been read."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.place = 0

    @property
    def rest(self) -> int:
        """Bytes that have not been read."""
        return len(self.data) - self.place

    def count(self, what: str, least: int) -> int:
        """A number of elements, each of which takes so many bytes at least."""
        if self.rest < 4:
            raise BodyError(f"byte {self.place} inflated", f"{self.rest} bytes", f"the number of {what}")
        (number,) = struct.unpack_from("<I", self.data, self.place)
        self.place += 4
        if number * least > self.rest:
            raise BodyError(f"byte {self.place - 4} inflated", f"{number} {what}", f"{self.rest} bytes left")
        return int(number)

    def array(self, dtype: str, count: int) -> NDArray[Any]:
        """Elements whose number has been checked."""
        values = np.frombuffer(self.data, dtype, count, self.place)
        self.place += values.nbytes
        return values

    def ascending(self, what: str) -> NDArray[np.uint32]:
        """A number of numbers, and these."""
        values = self.array("<u4", self.count(what, 4))
        if not ascending(values):
            raise BodyError(f"byte {self.place} inflated", f"{what} that do not ascend", "ascending ones")
        return values


def decode(body: memoryview, held: Parts, object_count: int) -> dict[int, Part]:
    """Parts that are held after a change.

    Parameters
    ----------
    body : memoryview
    held : mapping
        Parts that are held before.
    object_count : int
        Objects of the tileset. A body that names more is not read further.

    Raises
    ------
    BodyError
        With the place and what is wrong.
    """
    reader = _Reader(inflated(body))
    gone = reader.ascending("objects that go")
    parts = dict(held)
    for item in gone.tolist():
        if parts.pop(item, None) is None:
            raise BodyError(f"object {item}", "goes", "objects that are held")
    count = reader.count("objects that change or come", _LEAST_CHANGE)
    if count > object_count:
        raise BeyondTilesetError("body", f"{count} objects", f"{object_count}, those of the tileset")
    leaving, last = set(gone.tolist()), -1
    entering: list[tuple[int, CornerArray]] = []
    for _ in range(count):
        part = _change(reader, held, entering)
        if part.item <= last:
            raise BodyError(f"object {part.item}", f"after object {last}", "ascending ones")
        if part.item in leaving:
            raise BodyError(f"object {part.item}", "goes, and changes or comes", "one of both")
        parts[part.item] = part
        last = part.item
    if reader.rest:
        raise BodyError(f"byte {reader.place} inflated", f"{reader.rest} bytes more", "nothing left over")
    need_corners(entering)
    need_room(parts.values())
    return parts


def inflated(body: memoryview) -> bytes:
    """Inflate a body; its stated length is believed only as far as the compressed bytes can reach.

    Raises
    ------
    BodyError
        If the length is not kept, the stream is broken or something follows it.
    """
    if len(body) < 4:
        raise BodyError("body", f"{len(body)} bytes", "the length of what follows, 4 bytes")
    (stated,) = struct.unpack_from("<I", body)
    limit = min(MAX_INFLATED, RATIO * (len(body) - 4) + RATIO)
    if stated > limit:
        raise BodyError("body", f"{stated} bytes when inflated", f"at most {limit}")
    stream = zlib.decompressobj()
    try:
        data = stream.decompress(body[4:], stated + 1)  # one more than stated, so that the stream can end
    except zlib.error as error:
        raise BodyError("body", str(error), "a zlib stream") from None
    if not stream.eof or len(data) != stated:
        more = "" if stream.eof else ", and no end"
        raise BodyError("body", f"{len(data)} bytes when inflated{more}", f"{stated}, as stated")
    if stream.unused_data:
        raise BodyError("body", f"{len(stream.unused_data)} bytes behind the stream", "none")
    return data


def _change(reader: _Reader, held: Parts, entering: list[tuple[int, CornerArray]]) -> Part:
    """The part that an object has after its change; what enters is kept to be looked at together."""
    if reader.rest < _CHANGE.size:
        raise BodyError(f"byte {reader.place} inflated", f"{reader.rest} bytes", "an object")
    item, level, flags, mode = _CHANGE.unpack_from(reader.data, reader.place)
    reader.place += _CHANGE.size
    where = f"object {item}"
    leave = reader.ascending("faces that leave")
    count = reader.count("faces that enter", FACE_BYTES)
    enter = reader.array("<u4", count)
    corners = reader.array("<i4", 9 * count).reshape(-1, 3, 3)
    if not ascending(enter):
        raise BodyError(where, "faces that enter do not ascend", "ascending ones")
    entering.append((item, corners))
    if mode == WITHIN:
        part = held.get(item)
        if part is None:
            raise BodyError(where, "changes within its level", "objects that are held")
        if (level, flags) != (part.level, part.flags):
            said = f"level {level}, flags {flags}"
            raise BodyError(where, said, f"level {part.level}, flags {part.flags}, those held")
        if not len(leave) + count:
            raise BodyError(where, "no face leaves or enters", "a change")
        return joined(part, leave, enter, corners)
    if mode != ANEW:
        raise BodyError(where, f"mode {mode}", "0 or 1")
    if flags > FLAGS:
        raise BodyError(where, f"flags {flags:#04x}", "bits 0 and 1 only")
    if len(leave):
        raise BodyError(where, "faces leave in mode 1", "none")
    if not count:
        raise BodyError(where, "no face enters in mode 1", "one at least")
    return Part(item, level, flags, enter.copy(), corners.copy())  # views would keep all of the body
