"""Nav files that are cut short, damaged, or claim what they do not hold."""

from __future__ import annotations

import json
import struct
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from validator_fixture import Small, failures, pack_nav, pack_tables, tables

from tilesnav_validator.findings import Settings
from tilesnav_validator.navfile import NavFile
from tilesnav_validator.runner import judge


def test_small_tileset_passes_every_requirement(tmp_path: Path) -> None:
    result = judge(Small().write(tmp_path), Settings(rays=2000))
    verdicts = {j.requirement.id: (j.verdict, j.findings) for j in result.judgements}
    assert verdicts.pop("pvs/conservative")[0] == "not refuted"
    assert {name: found for name, found in verdicts.items() if found[0] != "pass"} == {}


def test_every_truncation_is_a_finding_about_the_header(tmp_path: Path) -> None:
    whole = pack_nav(*pack_tables(tables()))
    small = Small()
    for length in range(len(whole)):
        assert NavFile("x", memoryview(whole[:length])).header_fault() is not None, length
    for length in range(0, len(whole), 101):
        small.nav = whole[:length]
        assert failures(small.write(tmp_path), rays=0) == ["container/header"], length
    assert NavFile("x", memoryview(whole)).header_fault() is None


@pytest.mark.parametrize("seed", range(4))
def test_random_damage_never_ends_in_an_error(tmp_path: Path, seed: int) -> None:
    whole = pack_nav(*pack_tables(tables()))
    random = np.random.default_rng(seed)
    small, silent = Small(), 0
    for _ in range(60):
        damaged = bytearray(whole)
        for place in random.integers(len(whole), size=random.integers(1, 4)):
            damaged[place] = random.integers(256)
        small.nav = bytes(damaged)
        silent += not failures(small.write(tmp_path), rays=100)
    assert silent < 20  # a changed byte of JSON white space or of unused padding is no fault


CLAIMS = {
    "buffer": ("buffers", 0, "byteLength", 10 * 2**30, "container/buffer-views"),
    "view": ("bufferViews", 3, "byteLength", 10 * 2**30, "container/buffer-views"),
    "view offset": ("bufferViews", 3, "byteOffset", 2**63 - 8, "container/buffer-views"),
    "cells": ("sector", "cellCount", 2**31, "container/table-lengths"),
    "cells 2^63": ("sector", "cellCount", 2**63, "container/json"),
    "portals": ("portals", "count", 2**31, "container/table-lengths"),
    "faces": ("pvs", "count", 2**31 - 1, "container/table-lengths"),
    "view of a table": ("pvs", "faces", 2**63, "container/table-lengths"),
    "huge float": ("pvs", "count", 1e300, "container/json"),
}


@pytest.mark.parametrize("claim", CLAIMS.values(), ids=CLAIMS.keys())
def test_claims_are_checked_before_memory_is_taken(tmp_path: Path, claim: tuple[Any, ...]) -> None:
    root, binary = pack_tables(tables())
    *path, value, requirement = claim
    node: Any = root
    for part in path[:-1]:
        node = node[part]
    node[path[-1]] = value
    small = Small(nav=pack_nav(root, binary))
    entry = small.write(tmp_path)
    failures(entry, rays=0)  # imports
    tracemalloc.start()
    try:
        assert failures(entry, rays=0) == [requirement]
        assert tracemalloc.get_traced_memory()[1] < 8 * 2**20
    finally:
        tracemalloc.stop()


def test_lengths_in_the_header_near_2_63(tmp_path: Path) -> None:
    whole = pack_nav(*pack_tables(tables()))
    for json_bytes, binary_bytes in (
        (2**63, 2**63),
        (2**64 - 8, 2**64 - 8),
        (len(whole), 0),
        (0, len(whole) - 24),
    ):
        small = Small(nav=struct.pack("<4sIQQ", b"nav1", 1, json_bytes, binary_bytes) + whole[24:])
        expected = "container/json" if json_bytes == 0 else "container/header"
        assert failures(small.write(tmp_path), rays=0) == [expected]


@pytest.mark.parametrize(
    ("header", "requirement"),
    [
        ((b"nav2", 1), "container/header"),
        ((b"nav1", 2), "container/header"),
        ((b"nav1", 1 << 24), "container/header"),
    ],
)
def test_foreign_headers(tmp_path: Path, header: tuple[bytes, int], requirement: str) -> None:
    whole = pack_nav(*pack_tables(tables()))
    small = Small(nav=struct.pack("<4sI", *header) + whole[8:])
    assert failures(small.write(tmp_path), rays=0) == [requirement]


def _repack(root: dict[str, Any], binary: bytes, json_tail: bytes, binary_tail: bytes) -> bytes:
    text = json.dumps(root).encode() + json_tail
    return (
        struct.pack("<4sIQQ", b"nav1", 1, len(text), len(binary + binary_tail)) + text + binary + binary_tail
    )


