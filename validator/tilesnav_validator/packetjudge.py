"""Sequences of packets, followed from state to state, each state judged before it is let go."""

from __future__ import annotations

import time
from collections import defaultdict
from dataclasses import dataclass, field
from itertools import islice

from tilesnav_validator import packetcoded, packetplain
from tilesnav_validator.findings import Finding, Settings
from tilesnav_validator.packetbits import TooManyBitsError
from tilesnav_validator.packetparts import BeyondTilesetError, BodyError, Part, Parts, mark, size
from tilesnav_validator.packets import CODED, PLAIN, Packet, Sequence
from tilesnav_validator.packetscene import Scene

NAMED = 4
"""Faces and objects that a finding names."""
DECODERS = {PLAIN: packetplain.decode, CODED: packetcoded.decode}


@dataclass
class Followed:
    """What has come of following the sequences.

    Attributes
    ----------
    findings : dict
        By requirement.
    unexamined : str
        Why not all has been followed; empty when it has.
    states : int
        States that were judged.
    bytes : int
        Bytes of these states in their canonical form.
    seconds : float
        Wall-clock time.
    """

    findings: dict[str, list[Finding]] = field(default_factory=lambda: defaultdict(list))
    unexamined: str = ""
    states: int = 0
    bytes: int = 0
    seconds: float = 0.0

    def note(self, requirement: str, packet: Packet, measured: str, allowed: str) -> None:
        """Keep a finding on a packet."""
        self.findings[f"packet/{requirement}"].append(Finding(packet.where, measured, allowed))


class UnexaminedError(Exception):
    """Following a sequence takes more time or memory than it is given."""


def follow(sequences: list[Sequence], scene: Scene, settings: Settings) -> Followed:
    """Follow sequences whose headers are sound.

    A packet whose body is broken or whose mark is wrong has no result; what applies to that is passed over.
    """
    started = time.perf_counter()
    found = Followed()
    try:
        for sequence in sequences:
            _Follower(sequence, scene, settings, found).run()
    except UnexaminedError as reason:
        found.unexamined = str(reason)
    found.seconds = time.perf_counter() - started
    return found


class _Follower:
    """One sequence, and those of its states that a later packet applies to, by cell and mark."""

    def __init__(self, sequence: Sequence, scene: Scene, settings: Settings, found: Followed) -> None:
        self.packets = sequence.packets
        self.scene, self.settings, self.found = scene, settings, found
        self.last_use = {p.applies_to: number for number, p in enumerate(self.packets) if not p.is_key}
        self.states: dict[tuple[int, bytes], Parts] = {}
        self.held = 0
        self.sound: set[Part] = set()

    def run(self) -> None:
        """Follow all packets."""
        for number, packet in enumerate(self.packets):
            before: Parts | None = {} if packet.is_key else self.states.get(packet.applies_to)
            after = None if before is None else self._apply(packet, before)
            if after is not None and self._has_mark(packet, after):
                self._judge(packet, after)
                self._keep(number, after)
            if self.last_use.get(packet.applies_to) == number:
                self._drop(packet.applies_to)

    def _keep(self, number: int, parts: Parts) -> None:
        """Keep a state as long as a later packet applies to it."""
        name = self.packets[number].results_in
        if self.last_use.get(name, number) <= number:
            return
        self._drop(name)
        self.states[name] = parts
        self.held += size(parts.values())
        if self.held > self.settings.packet_memory:
            raise UnexaminedError(f"states of more than {self.settings.packet_memory} bytes at once")

    def _drop(self, name: tuple[int, bytes]) -> None:
        if name in self.states:
            self.held -= size(self.states.pop(name).values())

    def _apply(self, packet: Packet, before: Parts) -> Parts | None:
        """The state that results; None where the body is broken."""
        try:
            return DECODERS[packet.codec](packet.body, before, self.scene.object_count)
        except BeyondTilesetError as error:
            self.found.note("geometry", packet, f"{error.where}: {error.measured}", error.allowed)
        except TooManyBitsError as error:
            raise UnexaminedError(f"{packet.where}: {error}") from None
        except BodyError as error:
            self.found.note("body", packet, f"{error.where}: {error.measured}", error.allowed)
        return None

    def _has_mark(self, packet: Packet, parts: Parts) -> bool:
        """Whether a state has the mark that the header states."""
        found = self.found
        found.states += 1
        found.bytes += size(parts.values())
        if found.bytes > self.settings.packet_bytes:
            raise UnexaminedError(f"more than {self.settings.packet_bytes} bytes of states")
        digest = mark(packet.map, packet.target, packet.is_exact, parts)
        if digest != packet.after:
            found.note("after", packet, f"mark {packet.after.hex()}", f"{digest.hex()}, that of the result")
        return digest == packet.after

    def _judge(self, packet: Packet, parts: Parts) -> None:
        """Judge the geometry of a state, and whether it holds what it has to."""
        if self._faulty(packet, parts):
            return
        for requirement, faults, allowed in (
            ("conservative", self.scene.missing(packet.target, parts), "what the PVS of the cell asks for"),
            ("exact", self.scene.needless(packet.target, parts) if packet.is_exact else iter(()), "no more"),
        ):
            named = list(islice(faults, NAMED + 1))
            if named:
                verb = "lacks" if requirement == "conservative" else "holds"
                more = " and more" if len(named) > NAMED else ""
                self.found.note(requirement, packet, f"{verb} {'; '.join(named[:NAMED])}{more}", allowed)

    def _faulty(self, packet: Packet, parts: Parts) -> bool:
        """Whether a part differs from the tileset; those that have been compared before are not again."""
        new = [part for part in parts.values() if part not in self.sound]
        faults = [fault for part in new if (fault := self.scene.fault(part))]
        if faults:
            self.found.note("geometry", packet, faults[0], "what the tileset has")
        else:
            self.sound = set(parts.values())
        return bool(faults)
