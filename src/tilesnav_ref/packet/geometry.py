"""The body of a packet: from what a client held to what it holds, in one stream of bits."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.packet.coder import (
    FAILED,
    NUMBER_CONTEXTS,
    READING,
    code_numbers,
    finish,
    is_finished,
    new_coder,
)
from tilesnav_ref.packet.geometry_change import Faces, Room, code_changes
from tilesnav_ref.packet.geometry_faces import CONTEXTS, new_scratch
from tilesnav_ref.packet.geometry_memory import new_memory
from tilesnav_ref.packet.geometry_mesh import LIMIT, new_mesh
from tilesnav_ref.packet.geometry_order import canonical
from tilesnav_ref.packet.model import Limits, ObjectFaces, PacketError
from tilesnav_ref.packet.numbers import LARGEST_NUMBER

SAME, CHANGED, GONE, REPLACED = range(4)
"""What becomes of an object that the client holds."""
NEW_OBJECTS, ACTIONS, LEFT_COUNTS, LEVELS, FLAGS, COUNTS = (k * NUMBER_CONTEXTS for k in range(6))
SPACE = 4096
"""Bytes for a body without faces at first; doubled until the body fits."""

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Change:
    """What becomes of one object."""

    before: ObjectFaces | None
    after: ObjectFaces | None
    """None when reading, and for an object that is gone."""
    action: int
    number: int
    level: int
    flags: int
    left: int
    """Faces that leave."""
    entered: int

    @property
    def kept(self) -> ObjectFaces | None:
        """The faces that the entering ones join, those that leave among them."""
        return self.before if self.action == CHANGED else None


def encode_body(before: Sequence[ObjectFaces], after: Sequence[ObjectFaces]) -> bytes:
    """Encode the way from what a client holds to what it is to hold.

    Parameters
    ----------
    before, after : sequences of ObjectFaces
        Objects ascend. Faces that are in both have the same corners.

    Returns
    -------
    bytes

    Raises
    ------
    PacketError
        When objects or faces do not ascend, a number is 2**24 or more, a coordinate 2**23 or more in
        magnitude, or corners do not start with the least rotation.
    """
    for part in after:
        _check(part)
    _check_objects(after)
    changes = _compare(before, after)
    entering = sum(change.entered for change in changes)
    limits = Limits(faces=entering, objects=len(changes))
    space = SPACE + 16 * entering
    while True:
        coder = new_coder(np.zeros(space, np.uint8), False, _probabilities())
        with suppress(_NoRoomError):
            _code(coder, before, changes, limits)
            _check_coder(coder)
            return finish(coder)
        space *= 2


def decode_body(
    data: bytes, before: Sequence[ObjectFaces], limits: Limits | None = None
) -> tuple[ObjectFaces, ...]:
    """Decode what a client is to hold.

    Parameters
    ----------
    data : bytes
        Of `encode_body`.
    before : sequence of ObjectFaces
        Exactly what was given to `encode_body`; the caller knows that by a digest.
    limits : Limits or None
        What is accepted at most; None for the defaults.

    Raises
    ------
    PacketError
        When the data are not a body for these faces, or go beyond the limits.
    """
    coder = new_coder(np.frombuffer(data, np.uint8), True, _probabilities())
    after = _code(coder, before, None, limits or Limits())
    if not is_finished(coder):
        raise PacketError(f"packet body of {len(data)} bytes: it ends too early, too late, or is damaged")
    return after


def _probabilities() -> Ints:
    return np.full(CONTEXTS, 1 << 15, np.int64)


def _check(part: ObjectFaces) -> None:
    """Refuse what cannot be encoded."""
    where = f"object {part.object}"
    if not 0 <= part.object <= LARGEST_NUMBER or not 0 <= part.level < 256 or not 0 <= part.flags < 256:
        raise PacketError(
            f"{where}, level {part.level}, flags {part.flags}: allowed: 0 to {LARGEST_NUMBER}, 255, 255"
        )
    faces = part.faces.astype(np.int64)
    if part.corners.shape != (len(faces), 3, 3):
        raise PacketError(f"{where}: corners of shape {part.corners.shape}; allowed: {(len(faces), 3, 3)}")
    if len(faces) and (np.any(np.diff(faces) <= 0) or faces[-1] > LARGEST_NUMBER):
        raise PacketError(f"{where}: face numbers; allowed: ascending, at most {LARGEST_NUMBER}")
    if len(faces) and int(np.abs(part.corners.astype(np.int64)).max()) >= LIMIT:
        raise PacketError(f"{where}: coordinates; allowed: magnitudes below {LIMIT}")
    if not np.array_equal(canonical(part.corners), part.corners):
        raise PacketError(f"{where}: corners of a face; allowed: the least of its rotations")


def _check_objects(parts: Sequence[ObjectFaces]) -> None:
    numbers = [part.object for part in parts]
    if any(b <= a for a, b in itertools.pairwise(numbers)):
        raise PacketError(f"objects {numbers}; allowed: ascending")


def _compare(before: Sequence[ObjectFaces], after: Sequence[ObjectFaces]) -> list[_Change]:
    """Changes of all objects, ascending."""
    old = {part.object: part for part in before}
    new = {part.object: part for part in after}
    changes = []
    for number in sorted(old.keys() | new.keys()):
        a, b = old.get(number), new.get(number)
        if b is None:
            changes.append(_Change(a, None, GONE, number, 0, 0, 0, 0))
        elif a is None or (a.level, a.flags) != (b.level, b.flags):
            changes.append(_Change(a, b, REPLACED, number, b.level, b.flags, 0, len(b.faces)))
        else:
            _, old_rows, new_rows = np.intersect1d(a.faces, b.faces, assume_unique=True, return_indices=True)
            if not np.array_equal(a.corners[old_rows], b.corners[new_rows]):
                raise PacketError(f"object {number}: a face has other corners afterwards")
            left, entered = len(a.faces) - len(old_rows), len(b.faces) - len(new_rows)
            action = CHANGED if left or entered else SAME
            changes.append(_Change(a, b, action, number, a.level, a.flags, left, entered))
    return changes


def _code(
    coder: Any, before: Sequence[ObjectFaces], changes: list[_Change] | None, limits: Limits
) -> tuple[ObjectFaces, ...]:
    """Write changes, or read them where they are None; returns what is held afterwards."""
    changes = _code_objects(coder, before, changes, limits)
    moving = [change for change in changes if change.action in (CHANGED, REPLACED)]
    moved = iter(_code_moving(coder, moving))
    after = []
    for change in changes:
        if change.action == SAME and change.before is not None:
            after.append(change.before)
        elif change.action != GONE:
            after.append(next(moved))
    return tuple(after)


def _code_objects(
    coder: Any, before: Sequence[ObjectFaces], changes: list[_Change] | None, limits: Limits
) -> list[_Change]:
    """Code which objects there are, what becomes of them and how many faces move."""
    todo = changes or []
    fresh = [change.number for change in todo if change.before is None]
    count = int(_numbers(coder, NEW_OBJECTS, [len(fresh)], 1)[0])
    if count + len(before) > limits.objects:
        raise PacketError(f"packet body: {count} more objects; allowed: {limits.objects} in all")
    gaps = _numbers(coder, NEW_OBJECTS, np.diff(fresh, prepend=-1) - 1, count)
    actions = _numbers(coder, ACTIONS, [c.action for c in todo if c.before is not None], len(before))
    rows = _rows(before, (np.cumsum(gaps + 1) - 1).tolist(), actions.tolist())
    changed = np.array([action == CHANGED for _, _, action in rows], bool)
    replaced = np.array([action == REPLACED for _, _, action in rows], bool)
    columns = []
    for name, first, among in (
        ("left", LEFT_COUNTS, changed),
        ("level", LEVELS, replaced),
        ("flags", FLAGS, replaced),
        ("entered", COUNTS, changed | replaced),
    ):
        given = [getattr(change, name) for change, one in zip(todo, among, strict=False) if one]
        column = np.zeros(len(rows), np.int64)
        column[among] = _numbers(coder, first, given, int(among.sum()))
        columns.append(column.tolist())
    if sum(columns[3]) > limits.faces:
        raise PacketError(f"packet body: {sum(columns[3])} faces enter; allowed: {limits.faces}")
    return changes or [_change(*row) for row in zip(rows, *columns, strict=True)]


def _rows(
    before: Sequence[ObjectFaces], fresh: list[int], actions: list[int]
) -> list[tuple[int, ObjectFaces | None, int]]:
    """Number, held faces and action of every object, ascending; for those not held None and REPLACED."""
    rows: dict[int, tuple[int, ObjectFaces | None, int]] = {
        number: (number, None, REPLACED) for number in fresh
    }
    if any(part.object in rows for part in before) or max(fresh, default=0) > LARGEST_NUMBER:
        raise PacketError("packet body: a new object is held already, or its number is too large")
    if max(actions, default=0) > REPLACED:
        raise PacketError(f"packet body: action {max(actions)}; allowed: 0 to {REPLACED}")
    rows.update({part.object: (part.object, part, one) for part, one in zip(before, actions, strict=True)})
    return [rows[number] for number in sorted(rows)]


def _change(
    row: tuple[int, ObjectFaces | None, int], left: int, level: int, flags: int, entered: int
) -> _Change:
    """Return a change that was read."""
    number, part, action = row
    if part is not None and action == CHANGED:
        level, flags = part.level, part.flags
    if max(level, flags) > 255 or (part is not None and left > len(part.faces)):
        raise PacketError(f"packet body: object {number}, level {level}, flags {flags}, {left} faces leave")
    return _Change(part, None, action, number, level, flags, left, entered)


def _numbers(coder: Any, first: int, values: Any, count: int) -> Ints:
    """Code `count` numbers; `values` are those to be written, or whatever when reading."""
    numbers = np.zeros(count, np.int64)
    if not coder[0][READING]:
        numbers[:] = values
    code_numbers(coder, first, numbers)
    _check_coder(coder)
    return numbers


class _NoRoomError(Exception):
    """The body does not fit its space."""


def _check_coder(coder: Any) -> None:
    if not coder[0][FAILED]:
        return
    if coder[0][READING]:
        raise PacketError("packet body: it ends too early, or is damaged")
    raise _NoRoomError


def _faces_of(parts: Iterable[ObjectFaces | None]) -> Faces:
    """Faces of parts, one behind the other."""
    there = [part for part in parts if part is not None]
    faces = np.concatenate([np.zeros(0, np.uint32), *[part.faces for part in there]])
    corners = np.concatenate([np.zeros((0, 3, 3), np.int32), *[part.corners for part in there]])
    return Faces(faces.astype(np.int64), corners.astype(np.int32, copy=False))


def _new_faces(count: int) -> Faces:
    return Faces(np.empty(count, np.int64), np.empty((count, 3, 3), np.int32))


def _code_moving(coder: Any, changes: list[_Change]) -> list[ObjectFaces]:
    """Code the faces of objects that change; returns what is held of these afterwards."""
    counts = np.zeros((len(changes), 3), np.int64)
    for row, change in zip(counts, changes, strict=True):
        row[:] = len(change.kept.faces) if change.kept else 0, change.left, change.entered
    held = _faces_of(change.kept for change in changes)
    entering, leaves = _moving(coder, changes, counts, len(held.numbers))
    lengths = counts[:, 0] - counts[:, 1] + counts[:, 2]
    after = _new_faces(int(lengths.sum()))
    done = code_changes(coder, counts, (held, entering, after), leaves, _room(coder, counts))
    _check_coder(coder)
    if done < len(changes):
        raise PacketError(f"packet body: object {changes[done].number} has a face twice")
    ends = np.cumsum(lengths).tolist()
    numbers = after.numbers.astype(np.uint32)
    return [  # copies, so that no object holds the faces of all
        ObjectFaces(c.number, c.level, c.flags, numbers[begin:end].copy(), after.corners[begin:end].copy())
        for c, begin, end in zip(changes, [0, *ends], ends, strict=False)
    ]


def _moving(
    coder: Any, changes: list[_Change], counts: Ints, held: int
) -> tuple[Faces, NDArray[np.uint8]]:
    """Faces that enter, and which held ones leave; with room for these when reading."""
    if coder[0][READING]:
        return _new_faces(int(counts[:, 2].sum())), np.zeros(held, np.uint8)
    entering: list[ObjectFaces] = []
    leaves = [np.zeros(0, np.uint8)]
    for change in changes:
        target, kept = change.after, change.kept
        if target is None:
            continue
        if kept is None:
            entering.append(target)
            continue
        leaves.append((~np.isin(kept.faces, target.faces, assume_unique=True)).astype(np.uint8))
        enters = ~np.isin(target.faces, kept.faces, assume_unique=True)
        entering.append(replace(target, faces=target.faces[enters], corners=target.corners[enters]))
    return _faces_of(entering), np.concatenate(leaves)


def _room(coder: Any, counts: Ints) -> Room:
    growing = counts[counts[:, 2] > 0]
    known, entering = growing[:, 0] + growing[:, 2], growing[:, 2]
    largest = 0 if coder[0][READING] else int(entering.max(initial=0))
    return Room(
        new_mesh(int(known.max(initial=0))), new_mesh(largest), new_memory(int(known.sum())), new_scratch()
    )
