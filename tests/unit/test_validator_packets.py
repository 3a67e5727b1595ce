"""Packets by hand: the form of faces, marks, bounds, and bytes that nobody vouches for."""

from __future__ import annotations

import hashlib
import json
import random
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from validator_fixture import FLAT, FLOOR, WALL, Small, failed

from tilesnav_validator import cli, packetjudge, packetparts, packetplain, packets
from tilesnav_validator.findings import Settings
from tilesnav_validator.packetparts import BodyError, Part
from tilesnav_validator.packetscene import Scene
from tilesnav_validator.runner import judge

Face = tuple[tuple[int, ...], ...]
STEPS = 1024
OBJECTS = [
    [tuple(tuple(int(x * STEPS) for x in corner) for corner in face) for face in item]
    for item in (FLOOR, WALL, FLAT)
]
SETS = ({0: [0, 1], 1: [0, 1], 2: [0]}, {0: [0, 1], 1: [0, 1]})
"""Faces of each object in the two cells of the small tileset."""
KEY = 2**32 - 1


def smallest(face: Face) -> Face:
    return min(face[k:] + face[:k] for k in range(3))


def numbers(values: list[int]) -> bytes:
    return struct.pack(f"<I{len(values)}I", len(values), *values)


def geometry(item: int, faces: list[int]) -> bytes:
    rows = [v for face in faces for corner in smallest(OBJECTS[item][face]) for v in corner]
    return struct.pack(f"<{len(rows)}i", *rows)


def canonical(of_map: bytes, cell: int, exact: int, held: dict[int, list[int]]) -> bytes:
    text = of_map + struct.pack("<III", cell, exact, len(held))
    for item, faces in held.items():
        text += struct.pack("<IBB", item, 0, 0) + numbers(faces) + geometry(item, faces)
    return text


def mark(of_map: bytes, cell: int, exact: int, held: dict[int, list[int]]) -> bytes:
    return hashlib.sha256(canonical(of_map, cell, exact, held)).digest()[:8]


def change(item: int, mode: int, leave: list[int], enter: list[int]) -> bytes:
    return struct.pack("<IBBH", item, 0, 0, mode) + numbers(leave) + numbers(enter) + geometry(item, enter)


def plain(gone: list[int], *changes: bytes) -> bytes:
    return numbers(gone) + struct.pack("<I", len(changes)) + b"".join(changes)


def deflated(data: bytes) -> bytes:
    return struct.pack("<I", len(data)) + zlib.compress(data)


def packet(
    of_map: bytes, states: tuple[tuple[int, bytes], tuple[int, bytes]], flags: int, body: bytes
) -> bytes:
    (source, before), (target, after) = states
    head = struct.pack(
        "<4sBBH8sII8s8sII", b"vep1", flags, 0, 0, of_map, source, target, before, after, len(body), 0
    )
    return head + body


KEY_BODY = plain([], *(change(item, 1, [], faces) for item, faces in SETS[0].items()))
BODIES = (KEY_BODY, plain([2]), plain([], change(2, 1, [], [0])))


def walk(of_map: bytes, bodies: tuple[bytes, ...] = BODIES) -> bytes:
    """Cell 0, cell 1, cell 0 again, all exact, with bodies that may be others."""
    names = [(KEY, bytes(8)), *((cell, mark(of_map, cell, 1, SETS[cell])) for cell in (0, 1, 0))]
    flags = (3, 2, 2)
    return b"".join(
        packet(of_map, (names[i], names[i + 1]), flags[i], deflated(bodies[i])) for i in range(len(bodies))
    )


@pytest.fixture
def tileset(tmp_path: Path) -> Path:
    return Small().write(tmp_path)


@pytest.fixture
def of_map(tileset: Path) -> bytes:
    return hashlib.sha256(tileset.read_bytes()).digest()[:8]


@pytest.fixture
def scene(tileset: Path) -> Scene:
    return Scene(judge(tileset, Settings(rays=0)).subject)


def verdicts(tileset: Path, data: bytes, **settings: Any) -> dict[str, tuple[str, str]]:
    path = tileset.with_name("walk.vep")
    path.write_bytes(data)
    result = judge(tileset, Settings(rays=0, packets=(path,), **settings))
    return {j.requirement.id: (j.verdict, j.note) for j in result.judgements if "packet/" in j.requirement.id}


def follow(scene: Scene, data: bytes) -> dict[str, list[Any]]:
    """Findings on bytes, as a sequence for a tileset; those on headers end it."""
    found = packets.read("x", memoryview(data))
    if found.faults:
        return {"packet/header": found.faults}
    cells = len(scene.pvs.offsets) - 1
    if any(p.target >= cells for p in found.packets):
        return {"packet/cells": found.packets}
    return packetjudge.follow([found], scene, Settings()).findings


def test_a_walk_by_hand_is_valid(tileset: Path, of_map: bytes) -> None:
    assert set(verdicts(tileset, walk(of_map)).values()) == {("pass", "")}


