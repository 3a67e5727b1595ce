"""Changes of the invalid cases of the class packet."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

from casebuilder.bit_writer import BitWriter
from casebuilder.coarse import Maker
from casebuilder.edits import Edits, edits
from casebuilder.levels import one_level, two_levels
from casebuilder.packets import KEY, NO_CELL, Change, Packet, Part, Parts, Step, mark, without
from casebuilder.valid_packets import AROUND, LEVELS, WALK, in_code, with_points
from casebuilder.world import Point, Triangle
from casebuilder.worlds import EAST, RING, SOUTH, UPPER, WEST

THREE = AROUND[:3]
"""West, south, east."""
GROUND, WALL, POSTER, BUILDING = range(4)


def _packet(change: Callable[[Packet], object], number: int = -1, steps: tuple[Step, ...] = THREE) -> Edits:
    """Edits of a case in which one packet is changed."""
    return edits(packets={WALK: steps}, packet=lambda made: change(made[number]))


def _set(number: int = -1, steps: tuple[Step, ...] = THREE, **members: Any) -> Edits:
    """Edits of a case in which members of one packet are set."""

    def change(packet: Packet) -> None:
        for name, value in members.items():
            setattr(packet, name, value)

    return _packet(change, number, steps)


def _file(change: Callable[[bytes], bytes]) -> Edits:
    return edits(packets={WALK: THREE}, sequence=change)


def _state(change: Callable[[Parts], object], step: Step | None = None, coarse: Maker | None = None) -> Edits:
    """Edits of a case whose last state is changed before anything is made of it."""
    last = replace(step or Step(EAST), base=KEY, edit=change)
    first = replace(THREE[0], levels=last.levels)
    return edits(packets={WALK: (first, last)}, coarse=coarse)


HEADERS: dict[str, Edits] = {
    "packet/header/empty-file": _file(lambda _: b""),
    "packet/header/magic": _set(magic=b"nav1"),
    "packet/header/unknown-flag": _packet(lambda p: setattr(p, "flags", p.flags | 4)),
    "packet/header/unknown-codec": _set(codec=2),
    "packet/header/first-zero-field": _set(zeros=(1, 0)),
    "packet/header/second-zero-field": _set(zeros=(0, 1)),
    "packet/header/key-frame-with-a-cell": _set(0, source=WEST),
    "packet/header/key-frame-with-a-mark": _packet(lambda p: setattr(p, "mark_before", p.mark_after), 0),
    "packet/header/body-cut-off": _file(lambda data: data[:-1]),
    "packet/header/header-cut-off": _file(lambda data: data + data[:47]),
    "packet/header/claims-4-gb": _set(length=lambda _: 2**32 - 1),
    "packet/header/big-endian": _set(length=lambda size: int.from_bytes(struct.pack(">I", size), "little")),
    "packet/header/length-of-the-packet": _set(length=lambda size: size + 48),
}


def _other_map(made: list[Packet]) -> None:
    of_map = bytes(range(8))
    for packet in made:
        packet.map = of_map
        packet.mark_after = mark(of_map, packet.target, packet.exact, packet.after)
    for packet, later in pairwise(made):
        later.mark_before = packet.mark_after


def _result_of_no_cell(packet: Packet) -> None:
    packet.target = len(RING.cells)
    packet.mark_after = mark(packet.map, packet.target, packet.exact, packet.after)


def _swapped(made: list[Packet]) -> None:
    made[1], made[2] = made[2], made[1]


def _skipped(made: list[Packet]) -> None:
    del made[1]


REFERENCES: dict[str, Edits] = {
    "packet/map/other-tileset": edits(packets={WALK: THREE}, packet=_other_map),
    "packet/cells/no-such-result": _packet(_result_of_no_cell),
    "packet/cells/no-such-state": _set(source=len(RING.cells)),
    "packet/cells/no-cell-without-key-frame": _set(source=NO_CELL),
    "packet/before/no-key-frame": edits(packets={WALK: THREE}, packet=lambda made: made.pop(0)),
    "packet/before/other-cell": _set(source=UPPER),
    "packet/before/other-mark": _set(mark_before=bytes(8)),
    "packet/before/later-packet": edits(packets={WALK: THREE}, packet=_swapped),
    "packet/before/packet-lost": edits(packets={WALK: THREE}, packet=_skipped),
}


def _body(change: Callable[[bytes], bytes], steps: tuple[Step, ...] = THREE) -> Edits:
    return _set(body=change, steps=steps)


def _inflated(change: Callable[[bytes], bytes]) -> Edits:
    return _set(inflated=change)


def _length(data: bytes, value: int) -> bytes:
    return struct.pack("<I", value) + data[4:]


STREAMS: dict[str, Edits] = {
    "packet/body/no-body": _body(lambda _: b""),
    "packet/body/no-zlib": _body(lambda data: data[:4] + b"no zlib stream"),
    "packet/body/deflate-without-zlib": _body(lambda data: data[:4] + data[6:-4]),
    "packet/body/preset-dictionary": _body(lambda data: data[:4] + b"\x78\x20\0\0\0\1" + data[6:]),
    "packet/body/stream-cut-off": _body(lambda data: data[:-5]),
    "packet/body/wrong-checksum": _body(lambda data: data[:-1] + bytes([data[-1] ^ 1])),
    "packet/body/bytes-behind-the-stream": _body(lambda data: data + b"\0"),
    "packet/body/inflates-to-more": _body(lambda data: _length(data, len(data) - 20)),
    "packet/body/inflates-to-less": _body(lambda data: _length(data, len(data))),
    "packet/body/claims-256-mb": _body(lambda data: _length(data, 2**28)),
    "packet/body/left-over": _inflated(lambda data: data + bytes(4)),
    "packet/body/lists-cut-off": _inflated(lambda data: data[:-4]),
    "packet/body/nothing-inflated": _inflated(lambda _: b""),
    "packet/body/huge-count": _inflated(lambda data: struct.pack("<I", 2**32 - 1) + data[4:]),
}


def _first(**members: Any) -> Edits:
    """Edits of a case in which members of the first object of a body are set."""
    return _packet(lambda p: [setattr(p.changes[0], name, value) for name, value in members.items()])


def _face(change: Callable[[Triangle], Triangle], number: int = -1) -> Edits:
    """Edits of a case in which corners of a face are others in the body of the key frame."""

    def edit(packet: Packet) -> None:
        enter = packet.changes[0].enter
        face, corners = enter[number]
        enter[number] = (face, change(corners))

    return _packet(edit, 0, THREE[:1])


def _turn_poster(made: list[Packet]) -> None:
    """Turn a face that has the smallest corner twice from the first of them to the second."""
    enter = made[0].changes[POSTER].enter
    face, (first, second, last) = enter[-1]
    if first != second:
        raise ValueError("the face does not begin with its smallest corner twice")
    enter[-1] = (face, (second, last, first))


def _far(face: Triangle) -> Triangle:
    return (face[0], face[1], (2**23, face[2][1], face[2][2]))


def _goes_and_comes(packet: Packet) -> None:
    packet.gone = [WALL]
    packet.changes = [Change(WALL, 0, 0, 1, [], list(packet.before[WALL].faces.items()))]


def _other_flags(packet: Packet) -> None:
    leave = [next(iter(packet.before[BUILDING].faces))]
    packet.changes = [Change(BUILDING, 0, 1, 0, leave, [])]


def _exchanged(packet: Packet) -> None:
    packet.changes.reverse()


def _within(item: int, leave: list[int], enter: list[int]) -> Edits:
    """Edits of a case whose second body changes an object that both states hold at level 0."""

    def edit(packet: Packet) -> None:
        part: Part = packet.before[item]
        corners = next(iter(part.faces.values()))
        packet.changes = [Change(item, 0, part.flags, 0, leave, [(face, corners) for face in enter])]

    return _packet(edit, 1, THREE[:2])


def _anew(leave: list[int], count: int) -> Edits:
    """Edits of a case whose second body sends an object whole, with faces that leave, and so many faces."""

    def edit(packet: Packet) -> None:
        faces = list(packet.before[WALL].faces.items())
        packet.changes = [Change(WALL, 0, 0, 1, leave, faces[:count])]

    return _packet(edit, 1, THREE[:2])


def _going(*items: int) -> Edits:
    return _packet(lambda p: setattr(p, "gone", list(items)))


LISTS: dict[str, Edits] = {
    "packet/body/object-goes-that-is-not-held": _packet(lambda p: setattr(p, "gone", [POSTER]), 1, THREE[:2]),
    "packet/body/objects-that-go-descend": _going(BUILDING, WALL),
    "packet/body/object-goes-twice": _going(WALL, WALL),
    "packet/body/objects-descend": _packet(_exchanged, 0, THREE[:1]),
    "packet/body/object-goes-and-comes": _packet(_goes_and_comes),
    "packet/body/unknown-mode": _first(mode=2),
    "packet/body/mode-of-a-change-for-what-is-not-held": _packet(
        lambda p: setattr(p.changes[0], "mode", 0), 0, THREE[:1]
    ),
    "packet/body/other-level-in-a-change": edits(
        packets={WALK: LEVELS[:2]},
        coarse=two_levels,
        packet=lambda made: setattr(made[1].changes[0], "mode", 0),
    ),
    "packet/body/other-flags-in-a-change": _packet(_other_flags, 1, THREE[:2]),
    "packet/body/unknown-flag-of-an-object": _packet(
        lambda p: setattr(p.changes[0], "flags", 4), 0, THREE[:1]
    ),
    "packet/body/face-leaves-that-is-not-held": _within(WALL, [2], []),
    "packet/body/faces-that-leave-descend": _within(WALL, [1, 0], [2]),
    "packet/body/face-enters-that-is-held": _within(WALL, [], [1]),
    "packet/body/face-leaves-and-enters": _within(WALL, [1], [1]),
    "packet/body/faces-that-enter-descend": _packet(lambda p: p.changes[0].enter.reverse(), 0, THREE[:1]),
    "packet/body/no-face-left": _within(WALL, [0, 1], []),
    "packet/body/nothing-changes": _within(WALL, [], []),
    "packet/body/faces-leave-what-is-sent-anew": _anew([0], 2),
    "packet/body/object-without-a-face": _anew([], 0),
    "packet/body/corner-out-of-reach": _face(_far),
    "packet/body/corners-not-turned": _face(lambda f: (f[1], f[2], f[0])),
    "packet/body/turned-to-another-equal-corner": edits(
        world=with_points(),
        packets={WALK: (Step(EAST, base=KEY, exact=False, kept=(7,)),)},
        packet=_turn_poster,
    ),
}


def _coded(change: Callable[[bytes], bytes]) -> Edits:
    return _set(steps=in_code(THREE), body=change)


def _written(*symbols: tuple[str, int]) -> Edits:
    """Edits of a case whose second body, coded, begins with numbers in blocks of contexts, and then ends."""
    writer = BitWriter()
    for block, value in symbols:
        writer.number(block, value)
    return _set(1, in_code(THREE[:2]), body=lambda _: writer.body())


KEPT = (("ACTION", 0),) * 3
"""Nothing happens to the three objects that are held."""

CODES: dict[str, Edits] = {
    "packet/body/coded-without-a-byte": _coded(lambda _: b""),
    "packet/body/coded-cut-off": _coded(lambda data: data[:-1]),
    "packet/body/coded-left-over": _coded(lambda data: data + b"\0"),
    "packet/body/coded-object-comes-that-is-held": _written(("NEW", 1), ("NEW", GROUND)),
    "packet/body/coded-object-too-large": _written(("NEW", 1), ("NEW", 2**24)),
    "packet/body/coded-unknown-action": _written(("NEW", 0), ("ACTION", 4)),
    "packet/body/coded-more-leave-than-are-held": _written(("NEW", 0), ("ACTION", 1), *KEPT[1:], ("LEFT", 3)),
    "packet/body/coded-level-256": _written(("NEW", 1), ("NEW", POSTER), *KEPT, ("LEVEL", 256)),
    "packet/body/coded-flags-256": _written(("NEW", 1), ("NEW", POSTER), *KEPT, ("LEVEL", 0), ("FLAGS", 256)),
    "packet/body/coded-huge-count": _written(
        ("NEW", 1), ("NEW", POSTER), *KEPT, ("LEVEL", 0), ("FLAGS", 0), ("COUNT", 2**24)
    ),
    "packet/body/coded-object-without-a-face": _written(
        ("NEW", 1), ("NEW", POSTER), *KEPT, ("LEVEL", 0), ("FLAGS", 0), ("COUNT", 0)
    ),
}
"""Coded bodies."""


def _mark_of(change: Callable[[Packet], bytes]) -> Edits:
    return _packet(lambda p: setattr(p, "mark_after", change(p)))


def _at(cell: int) -> Callable[[Packet], bytes]:
    return lambda p: mark(p.map, cell, p.exact, p.after)


def _one_face_less(packet: Packet) -> None:
    packet.changes[-1].enter.pop()


RESULTS: dict[str, Edits] = {
    "packet/after/mark-of-another-cell": _mark_of(_at(SOUTH)),
    "packet/after/mark-of-another-map": _mark_of(lambda p: mark(bytes(8), p.target, p.exact, p.after)),
    "packet/after/mark-of-a-state-that-is-not-exact": _mark_of(
        lambda p: mark(p.map, p.target, False, p.after)
    ),
    "packet/after/bytes-in-reverse": _mark_of(lambda p: p.mark_after[::-1]),
    "packet/after/face-left-out-of-the-body": _packet(_one_face_less, 0, THREE[:1]),
    "packet/after/objects-kept": _packet(lambda p: p.gone.clear(), -1, (Step(EAST, base=KEY), Step(WEST))),
}


def _with_faces(item: int, change: Callable[[dict[int, Triangle]], dict[int, Triangle]]) -> Any:
    """Edit of parts that changes the faces of one."""

    def edit(parts: Parts) -> None:
        parts[item] = replace(parts[item], faces=change(parts[item].faces))

    return edit


def _last_moved(faces: dict[int, Triangle]) -> dict[int, Triangle]:
    number = max(faces)
    a, b, c = faces[number]
    up: Point = (c[0], c[1], c[2] + 1)
    return {**faces, number: (a, b, up)}


def _over(faces: dict[int, Triangle]) -> dict[int, Triangle]:
    return {number: (a, c, b) for number, (a, b, c) in faces.items()}


def _one_more(faces: dict[int, Triangle]) -> dict[int, Triangle]:
    return {**faces, max(faces) + 1: faces[max(faces)]}


def _replacing(item: int, **members: Any) -> Any:
    def edit(parts: Parts) -> None:
        parts[item] = replace(parts[item], **members)

    return edit


def _another_object(parts: Parts) -> None:
    parts[len(RING.objects)] = parts[BUILDING]


def _corners_of_level_0(parts: Parts) -> None:
    parts[BUILDING] = replace(parts[BUILDING], level=1)


GEOMETRY: dict[str, Edits] = {
    "packet/geometry/corner-moved": _state(_with_faces(BUILDING, _last_moved)),
    "packet/geometry/turned-over": _state(_with_faces(BUILDING, _over)),
    "packet/geometry/no-such-face": _state(_with_faces(WALL, _one_more)),
    "packet/geometry/no-such-object": _state(_another_object),
    "packet/geometry/other-flags": _state(_replacing(WALL, flags=1)),
    "packet/geometry/level-without-face-maps": _state(_replacing(WALL, level=1)),
    "packet/geometry/corners-of-another-level": _state(_corners_of_level_0, coarse=one_level),
}


def _dropping(item: int) -> Callable[[Parts], object]:
    return lambda parts: parts.pop(item)


COARSE = Step(EAST, levels={BUILDING: 1})

SETS: dict[str, Edits] = {
    "packet/conservative/face-left-out": _state(lambda parts: without(parts, BUILDING, 0)),
    "packet/conservative/object-left-out": _state(_dropping(POSTER)),
    "packet/conservative/coarse-face-left-out": _state(
        lambda parts: without(parts, BUILDING, 0), COARSE, one_level
    ),
    "packet/conservative/state-of-another-cell": edits(
        packets={WALK: (Step(EAST, base=KEY), Step(WEST))},
        packet=lambda made: [
            setattr(made[1], "target", UPPER),
            setattr(made[1], "mark_after", mark(made[1].map, UPPER, True, made[1].after)),
        ],
    ),
    "packet/exact/face-kept": edits(packets={WALK: (Step(EAST, base=KEY), Step(WEST, kept=(4,)))}),
    "packet/exact/face-of-an-object-kept": _state(
        _with_faces(BUILDING, lambda faces: faces), Step(EAST, kept=(16, 17))
    ),
    "packet/exact/coarse-face-kept": edits(
        packets={WALK: (Step(EAST, base=KEY, levels={BUILDING: 1}, kept=(16, 17)),)}, coarse=one_level
    ),
}

CASES = HEADERS | REFERENCES | STREAMS | LISTS | CODES | RESULTS | GEOMETRY | SETS
