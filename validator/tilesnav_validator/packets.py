"""Sequences of packets and their headers; bodies are left alone."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

from tilesnav_validator.findings import Finding

MAGIC = b"vep1"
HEADER = struct.Struct("<4sBBH8sII8s8sII")
KEY_FRAME, EXACT = 1, 2
"""Bits of the flags."""
NO_CELL = 2**32 - 1
"""What a key frame has in place of the cell that it applies to."""
NO_MARK = bytes(8)
PLAIN, CODED = 0, 1
"""Codecs of the body."""


@dataclass(frozen=True, slots=True)
class Packet:
    """One packet as it stands in the file.

    Attributes
    ----------
    where : str
        File, number and first byte, for findings.
    flags, codec : int
    map : bytes
        First 8 bytes of the SHA-256 of the entry tileset that it is for.
    source, target : int
        Cell of the state that it applies to, and of the one that results.
    before, after : bytes
        Marks of these states.
    body : memoryview
    """

    where: str
    flags: int
    codec: int
    map: bytes
    source: int
    target: int
    before: bytes
    after: bytes
    body: memoryview

    @property
    def applies_to(self) -> tuple[int, bytes]:
        """Cell and mark of the state that it applies to."""
        return self.source, self.before

    @property
    def results_in(self) -> tuple[int, bytes]:
        """Cell and mark of the state that results."""
        return self.target, self.after

    @property
    def is_key(self) -> bool:
        """Whether it applies to no state."""
        return bool(self.flags & KEY_FRAME)

    @property
    def is_exact(self) -> bool:
        """Whether the state that results is said to hold nothing without need."""
        return bool(self.flags & EXACT)


@dataclass
class Sequence:
    """The packets of one file, as far as they could be told apart.

    Attributes
    ----------
    name : str
        The file as it was named.
    size : int
        Its length in bytes.
    packets : list of Packet
    faults : list of Finding
        What is wrong with the headers.
    """

    name: str
    size: int
    packets: list[Packet] = field(default_factory=list)
    faults: list[Finding] = field(default_factory=list)


def read(name: str, data: memoryview) -> Sequence:
    """Tell the packets of a file apart.

    Parameters
    ----------
    name : str
        For findings.
    data : memoryview
        The whole file. Nothing is copied but headers.

    Returns
    -------
    Sequence
        It ends before the first packet that has another magic or does not lie within the file.
    """
    found = Sequence(name, len(data))
    start = 0
    while start < len(data) or not found.packets:
        where = f"{name} packet {len(found.packets)} (byte {start})"
        rest = len(data) - start
        if rest < HEADER.size:
            found.faults.append(Finding(where, f"{rest} bytes", f"a header, {HEADER.size} bytes"))
            break
        magic, flags, codec, zero, of_map, source, target, before, after, length, last = HEADER.unpack_from(
            data, start
        )
        if magic != MAGIC:
            found.faults.append(Finding(where, f"magic {magic!r}", f"{MAGIC!r}"))
            break
        if length > rest - HEADER.size:
            allowed = f"at most {rest - HEADER.size}, what is left of the file"
            found.faults.append(Finding(where, f"a body of {length} bytes", allowed))
            break
        start += HEADER.size + length
        packet = Packet(
            where, flags, codec, of_map, source, target, before, after, data[start - length : start]
        )
        found.packets.append(packet)
        found.faults.extend(_field_faults(packet, (zero, last)))
    return found


def _field_faults(packet: Packet, zeros: tuple[int, int]) -> list[Finding]:
    """Fields of a header that do not have a value that the specification gives them."""
    key = packet.is_key
    tests = (
        (packet.flags < 4, "flags", f"{packet.flags:#04x}", "bits 0 and 1 only"),
        (packet.codec in (PLAIN, CODED), "codec", str(packet.codec), "0 or 1"),
        (zeros[0] == 0, "offset 6", str(zeros[0]), "0"),
        (zeros[1] == 0, "offset 44", str(zeros[1]), "0"),
        (not key or packet.source == NO_CELL, "cell before", str(packet.source), f"{NO_CELL} in a key frame"),
        (
            not key or packet.before == NO_MARK,
            "mark before",
            packet.before.hex(),
            "zero bytes in a key frame",
        ),
    )
    return [
        Finding(f"{packet.where} {what}", measured, allowed)
        for good, what, measured, allowed in tests
        if not good
    ]
