"""The sender's side: the next packet to a cell, from the state that the vehicle says it holds."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.packet.change import make_packet
from tilesnav_ref.packet.model import Limits
from tilesnav_ref.packet.state import HeldState, Parts, check_parts, face_count
from tilesnav_ref.stream.levels import Level, LevelScale
from tilesnav_ref.stream.policy import LevelPolicy
from tilesnav_ref.stream.retention import choose_finer, retained

LIMITS = Limits(faces=1 << 22, objects=1 << 22)
"""What a held state has at most, by the specification."""
REMEMBERED = 64
"""States that a sender remembers for a vehicle that has not said which one it holds; the oldest go first."""


class Delivers(Protocol):
    """What a sender asks of a tileset."""

    @property
    def map_name(self) -> bytes:
        """First 8 bytes of the SHA-256 of the entry tileset file."""

    def held(self, cell: int, policy: LevelPolicy) -> Parts:
        """What a vehicle in a cell has to hold."""


@dataclass(frozen=True)
class KeptLevels(LevelPolicy):
    """A policy with the levels of some objects laid down."""

    base: LevelPolicy = field(default_factory=LevelPolicy)
    kept: Mapping[int, int] = field(default_factory=dict)
    """Level of each of these objects."""

    def choose(
        self,
        objects: NDArray[np.uint32],
        codes: NDArray[np.uint8],
        levels: Sequence[Level],
        scale: LevelScale,
    ) -> NDArray[np.int64]:
        """Choose as the other policy does, except for the objects whose level is laid down."""
        chosen = self.base.choose(objects, codes, levels, scale)
        places = {0: 0, **{level.level: place for place, level in enumerate(levels, start=1)}}
        for row, number in enumerate(objects.tolist()):
            if number in self.kept:
                chosen[row] = places[self.kept[number]]
        return chosen


@dataclass(frozen=True)
class _Sent:
    """A state that the vehicle may hold."""

    state: HeldState
    last_needed: Mapping[int, int]
    """Step in which each of its objects was last called for."""
    step: int


class Sender:
    """Makes packets for one vehicle.

    Parameters
    ----------
    delivery : Delivers
        What cells call for.
    policy : LevelPolicy
        Which level of an object is wanted in a cell.
    retain : int, optional
        Faces that the vehicle may hold beyond what a cell calls for at the levels wanted, so that they need
        not be sent again. With 0, the default, it holds exactly what the cell calls for.

    Notes
    -----
    Each packet is for the state that the vehicle has last said it holds, by `acknowledge`; until then it is a
    key frame. What is sent is the smaller of a key frame and the change from that state, so no change is
    larger than the key frame that it saves.
    """

    def __init__(self, delivery: Delivers, policy: LevelPolicy, retain: int = 0) -> None:
        if retain < 0:
            raise ValueError(f"retain: found {retain}; allowed: 0 or more faces")
        self._delivery = delivery
        self._policy = policy
        self._retain = retain
        self._acknowledged: _Sent | None = None
        self._sent: OrderedDict[tuple[int, bytes], _Sent] = OrderedDict()

    @property
    def acknowledged(self) -> HeldState | None:
        """What the vehicle holds as far as the sender knows."""
        return None if self._acknowledged is None else self._acknowledged.state

    def acknowledge(self, holds: tuple[int, bytes] | None) -> bool:
        """Take note of what the vehicle says it holds.

        Parameters
        ----------
        holds : (cell, mark) or None
            Cell and mark of its state; None where it holds nothing.

        Returns
        -------
        bool
            Whether the sender knows the state. Where it does not, the next packet is a key frame.
        """
        known = self._acknowledged
        if known is None or holds != (known.state.cell, known.state.mark):
            self._acknowledged = None if holds is None else self._sent.get(holds)
        return self._acknowledged is not None

    def packet(self, cell: int) -> bytes:
        """Return the packet to a cell, any number of portals away from the state that the vehicle holds.

        Raises
        ------
        IndexError
            When there is no such cell.
        PacketError
            When the tileset has more than a packet can carry.
        """
        needed = self._delivery.held(cell, self._policy)
        check_parts(needed, LIMITS)
        base = self._acknowledged
        whole = self._next(cell, needed, needed, base)
        key_frame = make_packet(None, whole.state)
        if base is not None:
            change = self._change(cell, needed, base) if self._retain else whole
            packet = make_packet(base.state, change.state)
            if packet.size < key_frame.size:
                self._remember(change)
                return packet.to_bytes()
        self._remember(whole)
        return key_frame.to_bytes()

    def _change(self, cell: int, needed: Parts, base: _Sent) -> _Sent:
        """State that keeps of a held one what the budget allows."""
        held = base.state.parts
        budget = min(self._retain, LIMITS.faces - face_count(needed))
        required = choose_finer(needed, self._held_finer(cell, needed, held), held, budget)
        budget += face_count(needed) - face_count(required)
        return self._next(cell, required, retained(required, held, base.last_needed, budget), base)

    def _held_finer(self, cell: int, needed: Parts, held: Parts) -> Parts:
        """What the cell calls for of objects that are held at a finer level than is wanted, at that level."""
        levels = {part.object: part.level for part in held}
        finer = {
            part.object: levels[part.object]
            for part in needed
            if levels.get(part.object, part.level) < part.level
        }
        if not finer:
            return ()
        policy = KeptLevels(base=self._policy, kept=finer)
        return tuple(part for part in self._delivery.held(cell, policy) if part.object in finer)

    def _next(self, cell: int, required: Parts, parts: Parts, base: _Sent | None) -> _Sent:
        step = 0 if base is None else base.step + 1
        before = {} if base is None else base.last_needed
        now = {part.object: step for part in required}
        exact = face_count(parts) == face_count(required)
        state = HeldState(self._delivery.map_name, cell, exact, parts)
        last_needed = {part.object: now.get(part.object, before.get(part.object, step)) for part in parts}
        return _Sent(state, last_needed, step)

    def _remember(self, sent: _Sent) -> None:
        name = (sent.state.cell, sent.state.mark)
        self._sent[name] = sent
        self._sent.move_to_end(name)
        while len(self._sent) > REMEMBERED:
            self._sent.popitem(last=False)
