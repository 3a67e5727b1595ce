"""Sequences that the sender makes for the tilesets of the conformance cases, judged by the validator."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tilesnav_ref.packet.client import PacketClient, Verdict
from tilesnav_ref.stream.delivery import Delivery
from tilesnav_ref.stream.policy import LevelPolicy
from tilesnav_ref.stream.reader import open_tileset
from tilesnav_ref.stream.sender import Sender
from tilesnav_validator.findings import Settings
from tilesnav_validator.runner import judge

CASES = Path(__file__).resolve().parents[2] / "conformance" / "cases" / "valid"
NAMES = ("ring", "two-sectors", "two-coarse-levels", "faces-stand-for-many", "packets-corners-coincide")


def sequence(folder: Path, policy: str, retain: int) -> Iterator[bytes]:
    """Packets of a random walk with leaps; the vehicle acknowledges most, and loses its state once."""
    delivery = Delivery(open_tileset(folder))
    sender = Sender(delivery, LevelPolicy(policy), retain)
    client = PacketClient(delivery.map_name)
    random = np.random.default_rng(5)
    for number in range(12):
        packet = sender.packet(int(random.integers(delivery.tileset.cell_count)))
        assert client.receive(packet).verdict is not Verdict.REFUSED
        if number == 8:
            client = PacketClient(delivery.map_name)
        sender.acknowledge(client.holds)
        yield packet


@pytest.mark.parametrize("name", NAMES)
def test_the_validator_refuses_no_packet(name: str, tmp_path: Path) -> None:
    files = []
    for policy, retain in (("fine", 0), ("coarse", 0), ("auto", 4), ("auto", 10**6)):
        files.append(tmp_path / f"{policy}-{retain}.vep")
        files[-1].write_bytes(b"".join(sequence(CASES / name, policy, retain)))
    result = judge(CASES / name / "tileset.json", Settings(rays=100, seed=1, threads=1, packets=tuple(files)))
    judged = [one for one in result.judgements if one.requirement.id.startswith("packet/")]
    verdicts = {one.requirement.id: one.verdict for one in judged}
    assert len(verdicts) == 9
    assert set(verdicts.values()) == {"pass"}, verdicts
