"""Packets that have come before the state that they apply to, or before the vehicle is where they lead."""

from __future__ import annotations

from collections import deque

from tilesnav_ref.packet.change import applies
from tilesnav_ref.packet.state import HeldState
from tilesnav_ref.packet.wire import Packet

Name = tuple[int, bytes]
"""Cell and mark of a state."""


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
            self.drop(self._packets[0])

    def next_from(self, held: HeldState | None, here: int | None) -> Packet | None:
        """Latest packet that is no key frame, applies to what is held and leads to a cell (None: to any)."""
        for packet in reversed(self._packets):
            if applies(packet, held) and not packet.is_key_frame and here in (None, packet.cell):
                return packet
        return None

    def path_to(self, here: int, holds: Name | None) -> list[Packet]:
        """Return the shortest chain of packets that leads to a cell.

        Parameters
        ----------
        here : int
            The cell.
        holds : (cell, mark) or None
            What is held, for another cell.

        Returns
        -------
        list of Packet
            Each applies to the state that results from the one before; the first to what is held, or it is
            a key frame. Only cells and marks have been compared. Empty where there is no chain.
        """
        leading: dict[Name | None, list[Packet]] = {}
        for packet in self._packets:
            before = None if packet.before_cell is None else (packet.before_cell, packet.before_mark)
            leading.setdefault(before, []).append(packet)
        # None stands for no state, to which key frames apply; what is held comes first.
        chains: dict[Name | None, list[Packet]] = {holds: [], None: []}
        nodes = deque(chains)
        while nodes:
            node = nodes.popleft()
            for packet in reversed(leading.get(node, [])):
                after = (packet.cell, packet.mark)
                if after in chains:
                    continue
                chains[after] = [*chains[node], packet]
                if packet.cell == here:
                    return chains[after]
                nodes.append(after)
        return []

    def drop(self, packet: Packet) -> None:
        """Forget a packet that is kept."""
        self._packets.remove(packet)
        self._bytes -= packet.size
