"""What packets are judged by: the faces of a tileset by object and level, and the sets of its cells."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tilesnav_validator import facemaps, ragged
from tilesnav_validator.packetparts import CornerArray, Part, Parts, turned
from tilesnav_validator.ragged import IntArray
from tilesnav_validator.subject import Subject

POROUS, ONE_SIDED = 1, 2
"""Flags of an object."""


@dataclass(frozen=True)
class Level:
    """The faces of a level, those of an object behind each other.

    Attributes
    ----------
    corners : ndarray of int32, shape (n, 3, 3)
        Grid steps, nav frame; turned to the smallest row of nine numbers.
    offsets : ndarray of int64, shape (objects + 1,)
        First face of each object.
    standing : tuple of ndarray of int64, or None
        For each face of level 0 the faces that stand for it, as offsets and faces; None for level 0, where a
        face stands for itself.
    """

    corners: CornerArray
    offsets: IntArray
    standing: tuple[IntArray, IntArray] | None

    def stand_for(self, faces: IntArray) -> IntArray:
        """Faces of the level that stand for faces of level 0, ascending."""
        if self.standing is None:
            return faces
        offsets, values = self.standing
        return np.unique(values[ragged.take(offsets, faces)[1]])

    def objects(self, faces: IntArray) -> IntArray:
        """Object of each face."""
        return np.searchsorted(self.offsets, faces, side="right") - 1


class Scene:
    """A tileset as packets are judged by it; only after the checks of contents, sets and face maps.

    Parameters
    ----------
    subject : Subject
    """

    def __init__(self, subject: Subject) -> None:
        self.object_count = subject.number("objectCount")
        self.pvs = subject.tables.faces
        faces = subject.faces
        self.object_of = faces.objects
        self.flags = np.zeros(self.object_count, np.int64)
        self.flags[faces.porous_objects] |= POROUS
        self.flags[faces.one_sided_objects] |= ONE_SIDED
        self.levels = {0: Level(turned(faces.grid.astype(np.int32)), self._offsets(faces.objects), None)}
        for number in sorted({int(coarse.content.nav["level"]) for coarse in subject.coarse}):
            self.levels[number] = self._coarse(subject, number)

    def _offsets(self, objects: IntArray) -> IntArray:
        """First face of each object, from the object of each face in ascending order."""
        return np.searchsorted(objects, np.arange(self.object_count + 1)).astype(np.int64)

    def _coarse(self, subject: Subject, number: int) -> Level:
        """A level from the contents with face maps that it has."""
        objects, corners, fine, rows = [], [], [], []
        first = 0
        members = zip(subject.coarse, subject.face_maps, subject.coarse_primitives, strict=True)
        for coarse, found, primitives in members:
            if coarse.content.nav["level"] != number:
                continue
            objects.append(found.objects[facemaps.primitive_of(primitives)])
            corners.append(np.rint(facemaps.corners_of(primitives) / subject.step).astype(np.int64))
            fine.append(found.listed.values)
            rows.append(ragged.rows(found.listed.offsets) + first)
            first += len(objects[-1])
        owner, order = np.concatenate(objects), np.argsort(np.concatenate(objects), kind="stable")
        place = np.empty(len(order), np.int64)
        place[order] = np.arange(len(order))
        listed, row = np.concatenate(fine), place[np.concatenate(rows)]
        by_fine = np.argsort(listed, kind="stable")
        starts = np.searchsorted(listed[by_fine], np.arange(len(self.object_of) + 1)).astype(np.int64)
        return Level(
            turned(np.concatenate(corners).astype(np.int32)[order]),
            self._offsets(owner[order]),
            (starts, row[by_fine]),
        )

    def fault(self, part: Part) -> str:
        """How a held part differs from what the tileset has; empty where it does not."""
        if part.item >= self.object_count:
            return f"object {part.item} of {self.object_count}"
        said = f"object {part.item}, level {part.level}"
        level = self.levels.get(part.level)
        if level is None:
            return f"{said}, which has no face maps"
        if part.flags != self.flags[part.item]:
            return f"{said}, flags {part.flags} instead of {self.flags[part.item]}"
        first, last = level.offsets[part.item : part.item + 2]
        if part.faces[-1] >= last - first:
            return f"{said}, face {part.faces[-1]} of {last - first}"
        wrong = (level.corners[first + part.faces] != part.corners).any(axis=(1, 2))
        if wrong.any():
            index = int(np.argmax(wrong))
            have = level.corners[first + part.faces[index]].tolist()
            return (
                f"{said}, face {part.faces[index]}, corners {part.corners[index].tolist()} instead of {have}"
            )
        return ""

    def missing(self, cell: int, parts: Parts) -> Iterator[str]:
        """What a state lacks of that which can be seen from its cell; its parts must be without fault."""
        for level, seen in self._seen(cell, parts):
            if level < 0:
                yield from (f"object {item} of level 0" for item in np.unique(self.object_of[seen]))
                continue
            wanted = self.levels[level].stand_for(seen)
            yield from self._named(level, np.setdiff1d(wanted, self._rows(level, parts), assume_unique=True))

    def needless(self, cell: int, parts: Parts) -> Iterator[str]:
        """What a state holds of that which cannot be seen from its cell."""
        seen = dict(self._seen(cell, parts))
        for level in sorted({part.level for part in parts.values()}):
            wanted = self.levels[level].stand_for(seen.get(level, np.zeros(0, np.int64)))
            yield from self._named(level, np.setdiff1d(self._rows(level, parts), wanted, assume_unique=True))

    def _seen(self, cell: int, parts: Parts) -> Iterator[tuple[int, IntArray]]:
        """Faces of the set of a cell by the level that their object is held at, -1 for those of no part."""
        faces = self.pvs.row(cell).astype(np.int64)
        held = np.full(self.object_count, -1, np.int64)
        for part in parts.values():
            held[part.item] = part.level
        of_face = held[self.object_of[faces]]
        for level in np.unique(of_face):
            yield int(level), faces[of_face == level]

    def _rows(self, level: int, parts: Parts) -> IntArray:
        """Faces of a level that are held."""
        offsets = self.levels[level].offsets
        mine = [offsets[part.item] + part.faces for part in parts.values() if part.level == level]
        return np.concatenate(mine)

    def _named(self, level: int, rows: IntArray) -> Iterator[str]:
        """Faces of a level by their object and their number in it."""
        owners = self.levels[level].objects(rows)
        for row, item in zip(rows.tolist(), owners.tolist(), strict=True):
            yield f"object {item}, level {level}, face {row - int(self.levels[level].offsets[item])}"
