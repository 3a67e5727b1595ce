"""Packets: states of a vehicle with geometry, and sequences that lead from one to the next.

Everything is done in Python integers, face by face, as the specification says it.
"""

from __future__ import annotations

import hashlib
import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from casebuilder.coarse import Coarse
from casebuilder.packet_coder import coded
from casebuilder.state import State as CellState
from casebuilder.world import Point, Triangle, World

KEY = -1
"""Base of a key frame."""
NO_CELL = 2**32 - 1
PLAIN, CODED = 0, 1


@dataclass(frozen=True)
class Part:
    """What is held of an object."""

    level: int
    flags: int
    faces: dict[int, Triangle]
    """Corners, turned to the smallest row, by the index of the face, ascending."""


Parts = dict[int, Part]
"""Parts by object, ascending."""


@dataclass(frozen=True)
class Step:
    """A state that a packet of a sequence leads to."""

    cell: int
    base: int | None = None
    """Number of the packet whose result it applies to: the one before where None, nothing where KEY."""
    codec: int = PLAIN
    exact: bool = True
    levels: dict[int, int] = field(default_factory=dict)
    """Levels of objects, where they are not 0."""
    kept: tuple[int, ...] = ()
    """Faces of level 0 that are held without need, all of objects at level 0."""
    anew: tuple[int, ...] = ()
    """Objects that are sent whole although a change would do."""
    edit: Callable[[Parts], object] | None = None
    """Changes the parts before mark and body are made of them."""


Walks = dict[str, tuple[Step, ...]]
"""Sequences by the name of their file."""


@dataclass
class Change:
    """An object of a body that changes or comes."""

    item: int
    level: int
    flags: int
    mode: int
    leave: list[int]
    enter: list[tuple[int, Triangle]]

    def layout(self) -> bytes:
        """The bytes of it."""
        corners = [v for _, face in self.enter for corner in face for v in corner]
        return b"".join(
            (
                struct.pack("<IBBH", self.item, self.level, self.flags, self.mode),
                numbers(self.leave),
                numbers([face for face, _ in self.enter]),
                struct.pack(f"<{len(corners)}i", *corners),
            )
        )


def stored(data: bytes) -> bytes:
    """A zlib stream of less than 2^16 bytes as they are, so that no library decides about it."""
    block = struct.pack("<BHH", 1, len(data), len(data) ^ 0xFFFF) + data
    return b"\x78\x01" + block + struct.pack(">I", zlib.adler32(data))


