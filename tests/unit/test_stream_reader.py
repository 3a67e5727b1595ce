"""What the writer has written is read back; what is not sound is refused before it is used."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_tileset_small_map import small_map

from tilesnav_ref.cells import planes
from tilesnav_ref.stream.container import parse_container
from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.reader import NavTileset, open_tileset
from tilesnav_ref.stream.sector import Limits, open_sector
from tilesnav_ref.stream.state import apply_delta
from tilesnav_ref.tileset.model import TilesetSettings
from tilesnav_ref.tileset.write import write_tileset

LIMITS = Limits(cells=3, faces=5, objects=3, levels=16)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A tileset of two sectors."""
    return _write(tmp_path / "out", 2)


def _write(folder: Path, cells_per_sector: int) -> Path:
    folder.mkdir()
    one = small_map()
    write_tileset(folder, one, planes(one.cells, one.scene.step), TilesetSettings(cells_per_sector))
    return folder


@pytest.mark.parametrize("cells_per_sector", [1, 2, 3])
def test_everything_comes_back(tmp_path: Path, cells_per_sector: int) -> None:
    tileset, one = open_tileset(_write(tmp_path / "out", cells_per_sector)), small_map()
    assert (tileset.cell_count, tileset.portal_count, tileset.face_count, tileset.object_count) == (
        3,
        4,
        5,
        3,
    )
    assert (tileset.step, tileset.clearance) == (2.0**-10, 0.25)
    assert np.array_equal(
        np.concatenate([s.planes for s in tileset.sectors]), planes(one.cells, one.scene.step)
    )
    assert np.concatenate([s.kinds for s in tileset.sectors]).tolist() == [1, 1, 0]
    assert [tileset.neighbours(cell).tolist() for cell in range(3)] == [[1], [0, 2], [1]]
    assert [tileset.state(cell).faces.tolist() for cell in range(3)] == [[0, 1, 2], [0, 2, 3, 4], [4]]
    assert tileset.object_offsets.tolist() == [0, 2, 4, 5]
    corners = np.concatenate([tileset.corners(0), tileset.corners(1)]).astype(np.float64)
    assert np.array_equal(corners / tileset.step, one.scene.corners())
    assert tileset.portal_polygon(1, 2).tolist() == tileset.portal_polygon(2, 1).tolist()
    assert tileset.portal_polygon(2, 1).tolist() == [[5, 1, 1], [5, 3, 1], [5, 3, 3], [5, 1, 3]]


@pytest.mark.parametrize("cells_per_sector", [1, 3])
def test_a_walk_with_a_cycle_keeps_to_the_digests(tmp_path: Path, cells_per_sector: int) -> None:
    tileset = open_tileset(_write(tmp_path / "out", cells_per_sector))
    state = tileset.state(0)
    for source, target in ((0, 1), (1, 2), (2, 1), (1, 0), (0, 1), (1, 2)):
        state = apply_delta(state, tileset.delta(source, target), tileset.object_offsets)
        assert state.digest() == tileset.digest(target) == tileset.state(target).digest()


def test_tables_are_mapped_not_copied(folder: Path) -> None:
    planes_of_first = open_tileset(folder).sectors[0].planes
    assert not planes_of_first.flags.owndata
    assert not planes_of_first.flags.writeable


def test_the_entry_file_itself_may_be_named(folder: Path) -> None:
    assert open_tileset(folder / "tileset.json").cell_count == 3


def test_cells_and_portals_that_are_not_there(folder: Path) -> None:
    tileset = open_tileset(folder)
    with pytest.raises(IndexError, match="cell 3"):
        tileset.state(3)
    with pytest.raises(KeyError, match="no portal"):
        tileset.delta(0, 2)


def test_every_truncation_of_a_nav_file_is_refused(tmp_path: Path) -> None:
    data = np.frombuffer((_write(tmp_path / "out", 3) / "nav" / "0.nav").read_bytes(), dtype=np.uint8)
    parse_container(data, "whole")
    for length in range(len(data)):
        with pytest.raises(TilesetError):
            parse_container(data[:length], "short")


