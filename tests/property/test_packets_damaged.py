"""What the sender of the reference implementation sends, judged by the validator, as sent and damaged."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from tilesnav_ref.stream.delivery import Delivery
from tilesnav_ref.stream.policy import LevelPolicy
from tilesnav_ref.stream.reader import open_tileset
from tilesnav_ref.stream.sender import Sender
from tilesnav_validator import packets
from tilesnav_validator.findings import Settings
from tilesnav_validator.packetjudge import follow
from tilesnav_validator.packetscene import Scene
from tilesnav_validator.runner import judge

CASES = Path(__file__).resolve().parents[2] / "conformance" / "cases" / "valid"
NAMES = (
    "ring",
    "two-coarse-levels",
    "faces-stand-for-many",
    "porous-fence",
    "one-sided-wall",
    "packets-corners-coincide",
    "packets-grid-limit",
    "packets-empty-state",
)


def walk(case: Path, policy: str, retain: int) -> bytes:
    """Packets for cells at random, each from the last state that was acknowledged."""
    choice = random.Random(f"{case.name} {policy} {retain}")
    tileset = open_tileset(case)
    sender = Sender(Delivery(tileset), LevelPolicy(policy), retain)
    sent = b""
    for _ in range(10):
        packet = sender.packet(choice.randrange(tileset.cell_count))
        sent += packet
        if choice.random() < 0.7:
            (last,) = packets.read("", memoryview(packet)).packets
            sender.acknowledge(last.results_in)
    return sent


@pytest.mark.parametrize("name", NAMES)
def test_what_is_sent_is_valid(name: str, tmp_path: Path) -> None:
    found = []
    for policy in ("fine", "coarse", "auto"):
        for retain in (0, 3, 10**6):
            found.append(tmp_path / f"{policy}-{retain}.vep")
            found[-1].write_bytes(walk(CASES / name, policy, retain))
    result = judge(CASES / name / "tileset.json", Settings(rays=0, packets=tuple(found)))
    verdicts = {j.requirement.id: (j.verdict, j.findings) for j in result.judgements}
    wrong = {name: v for name, v in verdicts.items() if name.startswith("packet/") and v[0] != "pass"}
    assert wrong == {}
    assert result.subject.followed is not None
    assert result.subject.followed.states == 90


@pytest.mark.parametrize("name", ["two-coarse-levels", "porous-fence"])
def test_damage_is_refused(name: str) -> None:
    """A mark with another bit is refused; a body with another bit is, or leads to what it led to before."""
    choice = random.Random(11)
    sent = walk(CASES / name, "auto", 3)
    scene = Scene(judge(CASES / name / "tileset.json", Settings(rays=0)).subject)
    whole = packets.read("x", memoryview(sent))
    starts = [int(p.where.split("byte ")[1].rstrip(")")) for p in whole.packets]
    refused = {"mark": 0, "body": 0}
    for _ in range(100):
        number = choice.randrange(len(starts))
        size = len(whole.packets[number].body)
        for part, offset in (("mark", choice.randrange(32, 40)), ("body", 48 + choice.randrange(size))):
            data = bytearray(sent)
            data[starts[number] + offset] ^= 1 << choice.randrange(8)
            found = packets.read("x", memoryview(bytes(data)))
            assert not found.faults
            refused[part] += bool(follow([found], scene, Settings()).findings)
    assert refused["mark"] == 100
    assert refused["body"] > 20  # the last bits of a short coded body mean little
