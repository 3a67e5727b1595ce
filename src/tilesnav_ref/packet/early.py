"""Packets that have come before the state that they apply to, or before the vehicle is where they lead."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from tilesnav_ref.packet.change import applies
from tilesnav_ref.packet.state import HeldState
from tilesnav_ref.packet.wire import Packet


class EarlyPackets:
    """A bounded store; the oldest packets go first.

    Parameters
    ----------
    most_packets, most_bytes : int
        What it holds at most.
    """

    def __init__(self, most_packets: int, most_bytes: int) -> None:
        self._most_packets = most_packets
        self._most_bytes = most_bytes
        self._packets: deque[Packet] = deque()
        self._bytes = 0

    def __len__(self) -> int:
        return len(self._packets)

    @property
    def byte_count(self) -> int:
        """Bytes of the packets."""
        return self._bytes

    def put(self, packet: Packet) -> None:
        """Keep a packet, once; older ones go where there is no room."""
        if packet in self._packets:
            return
        self._packets.append(packet)
        self._bytes += packet.size
        while len(self._packets) > self._most_packets or self._bytes > self._most_bytes:
            self._drop(self._packets[0])

    def take(
        self, held: HeldState | None, here: int | None, may_go: Callable[[int], bool]
    ) -> Packet | None:
        """Take out a packet that applies to what is held and leads to a cell where the state may go.

        Returns
        -------
        Packet or None
            Of several, one that leads to the cell where the vehicle is comes first, of these one that is no key
            frame, then the latest. A key frame that leads elsewhere is left.
        """
        found = [
            packet
            for packet in self._packets
            if applies(packet, held)
            and may_go(packet.cell)
            and (not packet.is_key_frame or packet.cell == here)
        ]
        if not found:
            return None
        ranks = [(packet.cell == here, not packet.is_key_frame, place) for place, packet in enumerate(found)]
        chosen = found[max(ranks)[2]]
        self._drop(chosen)
        return chosen

    def _drop(self, packet: Packet) -> None:
        self._packets.remove(packet)
        self._bytes -= packet.size
