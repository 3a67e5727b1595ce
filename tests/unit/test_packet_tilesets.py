"""Packets of the tilesets of the conformance cases: every cell, in every order of two, at every level."""

from __future__ import annotations

from hashlib import sha256
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from tilesnav_ref.packet.client import PacketClient, Verdict
from tilesnav_ref.packet.state import HeldState
from tilesnav_ref.stream.delivery import Delivery
from tilesnav_ref.stream.policy import LevelPolicy
from tilesnav_ref.stream.reader import NavTileset, open_tileset
from tilesnav_ref.stream.sender import Sender

CASES = Path(__file__).resolve().parents[2] / "conformance" / "cases" / "valid"
NAMES = (
    "ring",
    "two-sectors",
    "two-coarse-levels",
    "faces-stand-for-many",
    "porous-fence",
    "degenerate-face",
)


def lacks(tileset: NavTileset, state: HeldState) -> list[str]:
    """What a state lacks to be conservative, face by face as the specification says it."""
    held = {part.object: part for part in state.parts}
    missing = []
    for face in tileset.state(state.cell).faces.tolist():
        number = int(np.searchsorted(tileset.object_offsets, face, side="right")) - 1
        part = held.get(number)
        if part is None:
            missing.append(f"object {number}")
            continue
        if part.level == 0:
            stands_for = [[f] for f in range(*tileset.object_offsets[number : number + 2])]
        else:
            (level,) = (one for one in tileset.levels if one.level == part.level)
            first, last = level.geometry.offsets[number : number + 2]
            stands_for = [level.fine_faces.row(row).tolist() for row in range(first, last)]
        missing += [
            f"face {index} of object {number}"
            for index, fine in enumerate(stands_for)
            if face in fine and index not in part.faces.tolist()
        ]
    return missing


@pytest.mark.parametrize("retain", [0, 3, 10**6])
@pytest.mark.parametrize("policy", ["fine", "coarse", "auto"])
@pytest.mark.parametrize("name", NAMES)
def test_a_client_is_led_from_each_cell_to_each_other(name: str, policy: str, retain: int) -> None:
    tileset = open_tileset(CASES / name)
    delivery = Delivery(tileset)
    for source, target in product(range(tileset.cell_count), repeat=2):
        sender = Sender(delivery, LevelPolicy(policy), retain)
        client = PacketClient(sha256((CASES / name / "tileset.json").read_bytes()).digest()[:8])
        for cell in (source, target, source):
            outcome = client.receive(sender.packet(cell))
            assert outcome.verdict is not Verdict.REFUSED, outcome
            assert sender.acknowledge(client.holds)
            assert client.state is not None
            assert client.state.cell == cell
            assert lacks(tileset, client.state) == []
            if not retain:
                assert client.state.exact
                wanted = HeldState(delivery.map_name, cell, True, delivery.held(cell, LevelPolicy(policy)))
                assert client.state.canonical_bytes() == wanted.canonical_bytes()
