"""States, digests, deltas, totals: one fault each, found under its own requirement."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from validator_fixture import Small, failures

from tilesnav_validator import ragged
from tilesnav_validator.checks import deltas

Groups = dict[str, dict[str, Any]]


def put(group: str, member: str, value: Any) -> Callable[[Groups], None]:
    def change(groups: Groups) -> None:
        groups[group][member] = value

    return change


FAULTS = {
    "order of faces": (put("pvs", "faces", [1, 0, 2, 3, 4, 0, 1, 2, 3]), {"pvs/sorted-faces", "pvs/digest"}),
    "face twice": (put("pvs", "faces", [0, 1, 2, 3, 4, 0, 1, 1, 3]), {"pvs/sorted-faces", "pvs/digest"}),
    "face out of range": (
        put("pvs", "faces", [0, 1, 2, 3, 5, 0, 1, 2, 3]),
        {"pvs/sorted-faces", "pvs/digest"},
    ),
    "big-endian": (
        put("pvs", "provenVisible", [4 << 24, 4]),
        {"pvs/proven-within-listed", "provenance/totals"},
    ),
    "missing object": (
        put("lod", "objects", [0, 1, 2, 0, 2]),
        {"lod/objects-match", "pvs/digest"},
    ),
    "order of objects": (put("lod", "objects", [1, 0, 2, 0, 1]), {"lod/objects-match", "pvs/digest"}),
    "entered missing": (
        lambda groups: groups["deltas"].update(enteredOffsets=[0, 0, 0], entered=[]),
        {"delta/identity"},
    ),
    "entered other": (put("deltas", "entered", [3]), {"delta/identity"}),
    "left other": (put("deltas", "left", [0]), {"delta/identity"}),
    "entered and left swapped": (
        lambda groups: groups["deltas"].update(enteredOffsets=[0, 1, 1], leftOffsets=[0, 0, 1]),
        {"delta/identity"},
    ),
    "entered out of range": (put("deltas", "entered", [5]), {"delta/sorted"}),
    "switch out of range": (put("deltas", "switchObjects", [3, 1, 2]), {"delta/sorted"}),
    "switches not sorted": (put("deltas", "switchObjects", [1, 2, 1]), {"delta/sorted"}),
    "switch out of range twice": (put("deltas", "switchObjects", [1, 5, 5]), {"delta/sorted"}),
    "switch twice": (put("deltas", "switchObjects", [1, 1, 1]), {"delta/sorted"}),
    "switch of another": (put("deltas", "switchObjects", [0, 1, 2]), {"delta/switches"}),
    "switch code": (put("deltas", "switchCodes", [1, 3, 14]), {"delta/switches"}),
    "switch that changes nothing": (
        lambda groups: groups["deltas"].update(
            switchOffsets=[0, 2, 4], switchObjects=[0, 1, 1, 2], switchCodes=[1, 1, 3, 15]
        ),
        {"delta/switches"},
    ),
}


@pytest.mark.parametrize(("change", "expected"), FAULTS.values(), ids=FAULTS.keys())
def test_faults(tmp_path: Path, change: Callable[[Groups], None], expected: set[str]) -> None:
    small = Small()
    change(small.groups)
    assert set(failures(small.write(tmp_path), rays=0)) == expected


def test_one_bit_of_a_digest(tmp_path: Path) -> None:
    small = Small()
    small.groups["pvs"]["digests"][1][31] ^= 1
    assert failures(small.write(tmp_path), rays=0) == ["pvs/digest"]


@pytest.mark.parametrize("name", ["listed", "provenVisible"])
def test_totals(tmp_path: Path, name: str) -> None:
    small = Small()
    small.extension["pvs"][name] -= 1
    assert failures(small.write(tmp_path), rays=0) == ["provenance/totals"]


def test_deltas_in_small_portions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deltas, "_ELEMENTS", 1)
    monkeypatch.setattr(deltas, "_SCRATCH", 1)
    small = Small()
    assert failures(small.write(tmp_path), rays=0) == []
    small.groups["deltas"]["left"] = [0]
    assert failures(small.write(tmp_path), rays=0) == ["delta/identity"]


def test_paths_are_followed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the check of single deltas switched off, the composed ones must tell."""
    monkeypatch.setattr(deltas, "_differing", lambda *_: np.zeros(0, np.int64))
    small = Small()
    assert failures(small.write(tmp_path), rays=0) == []
    small.groups["deltas"].update(enteredOffsets=[0, 0, 0], entered=[])
    assert failures(small.write(tmp_path), rays=0) == ["delta/identity"]


def test_two_sectors(tmp_path: Path) -> None:
    """One cell a sector, the portal in both files with its own copy of the polygon."""

    def halves(vertices: Any) -> list[str]:
        small, other = Small(), Small()
        square = small.groups["portals"]["vertices"]
        for part, number in ((small, 0), (other, 1)):
            groups = part.groups
            for group, member in (
                ("cells", "planes"),
                ("cells", "kinds"),
                ("pvs", "provenVisible"),
                ("pvs", "digests"),
            ):
                groups[group][member] = groups[group][member][number : number + 1]
            for group, offsets, members in (
                ("portals", "offsets", ("targets", "polygons")),
                ("pvs", "offsets", ("faces",)),
                ("lod", "offsets", ("objects", "codes")),
                ("deltas", "enteredOffsets", ("entered",)),
                ("deltas", "leftOffsets", ("left",)),
                ("deltas", "switchOffsets", ("switchObjects", "switchCodes")),
            ):
                first, last = groups[group][offsets][number : number + 2]
                groups[group][offsets] = [0, last - first]
                for member in members:
                    groups[group][member] = groups[group][member][first:last]
        other.groups["portals"]["vertices"] = vertices or square
        sector = small.extension["sectors"][0]
        sectors = [{**sector, "cellCount": 1}, {**sector, "cellCount": 1, "firstCell": 1, "uri": "1.nav"}]
        small.extension["sectors"] = sectors
        second = other.write(tmp_path / "second").with_name("0.nav").read_bytes()
        path = small.write(tmp_path)
        patched = second.replace(b'"firstCell": 0', b'"firstCell": 1')
        (tmp_path / "1.nav").write_bytes(patched)
        return failures(path)

    assert halves(None) == []
    assert halves([[0, -2, 1], [0, 2, 1], [0, 2, 3], [0, -2, 3 + 2.0**-20]]) == ["portal/symmetric"]


def test_ragged_lists() -> None:
    offsets = np.array([0, 2, 2, 5])
    assert ragged.rows(offsets).tolist() == [0, 0, 2, 2, 2]
    values = np.array([1, 1, 0, 3, 2], dtype=np.uint32)
    assert ragged.not_ascending(values, offsets).tolist() == [1, 4]
    assert ragged.not_ascending(values[:1], np.array([0, 1])).tolist() == []
    position, index = ragged.take(offsets, np.array([2, 1, 0, 2]))
    assert position.tolist() == [0, 0, 0, 2, 2, 3, 3, 3]
    assert index.tolist() == [2, 3, 4, 0, 1, 2, 3, 4]
