"""Every table of the nav file of a small map, against numbers worked out by hand."""

from __future__ import annotations

import json
import struct
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from test_tileset_small_map import small_map

from tilesnav_ref.cells import planes
from tilesnav_ref.tileset import nav
from tilesnav_ref.tileset.delta import state_digests
from tilesnav_ref.tileset.errors import EncodeError
from tilesnav_ref.tileset.model import NavMap
from tilesnav_ref.tileset.nav import CellArrays, nav_file


def _file(one: NavMap, first: int, last: int) -> bytes:
    arrays = CellArrays(planes(one.cells, one.scene.step), state_digests(one.pvs, one.lod))
    return b"".join(nav_file(one, arrays, first, last))


def _parts(file: bytes) -> tuple[dict[str, Any], bytes]:
    json_length = struct.unpack_from("<Q", file, 8)[0]
    return json.loads(file[24 : 24 + json_length]), file[24 + json_length :]


def _table(parts: tuple[dict[str, Any], bytes], path: str, code: str) -> list[Any]:
    document, binary = parts
    group, name = path.split(".")
    view = document["bufferViews"][document[group][name]]
    data = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    return [x for (x,) in struct.iter_unpack(f"<{code}", data)]


INTEGERS = {
    "portals.offsets": [0, 1, 3, 4],
    "portals.targets": [1, 0, 2, 1],
    "portals.polygons": [0, 0, 1, 1],
    "portals.polygonOffsets": [0, 4, 8],
    "pvs.offsets": [0, 3, 7, 8],
    "pvs.faces": [0, 1, 2, 0, 2, 3, 4, 4],
    "pvs.provenVisible": [2, 3, 1],
    "lod.offsets": [0, 2, 5, 6],
    "lod.objects": [0, 1, 0, 1, 2, 2],
    "deltas.enteredOffsets": [0, 2, 3, 3, 6],
    "deltas.entered": [3, 4, 1, 0, 2, 3],
    "deltas.leftOffsets": [0, 1, 3, 6, 6],
    "deltas.left": [1, 3, 4, 0, 2, 3],
    "deltas.switchOffsets": [0, 2, 3, 3, 5],
    "deltas.switchObjects": [1, 2, 1, 0, 1],
}


@pytest.mark.parametrize("path", INTEGERS)
def test_integer_tables(path: str) -> None:
    assert _table(_parts(_file(small_map(), 0, 3)), path, "I") == INTEGERS[path]


def test_byte_tables_and_counts() -> None:
    parts = _parts(_file(small_map(), 0, 3))
    assert _table(parts, "cells.kinds", "B") == [1, 1, 0]
    assert _table(parts, "lod.codes", "B") == [2, 3, 2, 1, 5, 5]
    assert _table(parts, "deltas.switchCodes", "B") == [1, 5, 3, 2, 1]
    assert len(_table(parts, "pvs.digests", "B")) == 96
    document = parts[0]
    counts = [document["portals"][name] for name in ("count", "polygonCount", "vertexCount")]
    assert counts == [4, 2, 8]
    assert [document["pvs"]["count"], document["lod"]["count"]] == [8, 6]
    assert [document["deltas"][f"{name}Count"] for name in ("entered", "left", "switch")] == [6, 6, 5]
    assert document["sector"] == {"firstCell": 0, "cellCount": 3}


def test_planes_and_vertices_are_metres() -> None:
    parts = _parts(_file(small_map(), 0, 3))
    stored = np.array(_table(parts, "cells.planes", "d")).reshape(3, 6, 4)
    # Cell 0 is 1 to 3 m in every direction.
    inside, outside = np.array([2.0, 2.0, 2.0]), np.array([3.5, 2.0, 2.0])
    assert (stored[0, :, :3] @ inside + stored[0, :, 3]).tolist() == [-1.0] * 6
    assert (stored[0, :, :3] @ outside + stored[0, :, 3]).max() == 0.5
    vertices = np.array(_table(parts, "portals.vertices", "d")).reshape(2, 4, 3)
    assert vertices[1].tolist() == [[5, 1, 1], [5, 3, 1], [5, 3, 3], [5, 1, 3]]


def test_a_later_sector_has_offsets_of_its_own_and_only_its_polygons() -> None:
    parts = _parts(_file(small_map(), 2, 3))
    expected = {
        "portals.offsets": [0, 1],
        "portals.targets": [1],
        "portals.polygons": [0],
        "pvs.offsets": [0, 1],
        "pvs.faces": [4],
        "pvs.provenVisible": [1],
        "lod.objects": [2],
        "deltas.enteredOffsets": [0, 3],
        "deltas.entered": [0, 2, 3],
        "deltas.leftOffsets": [0, 0],
        "deltas.left": [],
        "deltas.switchObjects": [0, 1],
    }
    assert {path: _table(parts, path, "I") for path in expected} == expected
    vertices = np.array(_table(parts, "portals.vertices", "d")).reshape(-1, 3)
    assert set(vertices[:, 0]) == {5.0}
    assert parts[0]["sector"] == {"firstCell": 2, "cellCount": 1}


def test_more_than_readers_accept_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nav, "COUNT_LIMIT", 7)
    with pytest.raises(EncodeError, match=r"8 faces in the sets of cells.*at most 7.*--sector-cells"):
        _file(small_map(), 0, 3)


def test_no_portals_at_all() -> None:
    one = small_map()
    none = np.zeros(4, dtype=np.int64)
    empty = np.empty(0, dtype=np.int64)
    cells = replace(one.cells, portal_offsets=none, portal_targets=empty, portal_polygons=empty)
    deltas = replace(
        one.deltas,
        entered_offsets=none[:1],
        entered=empty,
        left_offsets=none[:1],
        left=empty,
        switch_offsets=none[:1],
        switch_objects=empty,
        switch_codes=empty,
    )
    parts = _parts(_file(replace(one, cells=cells, deltas=deltas), 0, 3))
    assert _table(parts, "portals.polygonOffsets", "I") == [0]
    assert _table(parts, "deltas.enteredOffsets", "I") == [0]
    assert parts[0]["portals"]["vertexCount"] == 0
