"""The body of a packet: from what a client held to what it holds, in one stream of bits."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
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
from tilesnav_ref.packet.geometry_faces import CONTEXTS, code_faces, new_scratch
from tilesnav_ref.packet.geometry_mesh import LIMIT, new_memory, new_mesh, put_corners, remember_held
from tilesnav_ref.packet.geometry_order import canonical, order_of, places_of
from tilesnav_ref.packet.model import Limits, ObjectFaces, PacketError
from tilesnav_ref.packet.numbers import (
    LARGEST_NUMBER,
    LEAVES_CONTEXTS,
    code_leaving,
    code_places,
)

SAME, CHANGED, GONE, REPLACED = range(4)
"""What becomes of an object that the client holds."""
NEW_OBJECTS, ACTIONS, LEFT_COUNTS, LEVELS, FLAGS, COUNTS = (k * NUMBER_CONTEXTS for k in range(6))
LEAVES = 6 * NUMBER_CONTEXTS
PLACES = LEAVES + LEAVES_CONTEXTS
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
    coder = new_coder(np.frombuffer(data, np.uint8).copy(), True, _probabilities())
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
    entered = sum(change.entered for change in changes)
    known = sum(len(change.kept.faces) for change in changes if change.kept and change.entered)
    memory, scratch = new_memory(entered + known), new_scratch()
    after = []
    for change in changes:
        if change.action == SAME and change.before is not None:
            after.append(change.before)
        elif change.action != GONE:
            after.append(_code_change(coder, change, memory, scratch))
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


def _code_change(coder: Any, change: _Change, memory: Any, scratch: Any) -> ObjectFaces:
    """Code the faces of one object that leave and that enter; returns what is held of it afterwards."""
    kept = change.kept
    faces = kept.faces.astype(np.int64) if kept else np.zeros(0, np.int64)
    corners = kept.corners if kept else np.zeros((0, 3, 3), np.int32)
    target = change.after
    leaves = np.zeros(len(faces), np.int64)
    if target is not None:
        leaves[:] = ~np.isin(faces, target.faces, assume_unique=True)
    code_leaving(coder, LEAVES, change.left, leaves)
    numbers = np.zeros(change.entered, np.int64)
    entering: NDArray[np.int32] = np.zeros((0, 3, 3), np.int32)
    if change.entered:
        coded = np.zeros((change.entered, 3, 3), np.int64)
        source = new_mesh(0)
        if target is not None:
            enters = ~np.isin(target.faces, faces, assume_unique=True)
            source = new_mesh(change.entered)
            put_corners(source, target.corners[enters])
        mesh = new_mesh(len(faces) + change.entered)
        put_corners(mesh, corners)
        remember_held(memory, mesh)
        code_faces(coder, mesh, memory, scratch, (source, coded, numbers))
        _check_coder(coder)
        if target is not None:
            numbers = target.faces[enters].astype(np.int64)[numbers]
        entering, numbers = _code_numbers(coder, faces, corners, coded, numbers)
    stays = leaves == 0
    found = np.concatenate((faces[stays], numbers))
    order = np.argsort(found, kind="stable")
    found = found[order]
    if np.any(np.diff(found) == 0):
        raise PacketError(f"packet body: object {change.number} has a face twice")
    joined = np.concatenate((corners[stays], entering))[order]
    return ObjectFaces(change.number, change.level, change.flags, found.astype(np.uint32), joined)


def _code_numbers(
    coder: Any, faces: Ints, corners: NDArray[np.int32], coded: Ints, numbers: Ints
) -> tuple[NDArray[np.int32], Ints]:
    """Code the numbers of entering faces; returns these faces in the order of space, and their numbers."""
    entering = canonical(coded.astype(np.int32))
    places = places_of(entering)
    order = order_of(entering, places)
    entering, numbers = entering[order], numbers[order]
    merged = np.argsort(np.concatenate((places_of(corners), places[order])), kind="stable")
    held = np.concatenate((faces, np.full(len(entering), -1)))[merged]
    all_numbers = np.concatenate((faces, numbers))[merged]
    code_places(coder, PLACES, held, all_numbers)
    _check_coder(coder)
    return entering, all_numbers[held < 0]