def test_the_command_judges_packets(tileset: Path, of_map: bytes, capsys: pytest.CaptureFixture[str]) -> None:
    path = tileset.with_name("walk.vep")
    path.write_bytes(walk(of_map))
    arguments = [str(tileset), "--rays", "500", "--packets", str(path), "--packets", str(path)]
    assert cli.main(arguments) == 0
    text = capsys.readouterr().out
    assert "pass         packet/exact" in text
    size = 2 * path.stat().st_size
    states = 2 * sum(len(canonical(of_map, cell, 1, SETS[cell])) for cell in (0, 1, 0))
    said = f"packets: 2 files, 6 packets, {size} bytes, 2 key frames"
    assert f"{said}; followed through 6 states of {states} bytes" in text
    path.write_bytes(walk(of_map)[:-1])
    assert cli.main([*arguments, "--json"]) == 1
    report = json.loads(capsys.readouterr().out)
    assert report["packets"]["packets"] == 4
    assert (report["packets"]["states"], report["packets"]["seconds"]) == (0, 0.0)
    assert cli.main([str(tileset), "--packets", str(tileset.with_name("none.vep"))]) == 2
    assert "none.vep: no such file" in capsys.readouterr().err


def test_packets_for_a_tileset_that_is_not_valid_are_not_judged(tmp_path: Path) -> None:
    small = Small()
    small.extension["pvs"]["listed"] += 1
    found = verdicts(small.write(tmp_path), b"")
    assert set(found.values()) == {("not run", "provenance/totals: fail")}


def test_what_takes_too_long_or_too_much_is_not_examined(tileset: Path, of_map: bytes) -> None:
    data = walk(of_map)
    largest = len(canonical(of_map, 0, 1, SETS[0]))
    for settings, enough in (("packet_memory", 2 * largest), ("packet_bytes", 3 * largest)):
        assert verdicts(tileset, data, **{settings: enough})["packet/exact"] == ("pass", "")
        found = verdicts(tileset, data, **{settings: largest - 1})
        assert found["packet/before"] == ("pass", "")
        assert found["packet/body"][0] == "not run"
        assert f"more than {largest - 1} bytes" in found["packet/body"][1]
        assert found["packet/exact"] == ("not run", "packet/geometry: not run")


def test_states_are_let_go_after_their_last_use(tileset: Path, of_map: bytes) -> None:
    data = walk(of_map)
    largest = len(canonical(of_map, 0, 1, SETS[0]))
    assert verdicts(tileset, data * 50, packet_memory=3 * largest)["packet/exact"] == ("pass", "")


def test_a_state_that_is_made_twice_is_held_once(tileset: Path, of_map: bytes) -> None:
    first, rest = walk(of_map)[: len(walk(of_map, BODIES[:1]))], walk(of_map)[len(walk(of_map, BODIES[:1])) :]
    largest = len(canonical(of_map, 0, 1, SETS[0]))
    assert verdicts(tileset, first * 9 + rest, packet_memory=2 * largest)["packet/exact"] == ("pass", "")


def test_no_state_results_from_a_broken_packet(scene: Scene, of_map: bytes) -> None:
    """What applies to it is passed over, and what applies to a sound one with the same mark is not."""
    short = plain([], *(change(item, 1, [], [0]) for item in range(3)))
    found = follow(scene, walk(of_map, (short, *BODIES[1:])))
    assert {name: len(of) for name, of in found.items()} == {"packet/after": 1}
    key = walk(of_map, BODIES[:1])
    found = follow(scene, key + walk(of_map, (short, BODIES[1], BODIES[1])))
    assert {name: [one.where for one in of] for name, of in found.items()} == {
        "packet/after": [f"x packet 1 (byte {len(key)})"],
        "packet/body": [f"x packet 3 (byte {len(key) + len(walk(of_map, (short, BODIES[1])))})"],
    }


def test_truncations_are_refused(scene: Scene, of_map: bytes) -> None:
    data = walk(of_map)
    ends = {len(walk(of_map, BODIES[:n])) for n in (1, 2, 3)}
    for size in range(len(data)):
        found = follow(scene, data[:size])
        assert bool(found) == (size not in ends), size


def test_truncated_and_random_bodies_are_refused(scene: Scene, of_map: bytes) -> None:
    choice = random.Random(4)
    for size in range(len(KEY_BODY)):
        found = follow(scene, walk(of_map, (KEY_BODY[:size],)))
        assert list(found) == ["packet/body"], size
    seen = set()
    for _ in range(1500):
        data = bytearray(KEY_BODY)
        for _ in range(choice.randrange(1, 4)):
            data[choice.randrange(len(data))] = choice.randrange(256)
        if data != KEY_BODY:
            found = follow(scene, walk(of_map, (bytes(data),)))
            assert found
            seen |= found.keys()
    assert seen == {"packet/body", "packet/after"}  # nothing else is judged without the mark


