"""Bodies of the coded codec: objects, faces that leave, faces that enter, and their numbers."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tilesnav_validator import packetmesh, packetparts
from tilesnav_validator.packetbits import NUMBER, Bits
from tilesnav_validator.packetmesh import Corners, Entering
from tilesnav_validator.packetparts import FLAGS, BeyondTilesetError, BodyError, Part, Parts, need_room

SAME, CHANGED, GONE, REPLACED = range(4)
MAX_NUMBER = 2**24 - 1
"""Greatest number of an object or a face."""
MAX_LEVEL = 255

_NEW, _ACTION, _LEFT, _LEVEL, _FLAGS, _COUNT, _LEAVE = (block * NUMBER for block in range(7))
_ENTER = _LEAVE + 2
_PLACE = _ENTER + packetmesh.CONTEXTS
_NEGATIVE, _GAP = _PLACE + 8, _PLACE + 16
_CONTEXTS = _GAP + 8 * NUMBER
_NO_ROOM = 7
"""Number of the contexts for a face that no held face follows."""


@dataclass
class _Change:
    """An object that changes or comes."""

    item: int
    held: Part | None
    """What is held of it and stays in part; None where all is replaced."""
    level: int = 0
    flags: int = 0
    leaving: int = 0
    count: int = 0


def decode(body: memoryview, held: Parts, object_count: int) -> dict[int, Part]:
    """Parts that are held after a change; the arguments are those of the plain codec.

    Raises
    ------
    BodyError
        With what is wrong.
    TooManyBitsError
        If the body does not come to an end.
    """
    bits = Bits(body, _CONTEXTS)
    new = _new(bits, held, object_count)
    changes, parts = _actions(bits, held, new)
    _numbers_of(bits, changes)
    entered = sum(change.count for change in changes)
    if entered > packetparts.MAX_FACES:
        raise BodyError("body", f"{entered} faces enter", f"at most {packetparts.MAX_FACES}")
    entering = Entering(bits, _ENTER)
    for change in changes:
        parts[change.item] = _changed(bits, entering, change)
    bits.need_end()
    need_room(parts.values())
    return parts


def _new(bits: Bits, held: Parts, object_count: int) -> list[int]:
    """Objects that come."""
    count = bits.number(_NEW)
    if count > object_count:
        raise BeyondTilesetError("body", f"{count} new objects", f"{object_count}, those of the tileset")
    found: list[int] = []
    for _ in range(count):
        item = (found[-1] + 1 if found else 0) + bits.number(_NEW)
        if item > MAX_NUMBER:
            raise BodyError("body", f"object {item}", f"at most {MAX_NUMBER}")
        if item in held:
            raise BodyError(f"object {item}", "comes", "objects that are not held")
        found.append(item)
    return found


def _actions(bits: Bits, held: Parts, new: list[int]) -> tuple[list[_Change], dict[int, Part]]:
    """Objects that change or come, ascending, and the parts that stay as they are."""
    changes = [_Change(item, None) for item in new]
    parts = dict(held)
    for item in sorted(held):
        action = bits.number(_ACTION)
        if action > REPLACED:
            raise BodyError(f"object {item}", f"action {action}", f"at most {REPLACED}")
        if action == GONE:
            del parts[item]
        elif action != SAME:
            changes.append(_Change(item, held[item] if action == CHANGED else None))
    return sorted(changes, key=lambda change: change.item), parts


def _numbers_of(bits: Bits, changes: list[_Change]) -> None:
    """Numbers of faces that leave and enter, levels and flags."""
    for change in changes:
        if change.held:
            change.level, change.flags = change.held.level, change.held.flags
            change.leaving = bits.number(_LEFT)
            if change.leaving > len(change.held.faces):
                raise BodyError(f"object {change.item}", f"{change.leaving} faces leave", "those it has")
    for block, name, limit in ((_LEVEL, "level", MAX_LEVEL), (_FLAGS, "flags", FLAGS)):
        for change in changes:
            if not change.held:
                value = bits.number(block)
                if value > limit:
                    raise BodyError(f"object {change.item}", f"{name} {value}", f"at most {limit}")
                setattr(change, name, value)
    for change in changes:
        change.count = bits.number(_COUNT)


def _changed(bits: Bits, entering: Entering, change: _Change) -> Part:
    """The part that an object has after its change."""
    faces = np.zeros(0, np.uint32) if change.held is None else change.held.faces
    corners = np.zeros((0, 3, 3), np.int32) if change.held is None else change.held.corners
    leaves = _leaves(bits, len(faces), change.leaving)
    known: list[Corners] = [_as_corners(face) for face in corners.tolist()]
    numbers: list[int] = []
    entered: list[Corners] = []
    if change.count:
        new = entering.faces(known, change.count)
        numbers, entered = _numbered(bits, list(zip(faces.tolist(), known, strict=True)), new)
    after = np.concatenate((faces[~leaves], np.array(numbers, np.uint32)))
    if not len(after):
        raise BodyError(f"object {change.item}", "no face is left", "one at least, or the object goes")
    order = np.argsort(after, kind="stable")
    if (np.diff(after[order].astype(np.int64)) == 0).any():
        raise BodyError(f"object {change.item}", "two faces of one number", "one")
    together = np.concatenate((corners[~leaves], np.array(entered, np.int32).reshape(-1, 3, 3)))
    return Part(change.item, change.level, change.flags, after[order], together[order])


def _as_corners(face: Sequence[Sequence[int]]) -> Corners:
    (a, b, c), (d, e, f), (g, h, i) = face
    return ((a, b, c), (d, e, f), (g, h, i))


def _leaves(bits: Bits, count: int, leaving: int) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which of the held faces leave."""
    found = np.zeros(count, bool)
    before = 0
    for index in range(count):
        if leaving == 0:
            break
        if leaving == count - index:
            found[index:] = True
            break
        before = bits.bit(_LEAVE + before)
        found[index] = before
        leaving -= before
    return found


def _on_curve(face: Corners) -> int:
    """Place of a face on the curve through the middles of faces."""
    place = 0
    for axis in range(3):
        middle = (sum(corner[axis] for corner in face) // 3 + 2**23) >> 3
        for i in range(21):
            place |= (middle >> i & 1) << (3 * i + axis)
    return place


def _numbered(
    bits: Bits, held: list[tuple[int, Corners]], new: list[Corners]
) -> tuple[list[int], list[Corners]]:
    """Numbers of the faces that enter, and these faces in the same order and turned."""
    turned = [min((a, b, c), (b, c, a), (c, a, b)) for a, b, c in new]
    entries: list[tuple[int, Corners]] = sorted((_on_curve(face), face) for face in turned)
    known = sorted((_on_curve(face), number) for number, face in held)
    places = [place for place, _ in entries]
    expected, next_held = 0, 0
    numbers: list[int] = []
    for index, (place, _) in enumerate(entries):
        while next_held < len(known) and known[next_held][0] <= place:
            expected = known[next_held][1] + 1
            next_held += 1
        room = _NO_ROOM
        if next_held < len(known):
            border, following = known[next_held]
            ahead = bisect_left(places, border) - index
            room = min(max(following - expected - ahead + 1, 0), 6)
        number = expected
        if bits.bit(_PLACE + room):
            negative = bits.bit(_NEGATIVE + room)
            step = bits.number(_GAP + room * NUMBER) + 1
            number = expected - step if negative else expected + step
            if not 0 <= number <= MAX_NUMBER:
                raise BodyError("body", f"face {number}", f"from 0 to {MAX_NUMBER}")
        numbers.append(number)
        expected = number + 1
    return numbers, [face for _, face in entries]