def test_padding(tmp_path: Path) -> None:
    root, binary = pack_tables(tables())
    room = -len(json.dumps(root)) % 8 + 8
    free = -len(binary) % 8
    assert free, "the fixture must leave room for padding"
    good = b"\0" * free
    cases = [
        (b" " * room, good, []),
        (b"\n" + b" " * (room - 1), good, []),
        (b"\r\n" + b" " * (room - 2), good, []),
        (b" " * (room - 1) + b"\0", good, ["container/padding"]),
        (b" " * (room - 1) + b"\t", good, ["container/padding"]),
        (b" " * (room - 1), good, ["container/padding"]),
        (b" " * (room - 1) + b"x", good, ["container/json"]),
        (b" " * room, b"\0" * (free - 1) + b"\1", ["container/padding"]),
        (b" " * room, b"", ["container/padding"]),
        (b" " * room, good + b"\0" * 8, ["container/buffer-views"]),
    ]
    for json_tail, binary_tail, expected in cases:
        small = Small(nav=_repack(root, binary, json_tail, binary_tail))
        assert failures(small.write(tmp_path), rays=0) == expected, (json_tail, binary_tail)


def test_a_name_that_stands_twice(tmp_path: Path) -> None:
    nav = pack_nav(*pack_tables(tables())).replace(b'"count": 2,', b'"count": 2,"count": 2,', 1)
    text, binary = (int(number) for number in struct.unpack_from("<QQ", nav, 8))
    text += len(b'"count": 2,')
    spare = -text % 8
    lengths = struct.pack("<QQ", text + spare, binary)
    nav = nav[:8] + lengths + nav[24 : 24 + text] + b" " * spare + nav[24 + text :]
    assert failures(Small(nav=nav).write(tmp_path), rays=0) == ["container/json"]


def test_views_and_tables(tmp_path: Path) -> None:
    def changed(change: Any) -> list[str]:
        root, binary = pack_tables(tables())
        change(root)
        return failures(Small(nav=pack_nav(root, binary)).write(tmp_path), rays=0)

    def unaligned(root: dict[str, Any]) -> None:
        root["bufferViews"][1]["byteOffset"] += 4

    def shared(root: dict[str, Any]) -> None:
        root["bufferViews"][3]["byteOffset"] = root["bufferViews"][2]["byteOffset"]

    def same_view(root: dict[str, Any]) -> None:
        root["portals"]["polygons"] = root["portals"]["targets"]

    def two_buffers(root: dict[str, Any]) -> None:
        root["buffers"] *= 2

    def seven_planes(root: dict[str, Any]) -> None:
        root["bufferViews"][0]["byteLength"] -= 32

    def unused(root: dict[str, Any]) -> None:
        root["bufferViews"].append({"buffer": 0, "byteOffset": 0, "byteLength": 0})

    def unused_within(root: dict[str, Any]) -> None:
        root["bufferViews"].append(dict(root["bufferViews"][0]))

    def empty_behind(root: dict[str, Any]) -> None:
        end = root["buffers"][0]["byteLength"]
        assert end % 8
        root["bufferViews"].append({"buffer": 0, "byteOffset": -(-end // 8) * 8, "byteLength": 0})

    def empty_too_far(root: dict[str, Any]) -> None:
        empty_behind(root)
        root["bufferViews"][-1]["byteOffset"] += 8

    assert changed(unused) == []
    assert changed(unused_within) == ["container/buffer-views"]
    assert changed(empty_behind) == []
    assert changed(empty_too_far) == ["container/buffer-views"]
    assert changed(unaligned) == ["container/buffer-views"]
    assert changed(shared) == ["container/buffer-views"]
    assert changed(same_view) == ["container/table-lengths"]
    assert changed(two_buffers) == ["container/json"]
    assert changed(seven_planes) == ["cell/exactly-six-planes"]


@pytest.mark.parametrize(
    ("table", "index", "value"),
    [("offsets", 0, 1), ("offsets", 1, 12), ("offsets", 2, 8), ("offsets", 1, 2**32 - 1)],
)
def test_offsets(tmp_path: Path, table: str, index: int, value: int) -> None:
    small = Small()
    small.groups["pvs"][table][index] = value
    assert failures(small.write(tmp_path), rays=0) == ["container/offsets"]


def test_counts_of_sectors(tmp_path: Path) -> None:
    for name, value in (("cellCount", 3), ("portalCount", 3)):
        small = Small()
        small.extension[name] = value
        assert failures(small.write(tmp_path), rays=0) == ["container/sector-counts"]
    for name, value in (("cellCount", 3), ("firstCell", 1)):
        small = Small()
        small.extension["sectors"][0][name] = value
        assert failures(small.write(tmp_path), rays=0) == ["container/sector-counts"]
    root, binary = pack_tables(tables())
    root["sector"]["firstCell"] = 1
    small = Small(nav=pack_nav(root, binary))
    small.extension["sectors"][0]["firstCell"] = 1
    assert failures(small.write(tmp_path), rays=0) == ["container/sector-counts"]