def test_every_truncation_of_a_glb_is_refused(folder: Path) -> None:
    path = folder / "contents" / "0.glb"
    data = path.read_bytes()
    for length in range(0, len(data), 7):
        path.write_bytes(data[:length])
        with pytest.raises(TilesetError):
            _ = open_tileset(folder).object_offsets


def _edit_nav(edit: Callable[[dict[str, Any]], None]) -> Callable[[Path], None]:
    """Change the JSON part of the first nav file and keep the container around it sound."""

    def change(folder: Path) -> None:
        path = folder / "nav" / "0.nav"
        data = path.read_bytes()
        json_length, binary_length = struct.unpack_from("<QQ", data, 8)
        document = json.loads(data[24 : 24 + json_length])
        edit(document)
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 8)
        path.write_bytes(
            struct.pack("<4sIQQ", b"nav1", 1, len(text), binary_length) + text + data[24 + json_length :]
        )

    return change


def _edit_entry(edit: Callable[[dict[str, Any]], None]) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        path = folder / "tileset.json"
        document = json.loads(path.read_text())
        edit(document)
        path.write_text(json.dumps(document))

    return change


def _nav(document: dict[str, Any]) -> dict[str, Any]:
    entry: dict[str, Any] = document["extensions"]["3DTILES_nav"]
    return entry


def _patch(offset: int, data: bytes) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        path = folder / "nav" / "0.nav"
        old = path.read_bytes()
        begin = offset if offset >= 0 else len(old) + offset
        path.write_bytes(old[:begin] + data + old[begin + len(data) :])

    return change


def _swap_values(group: str, name: str, values: list[int], code: str = "I") -> Callable[[Path], None]:
    """Overwrite the beginning of a table of the first nav file."""

    def change(folder: Path) -> None:
        path = folder / "nav" / "0.nav"
        data = bytearray(path.read_bytes())
        json_length = struct.unpack_from("<Q", data, 8)[0]
        document = json.loads(data[24 : 24 + json_length])
        begin = 24 + json_length + document["bufferViews"][document[group][name]]["byteOffset"]
        struct.pack_into(f"<{len(values)}{code}", data, begin, *values)
        path.write_bytes(data)

    return change


def _chain(folder: Path, names: list[str]) -> None:
    """External tilesets, each with the next as its content."""
    for name, following in zip(names, [*names[1:], names[0]], strict=True):
        tile = {"geometricError": 0, "content": {"uri": following}}
        (folder / name).write_text(json.dumps({"root": tile}))


def _cycle(folder: Path) -> None:
    _chain(folder, ["a.json", "b.json"])
    _edit_entry(lambda d: d["root"].update(content={"uri": "a.json"}))(folder)


def _deep(folder: Path) -> None:
    _chain(folder, [f"{i}.json" for i in range(40)])
    _edit_entry(lambda d: d["root"].update(content={"uri": "0.json"}))(folder)


def _link_out(folder: Path) -> None:
    (folder.parent / "secret.nav").write_bytes((folder / "nav" / "0.nav").read_bytes())
    (folder / "nav" / "0.nav").unlink()
    (folder / "nav" / "0.nav").symlink_to(folder.parent / "secret.nav")


