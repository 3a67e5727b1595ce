"""Trees of tiles: which contents count, where they are placed, and files that are followed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tileset_fixture import (
    TRIANGLE,
    Y_UP_TO_Z_UP,
    b3dm,
    cmpt,
    glb,
    model,
    moved,
    other_tile,
    tile,
    tileset,
    write,
)

from tilesnav_ref.scene import SceneError
from tilesnav_ref.scene.tiles import read_tileset

ONE = glb(*model())
FLAT = TRIANGLE @ Y_UP_TO_Z_UP.T
"""The triangle in the axes of a tile: (0, 0, 0), (4, 0, 0), (0, 3, 0)."""


def parts(path: Path, up: str = "auto") -> list[tuple[str, list[float]]]:
    """Name and first corner of every part."""
    return [(part.name, part.vertices[0].tolist()) for part in read_tileset(path, up, 1000).parts]


def names(path: Path) -> list[str]:
    return [name for name, _ in parts(path)]


def test_version_1_1_glb(tmp_path: Path) -> None:
    path = write(tmp_path, {"tileset.json": tileset(tile("a.glb")), "a.glb": ONE})
    mesh = read_tileset(path, "auto", 1000)
    assert [part.name for part in mesh.parts] == ["a.glb"]
    assert np.array_equal(mesh.parts[0].vertices, FLAT)
    assert mesh.parts[0].faces.tolist() == [[0, 1, 2]]


def test_version_1_0_b3dm(tmp_path: Path) -> None:
    old = {"asset": {"version": "1.0"}, "root": tile("a.b3dm", refine="add")}
    path = write(tmp_path, {"tileset.json": old, "a.b3dm": b3dm(ONE)})
    assert np.array_equal(read_tileset(path, "auto", 1000).parts[0].vertices, FLAT)


def test_transforms_multiply_from_the_root_down(tmp_path: Path) -> None:
    turned = [
        0,
        1,
        0,
        0,
        -1,
        0,
        0,
        0,
        0,
        0,
        1,
        0,
        100,
        0,
        0,
        1,
    ]  # x becomes y, y becomes -x; then 100 along x
    root = tile(transform=turned, children=[tile("a.glb", transform=moved(10, 20, 30))])
    path = write(tmp_path, {"tileset.json": tileset(root), "a.glb": ONE})
    found = read_tileset(path, "auto", 1000).parts[0].vertices
    assert np.array_equal(found, [[80, 10, 30], [80, 14, 30], [77, 10, 30]])


def refined(above: str, **leaf: Any) -> dict[str, Any]:
    root = tile("coarse.glb", children=[tile("left.glb", **leaf), tile("right.glb")])
    return tileset({**root, "refine": above})


THREE = {"coarse.glb": ONE, "left.glb": ONE, "right.glb": ONE}


def test_additive_refinement_keeps_parents(tmp_path: Path) -> None:
    path = write(tmp_path, {"tileset.json": refined("ADD"), **THREE})
    assert names(path) == ["coarse.glb", "left.glb", "right.glb"]


def test_replacement_keeps_the_finest(tmp_path: Path) -> None:
    path = write(tmp_path, {"tileset.json": refined("REPLACE"), **THREE})
    assert names(path) == ["left.glb", "right.glb"]
    assert "1 replaced by finer ones" in " ".join(read_tileset(path, "auto", 1000).notes)


def test_refinement_is_inherited_and_may_change(tmp_path: Path) -> None:
    left = {"refine": "ADD", "children": [tile("fine.glb")]}
    path = write(tmp_path, {"tileset.json": refined("REPLACE", **left), **THREE, "fine.glb": ONE})
    assert names(path) == ["left.glb", "fine.glb", "right.glb"]
    left = {"children": [tile("fine.glb")]}
    path = write(tmp_path, {"tileset.json": refined("REPLACE", **left), **THREE, "fine.glb": ONE})
    assert names(path) == ["fine.glb", "right.glb"]


def test_a_parent_stays_when_nothing_below_has_faces(tmp_path: Path) -> None:
    root = tile("coarse.glb", children=[tile(), tile("points.pnts")])
    files = {"tileset.json": tileset({**root, "refine": "REPLACE"}), "coarse.glb": ONE}
    assert names(write(tmp_path, {**files, "points.pnts": other_tile(b"pnts")})) == ["coarse.glb"]


def test_several_contents_of_a_tile(tmp_path: Path) -> None:
    root = tile(contents=[{"uri": "a.glb"}, {"uri": "b.glb"}])
    extended = tile(extensions={"3DTILES_multiple_contents": {"contents": [{"uri": "c.glb"}]}})
    root["children"] = [extended]
    path = write(tmp_path, {"tileset.json": tileset(root), "a.glb": ONE, "b.glb": ONE, "c.glb": ONE})
    assert names(path) == ["a.glb", "b.glb", "c.glb"]


def test_external_tilesets_are_followed_with_their_place(tmp_path: Path) -> None:
    outer = tileset(
        tile(
            children=[tile("in/one.json", transform=moved(5, 0)), tile("in/one.json", transform=moved(9, 0))]
        )
    )
    inner = tileset(tile("deeper/a%20b.glb?v=3", transform=moved(0, 7)))
    path = write(tmp_path, {"tileset.json": outer, "in/one.json": inner, "in/deeper/a b.glb": ONE})
    assert parts(path) == [("in/deeper/a b.glb", [5, 7, 0]), ("in/deeper/a b.glb", [9, 7, 0])]


def test_an_external_tileset_replaces_its_tile(tmp_path: Path) -> None:
    root = tile(contents=[{"uri": "coarse.glb"}, {"uri": "fine.json"}], refine="REPLACE")
    files = {"tileset.json": tileset(root), "coarse.glb": ONE, "fine.json": tileset(tile("fine.glb"))}
    assert names(write(tmp_path, {**files, "fine.glb": ONE})) == ["fine.glb"]


def test_the_axis_that_old_tilesets_state_and_the_one_that_is_set(tmp_path: Path) -> None:
    stated = {**tileset(tile("a.glb")), "asset": {"version": "0.0", "gltfUpAxis": "Z"}}
    path = write(tmp_path, {"tileset.json": stated, "a.glb": ONE})
    assert np.array_equal(read_tileset(path, "auto", 1000).parts[0].vertices, TRIANGLE)
    assert np.array_equal(read_tileset(path, "y", 1000).parts[0].vertices, FLAT)
    assert np.array_equal(read_tileset(path, "x", 1000).parts[0].vertices, np.roll(TRIANGLE, -1, axis=1))


def test_composites_are_opened_and_others_are_counted(tmp_path: Path, caplog: Any) -> None:
    inner = cmpt(b3dm(ONE, {"BATCH_LENGTH": 0, "RTC_CENTER": [1, 2, 3]}), other_tile(b"i3dm"))
    data = cmpt(other_tile(b"pnts"), inner, b3dm(ONE))
    path = write(tmp_path, {"tileset.json": tileset(tile("a.cmpt")), "a.cmpt": data})
    mesh = read_tileset(path, "auto", 1000)
    assert [piece.tolist() for piece in (mesh.parts[0].vertices[0], mesh.parts[1].vertices[0])] == [
        [1, 2, 3],
        [0, 0, 0],
    ]
    assert any("1 i3dm, 1 pnts" in note for note in mesh.notes)
    assert "1 contents of format i3dm were left out" in caplog.text


def test_only_contents_without_triangles_are_an_error(tmp_path: Path) -> None:
    files = {
        "tileset.json": tileset(tile("a.pnts", children=[tile("a.pnts")])),
        "a.pnts": other_tile(b"pnts"),
    }
    with pytest.raises(SceneError, match=r"no face \(2 pnts\); allowed: contents with one triangle"):
        read_tileset(write(tmp_path, files), "auto", 1000)


def test_all_files_are_in_the_digest(tmp_path: Path) -> None:
    files = {"tileset.json": tileset(tile("a.glb")), "a.glb": ONE}
    first = read_tileset(write(tmp_path, files), "auto", 1000).notes[0]
    assert first == read_tileset(write(tmp_path, files), "auto", 1000).notes[0]
    shifted = glb(*model(TRIANGLE + 1))
    assert read_tileset(write(tmp_path, {**files, "a.glb": shifted}), "auto", 1000).notes[0] != first
    assert first.startswith("2 files were read, 1 of them")
