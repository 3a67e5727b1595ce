"""The faces of objects that change: which leave, which enter, and what is held afterwards."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tilesnav_ref.kernels import kernel, plain_inner_kernel, plain_kernel
from tilesnav_ref.packet.coder import FAILED, NUMBER_CONTEXTS, READING
from tilesnav_ref.packet.geometry_faces import HEAD, code_faces
from tilesnav_ref.packet.geometry_memory import remember_held
from tilesnav_ref.packet.geometry_mesh import put_corners
from tilesnav_ref.packet.geometry_order import curve_places, put_in_order, turn_faces
from tilesnav_ref.packet.numbers import LEAVES_CONTEXTS, code_leaving, code_places

LEAVES = 6 * NUMBER_CONTEXTS
PLACES = LEAVES + LEAVES_CONTEXTS


class Faces(NamedTuple):
    """Faces of one object after the other."""

    numbers: Any
    """(F,) int64 ascending within an object."""
    corners: Any
    """(F, 3, 3) int32."""


class Room(NamedTuple):
    """What kernels work in."""

    mesh: Any
    """Of the object that is at hand, with room for the largest one."""
    source: Any
    """The same for faces that are to be written."""
    memory: Any
    """Of all objects."""
    scratch: Any


@kernel
def code_entering(coder: Any, held: Any, entering: Any, room: Any) -> Any:
    """Code the faces of an object that enter; they are replaced by what was coded, by ascending number.

    Parameters
    ----------
    coder : tuple
    held, entering : Faces
    room : Room
    """
    mesh, source, memory, scratch = room
    count = len(entering.numbers)
    put_corners(mesh, held.corners, len(held.numbers) + count)
    remember_held(memory, mesh)
    if not coder[0][READING]:
        put_corners(source, entering.corners, count)
    coded = np.empty((count, 3, 3), np.int32)
    rows = np.empty(count, np.int64)
    sent, stack = np.zeros(count + 1, np.bool_), np.zeros(3 * count + HEAD, np.int64)
    code_faces(coder, mesh, memory, scratch, (source, coded, rows, sent, stack))
    if coder[0][FAILED]:
        return
    numbers = np.zeros(count, np.int64)
    if not coder[0][READING]:
        for i in range(count):
            numbers[i] = entering.numbers[rows[i]]
    code_numbers_of(coder, held, entering, Faces(numbers, coded))


@kernel
def code_numbers_of(coder: Any, held: Any, entering: Any, coded: Any) -> Any:
    """Code the numbers of faces; `entering` gets these by ascending number."""
    count = len(coded.numbers)
    turn_faces(coded.corners)
    places, order = np.empty(count, np.int64), np.empty(count, np.int64)
    curve_places(coded.corners, places)
    put_in_order(places, coded.corners, order)
    held_places, held_order = np.empty(len(held.numbers), np.int64), np.empty(len(held.numbers), np.int64)
    curve_places(held.corners, held_places)
    put_in_order(held_places, held.corners[:0], held_order)
    sorted_numbers, sorted_places = np.empty(count, np.int64), np.empty(count, np.int64)
    for i in range(count):
        sorted_numbers[i] = coded.numbers[order[i]]
        sorted_places[i] = places[order[i]]
    code_places(coder, PLACES, (held.numbers, held_places, held_order), (sorted_numbers, sorted_places))
    if coder[0][FAILED]:
        return
    by_number = np.empty(count, np.int64)
    put_in_order(sorted_numbers, held.corners[:0], by_number)
    for i in range(count):
        k = by_number[i]
        entering.numbers[i] = sorted_numbers[k]
        entering.corners[i] = coded.corners[order[k]]


@plain_inner_kernel
def copy_face(target: Any, i: Any, source: Any, j: Any) -> Any:
    """Copy a face with its number."""
    target.numbers[i] = source.numbers[j]
    for corner in range(3):
        for axis in range(3):
            target.corners[i, corner, axis] = source.corners[j, corner, axis]


@plain_kernel
def join(held: Any, leaves: Any, entering: Any, after: Any) -> Any:
    """Merge held faces that stay and those that enter, by number; returns whether no number comes twice."""
    i, j, last = 0, 0, np.int64(-1)
    for k in range(len(after.numbers)):
        while i < len(leaves) and leaves[i]:
            i += 1
        if j == len(entering.numbers) or (i < len(leaves) and held.numbers[i] <= entering.numbers[j]):
            copy_face(after, k, held, i)
            i += 1
        else:
            copy_face(after, k, entering, j)
            j += 1
        if after.numbers[k] == last:
            return False
        last = after.numbers[k]
    return True


@kernel
def part_of(faces: Any, begin: Any, end: Any) -> Any:
    """Faces of one object."""
    return Faces(faces.numbers[begin:end], faces.corners[begin:end])


@kernel
def code_changes(coder: Any, counts: Any, faces: Any, leaves: Any, room: Any) -> Any:
    """Code what happens to the faces of objects.

    Parameters
    ----------
    coder : tuple
    counts : (M, 3) int64
        Of each object: faces held, how many of these leave, how many enter.
    faces : tuple of three Faces
        Held; entering, which are filled when reading; held afterwards, which are filled.
    leaves : (H,) uint8
        1 for each held face that leaves, else 0; filled when reading.
    room : Room

    Returns
    -------
    int
        M; or the first object with a face twice, or with which the coder failed.
    """
    held, entering, after = faces
    h, e, a = 0, 0, 0
    for m in range(len(counts)):
        had, left, entered = counts[m]
        kept = part_of(held, h, h + had)
        new = part_of(entering, e, e + entered)
        code_leaving(coder, LEAVES, left, leaves[h : h + had])
        if entered:
            code_entering(coder, kept, new, room)
        held_then = had - left + entered
        if coder[0][FAILED] or not join(kept, leaves[h : h + had], new, part_of(after, a, a + held_then)):
            return m
        h += had
        e += entered
        a += held_then
    return len(counts)
