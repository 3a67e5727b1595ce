"""What a vehicle has to hold in a cell, with its geometry."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.packet.model import ObjectFaces
from tilesnav_ref.packet.state import NAME_BYTES
from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.levels import LevelFaces
from tilesnav_ref.stream.policy import LevelPolicy
from tilesnav_ref.stream.reader import NavTileset

POROUS, ONE_SIDED = 1, 2
"""Bits of the flags of an object."""


@dataclass(frozen=True)
class Delivery:
    """Delivers the faces of a tileset, cell by cell; contents and face maps are read once."""

    tileset: NavTileset

    @cached_property
    def map_name(self) -> bytes:
        """First 8 bytes of the SHA-256 of the entry tileset file, by which packets name the map."""
        return hashlib.sha256(self.tileset.path.read_bytes()).digest()[:NAME_BYTES]

    def held(self, cell: int, policy: LevelPolicy) -> tuple[ObjectFaces, ...]:
        """Return the faces that a vehicle in a cell has to hold.

        Parameters
        ----------
        cell : int
            Its number.
        policy : LevelPolicy
            Which level is taken of each object.

        Returns
        -------
        tuple of ObjectFaces
            One for each object with a face in the PVS of the cell, ascending. Of level 0 it has the object's
            faces in the PVS, of a coarser level the faces that stand for one of these.

        Raises
        ------
        IndexError
            When there is no such cell.
        TilesetError
            When a content or a face map is not sound, or the cell lists other objects than its faces have.

        Notes
        -----
        Every return from a visible point of an object lies within the error of the level, for this object, of
        a face that is held; of level 0 it lies in it.
        """
        tileset = self.tileset
        state = tileset.state(cell)
        levels = () if policy.name == "fine" else tileset.levels
        chosen = policy.choose(state.objects, state.codes, levels, tileset.scale)
        objects = state.objects.astype(np.int64)
        counts = self._counts(cell, state.faces, objects)
        held: dict[int, ObjectFaces] = {}
        for place in np.unique(chosen).tolist():
            taken = chosen == place
            fine = state.faces[np.repeat(taken, counts)].astype(np.int64)
            held.update(self._of_level(place, objects[taken], fine))
        return tuple(held[number] for number in sorted(held))

    def _counts(self, cell: int, faces: NDArray[np.uint32], objects: NDArray[np.int64]) -> NDArray[np.int64]:
        """Number of faces of every object in a set; TilesetError where objects and faces do not match."""
        offsets = self.tileset.object_offsets
        counts = np.searchsorted(faces, offsets[objects + 1]) - np.searchsorted(faces, offsets[objects])
        if counts.sum() != len(faces) or not counts.all():
            found = f"{len(objects)} objects that do not match the faces of cell {cell}"
            allowed = "the objects with a face in the set of the cell"
            raise TilesetError(str(self.tileset.path), "lod.objects", found, allowed)
        return np.asarray(counts, dtype=np.int64)

    def _of_level(
        self, place: int, objects: NDArray[np.int64], fine: NDArray[np.int64]
    ) -> dict[int, ObjectFaces]:
        """Take the faces of a level that stand for faces of level 0 of some objects, both ascending."""
        number, geometry, faces = 0, self.tileset.finest, fine
        if place:
            level = self.tileset.levels[place - 1]
            number, geometry = level.level, level.geometry
            faces = np.unique(level.standing.take(fine).values)
        return dict(zip(objects.tolist(), self._parts(number, geometry, objects, faces), strict=True))

    def _parts(
        self, number: int, geometry: LevelFaces, objects: NDArray[np.int64], faces: NDArray[np.int64]
    ) -> list[ObjectFaces]:
        firsts = geometry.offsets[objects]
        bounds = np.append(np.searchsorted(faces, firsts), len(faces)).tolist()
        counts = np.diff(bounds)
        local = (faces - np.repeat(firsts, counts)).astype(np.uint32)
        corners = geometry.corners[faces]
        parts = []
        for i, one in enumerate(objects.tolist()):
            part = slice(bounds[i], bounds[i + 1])
            parts.append(ObjectFaces(one, number, int(self._flags[one]), local[part], corners[part]))
        return parts

    @cached_property
    def _flags(self) -> NDArray[np.int64]:
        flags = np.zeros(self.tileset.object_count, np.int64)
        flags[self.tileset.porous_objects] |= POROUS
        flags[self.tileset.one_sided_objects] |= ONE_SIDED
        return flags
