"""A vehicle's side: packets in any order, lost, doubled or broken, and one state that is right or none."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from tilesnav_ref.packet.change import applies, apply_packet
from tilesnav_ref.packet.early import EarlyPackets
from tilesnav_ref.packet.model import Limits, PacketError
from tilesnav_ref.packet.state import NAME_BYTES, HeldState
from tilesnav_ref.packet.wire import Packet, read_packet

TRIES = 8
"""Broken packets that were kept and are found out at a time; so what comes costs a bounded time."""


class Verdict(Enum):
    """What became of a packet."""

    APPLIED = "applied"
    """The state is that of the packet, or of one that was kept and follows it."""
    REPEATED = "repeated"
    """The state is that of the packet already."""
    KEPT = "kept"
    """It does not apply to the state that is held, or leads away from where the vehicle is."""
    REFUSED = "refused"
    """It is broken, for another map, or more than may be held."""


@dataclass(frozen=True)
class Outcome:
    """What became of a packet, and why."""

    verdict: Verdict
    reason: str
    applied: int = 0
    """Packets that were applied, those that had been kept included."""


@dataclass(frozen=True)
class ClientSettings:
    """What a client takes on."""

    limits: Limits = field(default_factory=Limits)
    """Faces and objects that it holds at most."""
    early_bytes: int = 1 << 22
    """Bytes of packets that it keeps for later; the oldest go first."""
    early_packets: int = 256
    """Number of packets that it keeps for later."""


class PacketClient:
    """Holds a state of one map and follows packets.

    Parameters
    ----------
    map_name : bytes
        First 8 bytes of the SHA-256 of the entry tileset file.
    settings : ClientSettings, optional

    Notes
    -----
    The state is always one that the sender has made for the cell that it names: a packet is applied to
    exactly the state that it is for, and what results is taken over as a whole, where it has the mark that
    the packet states.

    A client that is told where the vehicle is, by `enter`, leaves a state only for one of that cell; what
    leads elsewhere is kept until the vehicle goes there, or packets have come that lead on to where it is.
    A client that is not told follows whatever applies; a key frame that comes late then takes it back.
    """

    def __init__(self, map_name: bytes, settings: ClientSettings | None = None) -> None:
        if len(map_name) != NAME_BYTES:
            raise ValueError(f"map_name: found {len(map_name)} bytes; allowed: {NAME_BYTES}")
        self._map_name = map_name
        self._settings = settings or ClientSettings()
        self._early = EarlyPackets(self._settings.early_packets, self._settings.early_bytes)
        self._state: HeldState | None = None
        self._here: int | None = None

    @property
    def state(self) -> HeldState | None:
        """What is held; None before the first key frame."""
        return self._state

    @property
    def holds(self) -> tuple[int, bytes] | None:
        """Cell and mark of the state, which tell a sender what is held."""
        return None if self._state is None else (self._state.cell, self._state.mark)

    @property
    def here(self) -> int | None:
        """Cell that the vehicle is in; None where the client was not told."""
        return self._here

    @property
    def is_current(self) -> bool:
        """Whether there is a state, and for the cell that the vehicle is in where the client was told."""
        return self._state is not None and self._here in (None, self._state.cell)

    def receive(self, data: bytes) -> Outcome:
        """Take a packet; never raises for what comes over the link.

        Parameters
        ----------
        data : bytes
            One packet, or anything else.
        """
        try:
            packet = read_packet(data)
        except PacketError as error:
            return Outcome(Verdict.REFUSED, str(error))
        if packet.map_name != self._map_name:
            reason = f"map {packet.map_name.hex()}; allowed: {self._map_name.hex()}"
            return Outcome(Verdict.REFUSED, reason)
        if self._is_held(packet):
            return Outcome(Verdict.REPEATED, f"cell {packet.cell} is held as the packet leaves it")
        if applies(packet, self._state) and self._may_go(packet.cell):
            return self._take(packet)
        return self._keep(packet)

    def enter(self, cell: int) -> Outcome:
        """Say where the vehicle is now; packets that were kept and lead there are applied.

        Returns
        -------
        Outcome
            APPLIED or REPEATED where the state is for the cell; else KEPT: nothing has come that leads there.
        """
        self._here = cell
        if self._state is not None and self._state.cell == cell:
            return Outcome(Verdict.REPEATED, f"cell {cell} is held")
        applied = self._follow()
        if applied:
            return Outcome(Verdict.APPLIED, f"cell {cell} from packets that were kept", applied)
        return Outcome(Verdict.KEPT, f"nothing has come that leads to cell {cell}", applied)

    def _keep(self, packet: Packet) -> Outcome:
        """Keep a packet that cannot be applied now, and see where that leads."""
        limit = self._settings.early_bytes
        if packet.size > limit:
            return Outcome(Verdict.REFUSED, f"{packet.size} bytes to keep; allowed: {limit} or less")
        reason = self._why_kept(packet)
        self._early.put(packet)
        applied = self._follow()
        if applied:
            return Outcome(Verdict.APPLIED, f"cell {self._here} from packets that were kept", applied)
        return Outcome(Verdict.KEPT, reason)

    def _take(self, packet: Packet) -> Outcome:
        try:
            self._state = apply_packet(packet, self._state, self._settings.limits)
        except PacketError as error:
            return Outcome(Verdict.REFUSED, str(error))
        return Outcome(Verdict.APPLIED, f"cell {packet.cell}", 1 + self._follow())

    def _follow(self) -> int:
        """Apply packets that were kept, each once, as far as the state may go; their number."""
        applied, tries = 0, 0
        while tries < TRIES and (chain := self._chain()):
            state = self._state
            try:
                for packet in chain:
                    state = apply_packet(packet, state, self._settings.limits)
            except PacketError:
                self._early.drop(packet)  # it was broken when it was kept
                tries += 1
                continue
            for packet in chain:
                self._early.drop(packet)
            self._state = state
            applied += len(chain)
        return applied

    def _chain(self) -> list[Packet]:
        """Packets that were kept and may be applied one after the other; none where there are none."""
        if self._here is not None and not self.is_current:
            return self._early.path_to(self._here, self.holds)
        packet = self._early.next_from(self._state, self._here)
        return [] if packet is None else [packet]

    def _is_held(self, packet: Packet) -> bool:
        return (packet.cell, packet.mark) == self.holds

    def _may_go(self, cell: int) -> bool:
        """Whether the state may become one for a cell: where there is one, only for that of the vehicle."""
        return self._state is None or self._here in (None, cell)

    def _why_kept(self, packet: Packet) -> str:
        if applies(packet, self._state):
            return f"it leads to cell {packet.cell}; the vehicle is in cell {self._here}"
        held = "nothing" if self._state is None else f"cell {self._state.cell}, mark {self._state.mark.hex()}"
        return f"it applies to cell {packet.before_cell}, mark {packet.before_mark.hex()}; held: {held}"