def fixed_codes(data: bytes) -> bytes:
    """A zlib stream in the fixed codes of RFC 1951, without matches."""
    bits = [1, 1, 0]
    for value in data:
        code, width = (0x30 + value, 8) if value < 144 else (0x190 + value - 144, 9)
        bits += [code >> (width - 1 - place) & 1 for place in range(width)]
    bits += [0] * 7
    packed = sum(bit << place for place, bit in enumerate(bits))
    return b"\x78\x01" + packed.to_bytes(-(-len(bits) // 8), "little") + struct.pack(">I", zlib.adler32(data))


@dataclass
class Packet:
    """A packet before it is laid out; every member may be changed by then."""

    flags: int
    codec: int
    map: bytes
    source: int
    target: int
    mark_before: bytes
    mark_after: bytes
    gone: list[int]
    changes: list[Change]
    before: Parts
    after: Parts
    magic: bytes = b"vep1"
    zeros: tuple[int, int] = (0, 0)
    inflated: Callable[[bytes], bytes] | None = None
    """Changes the bytes of a plain body before they are deflated."""
    deflate: Callable[[bytes], bytes] = stored
    """Makes the stream of a plain body."""
    body: Callable[[bytes], bytes] | None = None
    """Changes the bytes of the body."""
    length: Callable[[int], int] | None = None
    """Changes the length of the body that the header states."""

    @property
    def exact(self) -> bool:
        """Whether the state that results is said to be exact."""
        return bool(self.flags & 2)

    def layout(self) -> bytes:
        """The bytes of the packet."""
        body = coded(self.before, self.after) if self.codec == CODED else self._plain()
        if self.body:
            body = self.body(body)
        length = self.length(len(body)) if self.length else len(body)
        head = struct.pack("<4sBBH8s", self.magic, self.flags, self.codec, self.zeros[0], self.map)
        states = struct.pack("<II8s8s", self.source, self.target, self.mark_before, self.mark_after)
        return head + states + struct.pack("<II", length, self.zeros[1]) + body

    def _plain(self) -> bytes:
        changes = b"".join(change.layout() for change in self.changes)
        data = numbers(self.gone) + struct.pack("<I", len(self.changes)) + changes
        if self.inflated:
            data = self.inflated(data)
        return struct.pack("<I", len(data)) + self.deflate(data)


def numbers(values: list[int]) -> bytes:
    """How many numbers there are, and these."""
    return struct.pack(f"<I{len(values)}I", len(values), *values)


def mark(of_map: bytes, cell: int, exact: bool, parts: Parts) -> bytes:
    """Mark of a state."""
    text = of_map + struct.pack("<III", cell, exact, len(parts))
    for item, part in parts.items():
        corners = [v for face in part.faces.values() for corner in face for v in corner]
        text += struct.pack("<IBB", item, part.level, part.flags) + numbers(list(part.faces))
        text += struct.pack(f"<{len(corners)}i", *corners)
    return hashlib.sha256(text).digest()[:8]


def smallest(face: Triangle) -> Triangle:
    """A face turned until the row of its nine numbers is the smallest."""
    a, b, c = face
    return min((a, b, c), (b, c, a), (c, a, b))


def _raised(face: Triangle, rise: int) -> Triangle:
    def up(point: Point) -> Point:
        return (point[0], point[1], point[2] + rise)

    a, b, c = face
    return (up(a), up(b), up(c))


class Scene:
    """What a client may hold of a world."""

    def __init__(self, world: World, states: list[CellState], coarse: list[Coarse]) -> None:
        self.world, self.states, self.coarse = world, states, coarse

    def standing(self, item: int, level: int) -> list[tuple[Triangle, set[int]]]:
        """The faces of an object at a level, each with the faces of level 0 that it stands for."""
        triangles, owner = self.world.faces, self.world.face_object
        if level == 0:
            return [(triangles[f], {f}) for f in range(len(owner)) if owner[f] == item]
        content = next(c for c in self.coarse if c.level == level and item in c.objects)
        own = [f for f in range(len(owner)) if owner[f] in content.objects]
        pairs = zip(own, content.lists, strict=True)
        return [(_raised(triangles[f], content.rise), set(of)) for f, of in pairs if owner[f] == item]

    def part(self, item: int, level: int, seen: set[int]) -> Part:
        """The faces of an object at a level that stand for some of level 0."""
        member = self.world.objects[item]
        faces = enumerate(self.standing(item, level))
        chosen = {number: smallest(face) for number, (face, of) in faces if of & seen}
        return Part(level, member.porous + 2 * member.one_sided, chosen)

    def parts(self, step: Step) -> Parts:
        """What is held in the cell of a step."""
        seen = {*self.states[step.cell].faces, *step.kept}
        items = sorted({self.world.face_object[face] for face in seen})
        parts = {item: self.part(item, step.levels.get(item, 0), seen) for item in items}
        if step.edit:
            step.edit(parts)
        return parts


def changes_between(before: Parts, after: Parts, anew: tuple[int, ...]) -> list[Change]:
    """Objects that change or come."""
    found = []
    for item, part in after.items():
        old = before.get(item)
        if old is None or old.level != part.level or item in anew:
            found.append(Change(item, part.level, part.flags, 1, [], list(part.faces.items())))
            continue
        leave = [face for face in old.faces if face not in part.faces]
        enter = [(face, corners) for face, corners in part.faces.items() if face not in old.faces]
        if leave or enter:
            found.append(Change(item, part.level, part.flags, 0, leave, enter))
    return found


def packets(scene: Scene, of_map: bytes, steps: tuple[Step, ...]) -> list[Packet]:
    """The packets of a sequence."""
    made: list[Packet] = []
    for number, step in enumerate(steps):
        base = number - 1 if step.base is None else step.base
        before = {} if base == KEY else made[base].after
        after = scene.parts(step)
        made.append(
            Packet(
                (base == KEY) + 2 * step.exact,
                step.codec,
                of_map,
                NO_CELL if base == KEY else steps[base].cell,
                step.cell,
                bytes(8) if base == KEY else made[base].mark_after,
                mark(of_map, step.cell, step.exact, after),
                [item for item in before if item not in after],
                changes_between(before, after, step.anew),
                before,
                after,
            )
        )
    return made


def without(parts: Parts, item: int, number: int) -> None:
    """Drop a face from a part, by its place there."""
    faces = dict(parts[item].faces)
    del faces[list(faces)[number]]
    parts[item] = replace(parts[item], faces=faces)
