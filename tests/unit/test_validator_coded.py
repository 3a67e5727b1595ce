"""Coded bodies: the examples of the text, refusals, and bytes that nobody vouches for."""

from __future__ import annotations

import random
from typing import Any

import pytest

from tilesnav_validator import packetbits, packetcoded
from tilesnav_validator.findings import Settings
from tilesnav_validator.packetbits import TooManyBitsError
from tilesnav_validator.packetjudge import follow
from tilesnav_validator.packetmesh import Mesh
from tilesnav_validator.packetparts import BeyondTilesetError, BodyError, Part
from tilesnav_validator.packets import Packet, Sequence

RECTANGLE = bytes.fromhex("9cc3d02d9078eb722026")
BESIDE = bytes.fromhex("4460544a565a01ad")
GOES = bytes.fromhex("4880")
A, B, C, D, E = [0, 0, 0], [1024, 0, 0], [1024, 0, 512], [0, 0, 512], [1024, 700, 900]


def decode(body: bytes, held: dict[int, Part]) -> dict[int, Part]:
    return packetcoded.decode(memoryview(body), held, 9)


def faces(parts: dict[int, Part]) -> dict[int, dict[int, list[list[int]]]]:
    return {
        item: dict(zip(part.faces.tolist(), part.corners.tolist(), strict=True))
        for item, part in parts.items()
    }


def steps() -> list[dict[int, Part]]:
    """Nothing, and the states of the examples."""
    found: list[dict[int, Part]] = [{}]
    for body in (RECTANGLE, BESIDE, GOES):
        found.append(decode(body, found[-1]))
    return found


def test_the_examples_of_the_text() -> None:
    nothing, rectangle, beside, goes = map(faces, steps())
    assert decode(b"\0", {}) == nothing
    assert rectangle == {5: {0: [A, B, C], 1: [A, C, D]}}
    assert beside == {5: {**rectangle[5], 4: [D, C, E]}}
    assert goes == {5: {1: [A, C, D], 4: [D, C, E]}}


@pytest.mark.parametrize(
    ("body", "before", "said"),
    [
        ("", 0, "0 bytes"),
        ("21f0", 2, "bytes left over"),
        ("79", 1, "bytes asked for"),
        ("44f6", 2, "face -"),
        ("454d", 2, "before the latest"),
        ("4f80", 2, "faces leave"),
        ("67", 2, "action "),
        ("b3", 1, "objects that are not held"),
        ("8980", 2, "flags "),
        ("82a892", 1, "level "),
        ("86", 1, "no face is left"),
        ("44d3", 2, "two faces of one number"),
        ("80bf4fffeab00000", 0, "coordinate -8388608"),
    ],
)
def test_what_the_text_calls_invalid_is_refused(body: str, before: int, said: str) -> None:
    with pytest.raises(BodyError, match=said):
        decode(bytes.fromhex(body), steps()[before])


def test_more_objects_than_the_tileset_has() -> None:
    with pytest.raises(BeyondTilesetError, match="new objects, allowed is 9"):
        decode(bytes.fromhex("ed"), steps()[2])


def test_a_body_without_end_is_given_up(monkeypatch: Any) -> None:
    monkeypatch.setattr(packetbits, "MAX_BITS", 20)
    with pytest.raises(TooManyBitsError, match="more than 20 bits"):
        decode(RECTANGLE, {})
    packet = Packet("x", 1, 1, bytes(8), 2**32 - 1, 0, bytes(8), bytes(8), memoryview(RECTANGLE))
    scene: Any = type("Scene", (), {"object_count": 9})
    found = follow([Sequence("x", 58, [packet])], scene, Settings())
    assert found.unexamined == "x: a body of more than 20 bits"


def test_random_bytes_are_decoded_or_refused(monkeypatch: Any) -> None:
    monkeypatch.setattr(packetbits, "MAX_BITS", 5000)
    choice, before = random.Random(8), steps()
    outcomes = {"decoded": 0, "refused": 0}
    for number in range(4000):
        body = bytearray(choice.choice((RECTANGLE, BESIDE, GOES)) if number % 2 else choice.randbytes(9))
        body[choice.randrange(len(body))] = choice.randrange(256)
        try:
            decode(bytes(body), before[choice.randrange(4)])
            outcomes["decoded"] += 1
        except (BodyError, TooManyBitsError):
            outcomes["refused"] += 1
    assert outcomes["refused"] > 3000


def test_every_truncation_is_refused() -> None:
    before = steps()
    for number, body in enumerate((RECTANGLE, BESIDE, GOES)):
        for size in range(len(body)):
            with pytest.raises(BodyError):
                decode(body[:size], before[number])


def test_a_candidate_out_of_reach_is_left_out() -> None:
    for shift, found in ((0, {(2**23 - 1, -1, 0): 2}), (1, {})):
        mesh = Mesh()
        start, end, third = (mesh.vertex(place) for place in ((0, 0, 0), (2**23 - 1, 0, 0), (-shift, 1, 0)))
        mesh.add((start, end, third), True)
        assert mesh.candidates(start, end, third, {}) == found