def test_random_bytes_do_not_crash(scene: Scene, of_map: bytes) -> None:
    choice, whole = random.Random(7), walk(of_map)
    refused = 0
    for _ in range(1500):
        data = bytearray(whole)
        for _ in range(choice.randrange(1, 5)):
            data[choice.randrange(len(data))] = choice.randrange(256)
        refused += bool(follow(scene, bytes(data)))
    assert refused > 1400  # the map is compared elsewhere
    for _ in range(300):
        assert follow(scene, b"vep1" + choice.randbytes(choice.randrange(200)))


def test_more_than_the_tileset_has(scene: Scene, of_map: bytes) -> None:
    other = struct.pack("<IBBH", 3, 0, 0, 1) + numbers([]) + numbers([0]) + geometry(0, [0])
    found = scene.fault(Part(3, 0, 0, np.zeros(1, np.uint32), np.zeros((1, 3, 3), np.int32)))
    assert found == "object 3 of 3"
    body = plain([], *(change(item, 1, [], [0]) for item in range(3)), other)
    found = follow(scene, walk(of_map, (body,)))
    assert [one.measured for one in found["packet/geometry"]] == ["body: 4 objects"]


def test_no_more_faces_than_a_state_may_have(scene: Scene, of_map: bytes, monkeypatch: Any) -> None:
    monkeypatch.setattr(packetparts, "MAX_FACES", 5)
    assert follow(scene, walk(of_map)) == {}
    monkeypatch.setattr(packetparts, "MAX_FACES", 4)
    (finding,) = follow(scene, walk(of_map, BODIES[:1]))["packet/body"]
    assert (finding.measured, finding.allowed) == ("body: 5 faces are held", "at most 4")


def test_findings_name_a_few(scene: Scene, of_map: bytes) -> None:
    name = (0, mark(of_map, 0, 1, {0: [0]}))
    data = packet(of_map, ((KEY, bytes(8)), name), 3, deflated(plain([], change(0, 1, [], [0]))))
    (finding,) = follow(scene, data)["packet/conservative"]
    lacks = "lacks object 1 of level 0; object 2 of level 0; object 0, level 0, face 1"
    assert (finding.where, finding.measured) == ("x packet 0 (byte 0)", lacks)


def test_more_findings_than_are_named(scene: Scene, of_map: bytes, monkeypatch: Any) -> None:
    monkeypatch.setattr(packetjudge, "NAMED", 2)
    name = (1, mark(of_map, 1, 1, {}))
    data = packet(of_map, ((KEY, bytes(8)), name), 3, deflated(plain([])))
    (finding,) = follow(scene, data)["packet/conservative"]
    assert finding.measured == "lacks object 0 of level 0; object 1 of level 0"
    monkeypatch.setattr(packetjudge, "NAMED", 1)
    (finding,) = follow(scene, data)["packet/conservative"]
    assert finding.measured == "lacks object 0 of level 0 and more"


def test_faces_have_one_form() -> None:
    choice = np.random.default_rng(3)
    faces = choice.integers(-2, 3, (3000, 3, 3)).astype(np.int32)
    wanted = [smallest(tuple(map(tuple, face))) for face in faces.tolist()]
    assert packetparts.turned(faces).tolist() == [list(map(list, face)) for face in wanted]
    extreme = np.array([[[2**31 - 1, 0, 0], [-(2**31), 0, 0], [0, 0, 0]]], np.int32)
    assert packetparts.turned(extreme)[0, 0, 0] == -(2**31)


def test_marks_are_those_of_canonical_bytes(of_map: bytes) -> None:
    held = {
        item: Part(
            item,
            0,
            0,
            np.array(faces, np.uint32),
            np.array([smallest(OBJECTS[item][f]) for f in faces], np.int32),
        )
        for item, faces in reversed(SETS[0].items())
    }
    assert packetparts.mark(of_map, 7, True, held) == mark(of_map, 7, 1, SETS[0])
    assert packetparts.mark(of_map, 7, False, held) == mark(of_map, 7, 0, SETS[0])
    assert packetparts.size(held.values()) == len(canonical(of_map, 7, 1, SETS[0]))


@pytest.mark.parametrize("stated", [2**28 + 1, 1032 * 20 + 1])
def test_lengths_that_deflate_cannot_reach_are_refused_at_once(stated: int) -> None:
    size = 19 if stated < 2**20 else 2**19
    with pytest.raises(BodyError, match="bytes when inflated, allowed is at most"):
        packetplain.inflated(memoryview(struct.pack("<I", stated) + bytes(size)))


def test_a_stream_that_is_as_short_as_can_be() -> None:
    data = zlib.compress(bytes(2**20), 9)
    body = struct.pack("<I", 2**20) + data
    assert packetplain.inflated(memoryview(body)) == bytes(2**20)
    with pytest.raises(BodyError, match="allowed is 1048575, as stated"):
        packetplain.inflated(memoryview(struct.pack("<I", 2**20 - 1) + data))


def test_without_packets_their_class_is_left_out(tileset: Path) -> None:
    assert failed(judge(tileset, Settings(rays=100))) == []
    assert "packet/body" not in {j.requirement.id for j in judge(tileset, Settings(rays=0)).judgements}
