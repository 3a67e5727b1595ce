"""A small world that a sender delivers from: sets of faces by cell, levels by rule; no files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from packet_fixture import MAP, part

from tilesnav_ref.packet.model import ObjectFaces
from tilesnav_ref.packet.state import HeldState
from tilesnav_ref.stream.policy import LevelPolicy

FACES = 8
"""Faces of every object at level 0; face f is stood for by f // 2 at level 1 and by f // 4 at level 3."""
COARSER = {0: 1, 1: 2, 3: 4}
"""Faces of level 0 behind a face, by level."""


@dataclass(frozen=True)
class _Level:
    level: int


@dataclass(frozen=True)
class Wanted(LevelPolicy):
    """Takes the level that the code of an object is."""

    def choose(self, objects: Any, codes: Any, levels: Sequence[Any], scale: Any) -> Any:  # noqa: ARG002
        return np.array(codes, np.int64)


@dataclass(frozen=True)
class World:
    """Faces that each cell lists, and the level wanted of each object there."""

    listed: Mapping[int, Mapping[int, frozenset[int]]]
    """Faces of level 0, by cell and object; none is empty."""
    places: Mapping[tuple[int, int], int] = field(default_factory=dict)
    """0, 1 or 2 by cell and object, for the levels 0, 1 and 3."""
    map_name: bytes = MAP

    def held(self, cell: int, policy: LevelPolicy) -> tuple[ObjectFaces, ...]:
        objects = sorted(self.listed[cell])
        codes = [self.places.get((cell, number), 0) for number in objects]
        levels = [_Level(1), _Level(3)]
        chosen = policy.choose(np.array(objects), np.array(codes), levels, None)  # type: ignore[arg-type]
        parts = []
        for number, place in zip(objects, chosen.tolist(), strict=True):
            level = (0, 1, 3)[place]
            faces = {face // COARSER[level] for face in self.listed[cell][number]}
            parts.append(part(number, faces, level, number % 4))
        return tuple(parts)

    def lacks(self, state: HeldState) -> list[str]:
        """What a state lacks to be conservative, by the words of the specification; nothing where it is."""
        held = {one.object: one for one in state.parts}
        missing = []
        for number, faces in self.listed[state.cell].items():
            if number not in held:
                missing.append(f"object {number}")
                continue
            one = held[number]
            for coarse in range(FACES):
                stands_for = range(coarse * COARSER[one.level], (coarse + 1) * COARSER[one.level])
                if faces & set(stands_for) and coarse not in one.faces.tolist():
                    missing.append(f"face {coarse} of object {number} at level {one.level}")
        return missing

    def surplus(self, state: HeldState) -> int:
        """Faces of a state that its cell does not call for at the levels held."""
        count = 0
        for one in state.parts:
            listed = self.listed[state.cell].get(one.object, frozenset())
            called = {face // COARSER[one.level] for face in listed}
            count += len(set(one.faces.tolist()) - called)
        return count
