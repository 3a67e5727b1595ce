"""The bytes of a packet: a header of 48 bytes and a body that is left to its codec."""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct

from tilesnav_ref.packet.model import PacketError
from tilesnav_ref.packet.state import NAME_BYTES

MAGIC = b"vep1"
HEADER = Struct("<4sBBH8sII8s8sII")
KEY_FRAME, EXACT = 1, 2
"""Flags."""
PLAIN, CODED = 0, 1
"""Codecs."""
NO_CELL = (1 << 32) - 1
NO_MARK = bytes(NAME_BYTES)


@dataclass(frozen=True)
class Packet:
    """A packet whose header is sound; its body has not been looked at."""

    map_name: bytes
    before_cell: int | None
    """Cell of the state that it applies to; None in a key frame."""
    before_mark: bytes
    cell: int
    """Of the state that results."""
    mark: bytes
    exact: bool
    codec: int
    body: bytes

    @property
    def is_key_frame(self) -> bool:
        """Whether it applies to no state."""
        return self.before_cell is None

    @property
    def size(self) -> int:
        """Bytes."""
        return HEADER.size + len(self.body)

    def to_bytes(self) -> bytes:
        """Return the packet as it travels."""
        flags = (KEY_FRAME if self.before_cell is None else 0) | (EXACT if self.exact else 0)
        before = NO_CELL if self.before_cell is None else self.before_cell
        names = (self.before_mark, self.mark)
        fields = (MAGIC, flags, self.codec, 0, self.map_name, before, self.cell, *names, len(self.body), 0)
        return HEADER.pack(*fields) + self.body


def read_packet(data: bytes) -> Packet:
    """Read one packet.

    Raises
    ------
    PacketError
        When the header is not sound, or the body not as long as it states.
    """
    packet, end = _read_at(data, 0)
    if end != len(data):
        raise PacketError(f"{len(data) - end} bytes behind the body; allowed: none")
    return packet


def read_sequence(data: bytes) -> tuple[Packet, ...]:
    """Read packets one behind the other.

    Raises
    ------
    PacketError
        When a header is not sound, or a body not as long as it states.
    """
    packets: list[Packet] = []
    place = 0
    while place < len(data):
        try:
            packet, place = _read_at(data, place)
        except PacketError as error:
            raise PacketError(f"packet {len(packets)}, byte {place}: {error}") from None
        packets.append(packet)
    return tuple(packets)


def _read_at(data: bytes, place: int) -> tuple[Packet, int]:
    """Packet at a place, and the end of its body."""
    rest = len(data) - place
    if rest < HEADER.size:
        raise PacketError(f"{rest} bytes; allowed: a header of {HEADER.size}")
    fields = HEADER.unpack_from(data, place)
    magic, flags, codec, zero, map_name, before_cell, cell, before_mark, mark, length, last = fields
    if magic != MAGIC:
        raise PacketError(f"magic {magic!r}; allowed: {MAGIC!r}")
    if flags & ~(KEY_FRAME | EXACT) or codec > CODED or zero or last:
        found = f"flags {flags:#04x}, codec {codec}, {zero} and {last} in place of zeros"
        raise PacketError(f"{found}; allowed: flags 0 to 3, codec 0 or 1, zeros")
    is_key_frame = bool(flags & KEY_FRAME)
    if is_key_frame and (before_cell, before_mark) != (NO_CELL, NO_MARK):
        raise PacketError(f"a key frame that applies to cell {before_cell}; allowed: {NO_CELL} and mark 0")
    if cell == NO_CELL or (before_cell == NO_CELL and not is_key_frame):
        raise PacketError(f"cell {NO_CELL}; allowed: numbers of cells")
    end = place + HEADER.size + length
    if end > len(data):
        raise PacketError(f"a body of {length} bytes; allowed: {rest - HEADER.size}, those that are there")
    body = data[place + HEADER.size : end]
    before = None if is_key_frame else before_cell
    packet = Packet(map_name, before, before_mark, cell, mark, bool(flags & EXACT), codec, body)
    return packet, end