BAD = {
    "no entry object": (_edit_entry(lambda d: d.pop("extensions")), "no navigation data"),
    "not json": (lambda f: (f / "tileset.json").write_text("{"), "no JSON"),
    "not utf-8": (lambda f: (f / "tileset.json").write_bytes(b'{"a":"\xff"}'), "no JSON"),
    "an array": (lambda f: (f / "tileset.json").write_text("[]"), "a JSON object"),
    "nan": (lambda f: (f / "tileset.json").write_text('{"a":NaN}'), "NaN is not a JSON number"),
    "deep json": (lambda f: (f / "tileset.json").write_text('{"a":' + "[" * 99999), "no JSON"),
    "later version": (_edit_entry(lambda d: _nav(d).update(version="1.0.0")), "0.1.x"),
    "negative count": (_edit_entry(lambda d: _nav(d).update(cellCount=-1)), "cellCount: found -1"),
    "huge count": (_edit_entry(lambda d: _nav(d).update(faceCount=2**31 + 1)), "faceCount"),
    "true is no number": (_edit_entry(lambda d: _nav(d).update(portalCount=True)), "portalCount: found true"),
    "faces missing": (_edit_entry(lambda d: _nav(d).update(faceCount=6)), "sum over the contents"),
    "portals missing": (_edit_entry(lambda d: _nav(d).update(portalCount=5)), "4 portals"),
    "cell missing": (_edit_entry(lambda d: _nav(d)["sectors"].pop()), "2 cells"),
    "sector twice": (
        _edit_entry(lambda d: _nav(d)["sectors"].insert(0, _nav(d)["sectors"][0])),
        "cells from 0",
    ),
    "short transform": (_edit_entry(lambda d: _nav(d)["transform"].pop()), "array of 16 numbers"),
    "infinite transform": (
        _edit_entry(lambda d: _nav(d)["transform"].__setitem__(0, 10**400)),
        "finite number",
    ),
    "path up": (_edit_entry(lambda d: _nav(d)["sectors"][0].update(uri="../x.nav")), "stays inside"),
    "encoded path up": (
        _edit_entry(lambda d: _nav(d)["sectors"][0].update(uri="%2e%2e/x.nav")),
        "stays inside",
    ),
    "absolute path": (_edit_entry(lambda d: _nav(d)["sectors"][0].update(uri="/etc/passwd")), "stays inside"),
    "scheme": (_edit_entry(lambda d: _nav(d)["sectors"][0].update(uri="file:///etc/passwd")), "stays inside"),
    "host": (_edit_entry(lambda d: _nav(d)["sectors"][0].update(uri="//host/x")), "stays inside"),
    "backslash": (_edit_entry(lambda d: _nav(d)["sectors"][0].update(uri="..\\x")), "stays inside"),
    "link out": (_link_out, "stays inside"),
    "no such file": (_edit_entry(lambda d: _nav(d)["sectors"][0].update(uri="nav/9.nav")), "readable file"),
    "a folder": (_edit_entry(lambda d: _nav(d)["sectors"][0].update(uri="nav")), "readable file"),
    "cyclic tilesets": (_cycle, "without a cycle"),
    "deep tilesets": (_deep, "at most 32"),
    "content id twice": (
        _edit_entry(lambda d: d["root"]["children"].append(d["root"]["children"][0])),
        "each once",
    ),
    "magic": (_patch(0, b"NAV1"), "magic"),
    "container version": (_patch(4, struct.pack("<I", 2)), "version: found 2"),
    "big-endian": (_patch(4, struct.pack(">IQQ", 1, 8, 8)), "version"),
    "10 GB claimed": (_patch(16, struct.pack("<Q", 10 << 30)), "a claim of"),
    "JSON length claimed": (_patch(8, struct.pack("<Q", 1 << 62)), "at most 67108864"),
    "odd length": (_patch(8, struct.pack("<Q", 801)), "multiples of 8"),
    "two buffers": (_edit_nav(lambda d: d["buffers"].append({"byteLength": 0})), "exactly one"),
    "buffer uri": (_edit_nav(lambda d: d["buffers"][0].update(uri="x")), "exactly one"),
    "buffer too long": (_edit_nav(lambda d: d["buffers"][0].update(byteLength=10**6)), "byteLength"),
    "buffer too short": (_edit_nav(lambda d: d["buffers"][0].update(byteLength=8)), "less than 8 zero bytes"),
    "view beyond": (_edit_nav(lambda d: d["bufferViews"][0].update(byteLength=10**6)), "byteLength"),
    "view not aligned": (_edit_nav(lambda d: d["bufferViews"][0].update(byteOffset=4)), "multiple of 8"),
    "views overlap": (_edit_nav(lambda d: d["bufferViews"][1].update(byteOffset=0)), "do not overlap"),
    "other buffer": (_edit_nav(lambda d: d["bufferViews"][0].update(buffer=1)), "buffer: found 1"),
    "no such view": (_edit_nav(lambda d: d["cells"].update(planes=99)), "found 99"),
    "view of two tables": (_edit_nav(lambda d: d["deltas"].update(left=d["deltas"]["entered"])), "bytes"),
    "same view": (
        _edit_nav(lambda d: d["deltas"].update(leftOffsets=d["deltas"]["enteredOffsets"])),
        "one table",
    ),
    "count and table": (_edit_nav(lambda d: d["portals"].update(polygonCount=3)), "bytes, for"),
    "member missing": (_edit_nav(lambda d: d["pvs"].pop("digests")), "required"),
    "table missing": (_edit_nav(lambda d: d.pop("lod")), "required"),
    "cells of another sector": (_edit_nav(lambda d: d["sector"].update(firstCell=1)), "cells from 1"),
    "offsets begin": (_swap_values("pvs", "offsets", [1]), "that do not decrease"),
    "offsets fall": (_swap_values("pvs", "offsets", [0, 8, 7]), "that do not decrease"),
    "offsets end": (_swap_values("pvs", "offsets", [0, 3, 6]), "that do not decrease"),
    "face out of range": (_swap_values("pvs", "faces", [0, 1, 5]), "less than 5"),
    "faces not sorted": (_swap_values("pvs", "faces", [0, 2, 1]), "ascending"),
    "face twice": (_swap_values("pvs", "faces", [0, 1, 1]), "ascending"),
    "target out of range": (_swap_values("portals", "targets", [3]), "less than 3"),
    "polygon out of range": (_swap_values("portals", "polygons", [2]), "less than 2"),
    "kind": (_swap_values("cells", "kinds", [2], "B"), "less than 2"),
    "code": (_swap_values("lod", "codes", [16], "B"), "less than 16"),
    "switch code": (_swap_values("deltas", "switchCodes", [16], "B"), "less than 16"),
    "plane": (_swap_values("cells", "planes", [float("nan")], "d"), "finite numbers"),
    "entered not sorted": (_swap_values("deltas", "entered", [4, 3]), "ascending"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_tilesets_are_refused(folder: Path, name: str) -> None:
    change, message = BAD[name]
    change(folder)
    with pytest.raises(TilesetError, match=message):
        open_tileset(folder)


def test_a_content_with_other_counts_is_refused(folder: Path) -> None:
    (folder / "contents" / "1.glb").write_bytes((folder / "contents" / "0.glb").read_bytes())
    with pytest.raises(TilesetError, match="4 faces in 2 primitives; allowed: 1 faces in 1 primitives"):
        _ = open_tileset(folder).object_offsets


def test_external_tilesets_are_followed(folder: Path) -> None:
    document = json.loads((folder / "tileset.json").read_text())
    last = document["root"]["children"].pop()
    last["content"]["uri"] = "../" + last["content"]["uri"]
    (folder / "sub").mkdir()
    (folder / "sub" / "more.json").write_text(json.dumps({"root": last}))
    document["root"]["children"].append({"geometricError": 0, "contents": [{"uri": "sub/more.json"}]})
    (folder / "tileset.json").write_text(json.dumps(document))
    assert open_tileset(folder).object_offsets.tolist() == [0, 2, 4, 5]


@pytest.fixture(scope="module")
def nav_bytes(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A nav file of all three cells."""
    return (_write(tmp_path_factory.mktemp("map") / "out", 3) / "nav" / "0.nav").read_bytes()


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_damaged_nav_file_is_read_or_refused_never_worse(
    nav_bytes: bytes, tmp_path: Path, data: st.DataObject
) -> None:
    damaged = bytearray(nav_bytes)
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path / "damaged.nav"
    path.write_bytes(damaged)
    try:
        sector = open_sector(path, LIMITS)
    except TilesetError:
        return
    assert all(int(row.max(initial=0)) < LIMITS.faces for row in (sector.faces.values, sector.entered.values))


def test_opened_tileset_is_frozen(folder: Path) -> None:
    tileset: NavTileset = open_tileset(folder)
    with pytest.raises(AttributeError):
        tileset.step = 1.0  # type: ignore[misc]
