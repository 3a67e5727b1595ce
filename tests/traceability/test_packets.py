"""The client of the reference implementation takes the packets of valid cases and none that is not sound."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path

import pytest
from suite import Case, cases

from tilesnav_ref.packet.client import PacketClient, Verdict
from tilesnav_validator import packets

WITH_PACKETS = [case for case in cases() if "packets" in case.facts]
VALID = [case for case in WITH_PACKETS if case.status == 0]
REFUSED = ("packet/header", "packet/map", "packet/body", "packet/after")
UNSOUND = [case for case in WITH_PACKETS if case.facts.get("requirement", "").startswith(REFUSED)]


def files(case: Case) -> list[bytes]:
    return [(case.folder / name).read_bytes() for name in case.facts["packets"]]


def client(case: Case) -> PacketClient:
    tileset: Path = case.folder / case.facts["tileset"]
    return PacketClient(sha256(tileset.read_bytes()).digest()[:8])


def apart(data: bytes) -> tuple[list[packets.Packet], list[bytes]]:
    """The packets that can be told apart, their bytes, and as the last of these what is left of the file."""
    found = packets.read("x", memoryview(data)).packets
    ends = [0]
    for packet in found:
        ends.append(ends[-1] + packets.HEADER.size + len(packet.body))
    return found, [data[start:end] for start, end in zip(ends, [*ends[1:], len(data)], strict=True)]


@pytest.mark.parametrize("case", VALID, ids=lambda case: case.name)
def test_the_client_takes_every_packet_of_a_valid_case(case: Case) -> None:
    for data in files(case):
        found, pieces = apart(data)
        assert pieces.pop() == b""
        ways: dict[tuple[int, bytes], list[bytes]] = {}
        for packet, piece in zip(found, pieces, strict=True):
            way = [piece] if packet.is_key else [*ways[packet.applies_to], piece]
            ways[packet.results_in] = way
            holder = client(case)
            for one in way:
                assert holder.receive(one).verdict in {Verdict.APPLIED, Verdict.REPEATED}
            assert holder.state is not None
            assert (holder.state.cell, holder.state.mark) == packet.results_in
            assert holder.state.exact == packet.is_exact


@pytest.mark.parametrize("case", UNSOUND, ids=lambda case: case.name)
def test_the_client_refuses_a_packet_that_is_not_sound(case: Case) -> None:
    for data in files(case):
        found, pieces = apart(data)
        holder = client(case)
        verdicts = [holder.receive(piece).verdict for piece in pieces if piece or len(pieces) == 1]
        assert Verdict.REFUSED in verdicts
        if holder.state is not None:
            assert (holder.state.cell, holder.state.mark) in {packet.results_in for packet in found}
