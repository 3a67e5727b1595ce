"""Sequences that the sender makes for the tilesets of the conformance cases, judged by the validator."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tilesnav_ref.packet.change import apply_packet
from tilesnav_ref.packet.client import PacketClient, Verdict
from tilesnav_ref.packet.model import Limits
from tilesnav_ref.packet.plain import encode_plain
from tilesnav_ref.packet.state import HeldState
from tilesnav_ref.packet.wire import CODED, PLAIN, Packet, read_packet
from tilesnav_ref.stream.delivery import Delivery
from tilesnav_ref.stream.policy import LevelPolicy
from tilesnav_ref.stream.reader import open_tileset
from tilesnav_ref.stream.sender import Sender
from tilesnav_validator.findings import Settings
from tilesnav_validator.runner import judge

CASES = Path(__file__).resolve().parents[2] / "conformance" / "cases" / "valid"
NAMES = ("ring", "two-sectors", "two-coarse-levels", "faces-stand-for-many", "packets-corners-coincide")


def in_plain(packet: Packet, before: HeldState | None, after: HeldState) -> Packet:
    """The packet with the other codec."""
    held = () if packet.is_key_frame or before is None else before.parts
    return replace(packet, codec=PLAIN, body=encode_plain(held, after.parts))


def sequence(folder: Path, policy: str, retain: int, codec: int) -> Iterator[bytes]:
    """Packets of a random walk with leaps; the vehicle acknowledges most, and loses its state once."""
    delivery = Delivery(open_tileset(folder))
    sender = Sender(delivery, LevelPolicy(policy), retain)
    client = PacketClient(delivery.map_name)
    random = np.random.default_rng(5)
    for number in range(12):
        before = client.state
        data = sender.packet(int(random.integers(delivery.tileset.cell_count)))
        assert client.receive(data).verdict is not Verdict.REFUSED
        packet = read_packet(data)
        assert packet.codec == CODED
        assert client.state is not None
        if codec == PLAIN:
            packet = in_plain(packet, before, client.state)
            assert apply_packet(packet, before, Limits()).mark == packet.mark
        if number == 8:
            client = PacketClient(delivery.map_name)
        sender.acknowledge(client.holds)
        yield packet.to_bytes()


@pytest.mark.parametrize("codec", [PLAIN, CODED])
@pytest.mark.parametrize("name", NAMES)
def test_the_validator_refuses_no_packet(name: str, codec: int, tmp_path: Path) -> None:
    files = []
    for policy, retain in (("fine", 0), ("coarse", 0), ("auto", 4), ("auto", 10**6)):
        files.append(tmp_path / f"{policy}-{retain}.vep")
        files[-1].write_bytes(b"".join(sequence(CASES / name, policy, retain, codec)))
    result = judge(CASES / name / "tileset.json", Settings(rays=100, seed=1, threads=1, packets=tuple(files)))
    judged = [one for one in result.judgements if one.requirement.id.startswith("packet/")]
    verdicts = {one.requirement.id: one.verdict for one in judged}
    assert len(verdicts) == 9
    assert set(verdicts.values()) == {"pass"}, verdicts
