"""Hostile JSON, uris that leave the folder, things that are no files, tilesets without end."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from validator_fixture import Small, failures

from tilesnav_validator import strictjson, tiles
from tilesnav_validator.files import FileError, Folder, UriOutsideError, open_file
from tilesnav_validator.findings import Settings, UnreadableInputError
from tilesnav_validator.runner import judge


def test_json_values() -> None:
    assert strictjson.parse(b'{"a": [1, 2.5, -3, true, null, "x"]}') == {"a": [1, 2.5, -3, True, None, "x"]}


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (b"NaN", "NaN"),
        (b"[-Infinity]", "-Infinity"),
        (b"1e999", "1e999"),
        (b"9" * 301, "301 digits"),
        (b"[" * 100_000 + b"]" * 100_000, "deep"),
        (b'{"a":' * 100_000, "deep"),
        (b"\xff\xfe", "utf-8"),
        (b"", "Expecting value"),
        (b"{} {}", "Extra data"),
        (b'\xef\xbb\xbf{"a": 1}', "BOM|Expecting value"),
        (b'[{"a": 1, "b": {}, "a": 1}]', "'a' stands twice"),
    ],
)
def test_json_that_is_refused(text: bytes, reason: str) -> None:
    with pytest.raises(strictjson.JsonError, match=reason):
        strictjson.parse(text)


def test_json_is_not_parsed_beyond_its_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(strictjson, "MAX_BYTES", 8)
    assert strictjson.parse(b"[1,2,34]") == [1, 2, 34]
    with pytest.raises(strictjson.JsonError, match="more than 8"):
        strictjson.parse(b"[1,2,345]")
    with pytest.raises(strictjson.JsonError, match="more than 8"):
        strictjson.parse_view(memoryview(b"[1,2,345]"), 0, 9)


OUTSIDE = [
    "../x",
    "a/../../x",
    "%2e%2e/x",
    "a%2f..%2f..%2fx",
    "/etc/passwd",
    "%2fetc/passwd",
    "//host/x",
    "file:///etc/passwd",
    "http://example.org/x",
    "C:/x",
    "a\\..\\x",
    "%5c..%5cx",
    "a%00b",
    "a\nb",
    "http://[x",
    "%ff",
    "x" * 5000,
    "out/secret",
    "out",
]


@pytest.mark.parametrize("uri", OUTSIDE)
def test_uris_that_leave_the_folder(tmp_path: Path, uri: str) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "secret").write_text("x")
    (inner / "out").symlink_to(tmp_path)
    with pytest.raises(UriOutsideError):
        Folder(inner.resolve()).resolve((), uri)


def test_uris_that_stay_inside(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "a")
    folder = Folder(tmp_path.resolve())
    assert folder.resolve((), "a/./b//c%20d.nav?v=1#x") == ("a", "b", "c d.nav")
    assert folder.resolve(("a", "b"), "../../c") == ("c",)
    assert folder.resolve((), "link/x") == ("link", "x")
    assert folder.path(("a", "b")) == tmp_path.resolve() / "a" / "b"


def test_things_that_are_no_files(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    (tmp_path / "empty").write_bytes(b"")
    assert bytes(open_file(tmp_path / "empty")) == b""
    for name in ("pipe", "loop", "missing", ".", "empty/below", "x" * 300):
        with pytest.raises(FileError):
            open_file(tmp_path / name)
    with pytest.raises(FileError):
        open_file(Path("a\0b"))


@pytest.mark.parametrize("kind", ["missing", "pipe", "folder", "not json", "array", "deep", "nan", "twice"])
def test_unreadable_entry_tilesets(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "tileset.json"
    texts = {"not json": "{", "array": "[]", "deep": "[" * 99_999, "nan": '{"a": NaN}'}
    text = {**texts, "twice": '{"root": {}, "root": {}}'}.get(kind)
    if text is not None:
        path.write_text(text)
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    with pytest.raises(UnreadableInputError, match=r"tileset\.json"):
        judge(path, Settings(rays=0))


def test_uris_of_contents_and_sectors(tmp_path: Path) -> None:
    for uri, requirement in (("../0.nav", "core/uri-inside"), ("1.nav", "core/sector-resolves")):
        small = Small()
        small.extension["sectors"][0]["uri"] = uri
        assert failures(small.write(tmp_path), rays=0) == [requirement]
    for value, requirement in (
        ("../0.glb", "core/uri-inside"),
        ("1.glb", "core/content-resolves"),
        (".", "core/content-resolves"),
        (5, "core/content-resolves"),
    ):
        small = Small()
        small.root["content"]["uri"] = value
        assert failures(small.write(tmp_path), rays=0) == [requirement]


def external(tmp_path: Path, name: str, root: Any) -> None:
    text = {"asset": {"version": "1.1"}, "geometricError": 1, "root": root}
    (tmp_path / name).write_text(json.dumps(text), encoding="utf-8")


VOLUME = {"boundingVolume": {"sphere": [0, 0, 0, 100]}, "geometricError": 0}


def outer(small: Small, *uris: str) -> None:
    """Put the root tile of a tileset below a new root that also refers to other files."""
    small.tileset["root"] = {**VOLUME, "children": [small.root], "contents": [{"uri": uri} for uri in uris]}


def test_a_nav_content_in_an_external_tileset(tmp_path: Path) -> None:
    small = Small()
    small.write(tmp_path)
    (tmp_path / "sub").mkdir()
    small.root["content"]["uri"] = "../0.glb"
    external(tmp_path, "sub/inner.json", small.root)
    small.tileset["root"] = {**VOLUME, "content": {"uri": "sub/inner.json"}}
    assert failures(small.write(tmp_path)) == []
    small.root["transform"] = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1]
    external(tmp_path, "sub/inner.json", small.root)
    assert failures(small.write(tmp_path)) == ["core/content-transform"]


@pytest.mark.parametrize("length", [1, 2, 5])
def test_external_tilesets_in_a_circle(tmp_path: Path, length: int) -> None:
    for index in range(length):
        external(tmp_path, f"e{index}.json", {**VOLUME, "content": {"uri": f"e{(index + 1) % length}.json"}})
    small = Small()
    outer(small, "e0.json")
    assert failures(small.write(tmp_path), rays=0) == ["core/external-tilesets-end"]


def test_the_entry_tileset_in_a_circle(tmp_path: Path) -> None:
    small = Small()
    outer(small, "tileset.json")
    assert failures(small.write(tmp_path), rays=0) == ["core/external-tilesets-end"]


@pytest.mark.parametrize(("depth", "expected"), [(32, []), (33, ["core/external-tilesets-end"])])
def test_depth_of_external_tilesets(tmp_path: Path, depth: int, expected: list[str]) -> None:
    for index in range(depth):
        child = {} if index == depth - 1 else {"content": {"uri": f"e{index + 1}.json"}}
        external(tmp_path, f"e{index}.json", {**VOLUME, **child})
    small = Small()
    outer(small, "e0.json")
    assert failures(small.write(tmp_path), rays=0) == expected


def test_a_fan_of_external_tilesets_comes_to_an_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for index in range(30):
        double = {"contents": [{"uri": f"e{index + 1}.json"}] * 2}
        external(tmp_path, f"e{index}.json", {**VOLUME, **double})
    external(tmp_path, "e30.json", VOLUME)
    monkeypatch.setattr(tiles, "MAX_TILES", 500)
    small = Small()
    outer(small, "e0.json")
    with pytest.raises(UnreadableInputError, match="more than 500 tiles"):
        judge(small.write(tmp_path), Settings(rays=0))


def test_other_json_files_are_contents_like_any_other(tmp_path: Path) -> None:
    (tmp_path / "model.gltf").write_text('{"asset": {"version": "2.0"}}')
    (tmp_path / "broken.json").write_text('{"asset": ')
    small = Small()
    outer(small, "model.gltf")
    assert failures(small.write(tmp_path), rays=0) == []
    (tmp_path / "model.gltf").write_text('{"asset": {"version": "2.0"}, "root": 1, "x": ')
    (tmp_path / "shapes.json").write_text('{"type": "FeatureCollection"}')
    outer(small, "model.gltf", "shapes.json")
    assert failures(small.write(tmp_path), rays=0) == []
    outer(small, "broken.json")
    assert failures(small.write(tmp_path), rays=0) == ["core/content-resolves"]


@pytest.mark.parametrize("before", ["", " " * 100, "\ufeff"])
def test_an_external_tileset_is_known_by_its_first_brace(tmp_path: Path, before: str) -> None:
    external(tmp_path, "e.json", {**VOLUME, "content": {"uri": "missing.glb"}})
    (tmp_path / "e.json").write_text(before + (tmp_path / "e.json").read_text(encoding="utf-8"), "utf-8")
    small = Small()
    outer(small, "e.json")
    assert failures(small.write(tmp_path), rays=0) == ["core/content-resolves"]


def test_an_external_tileset_that_is_referred_to_twice(tmp_path: Path) -> None:
    small = Small()
    small.write(tmp_path)
    external(tmp_path, "e.json", small.root)
    small.tileset["root"] = {**VOLUME, "contents": [{"uri": "e.json"}]}
    assert failures(small.write(tmp_path), rays=0) == []
    small.tileset["root"] = {**VOLUME, "contents": [{"uri": "e.json"}] * 2}
    assert failures(small.write(tmp_path), rays=0) == ["core/content-ids-dense"]


def test_the_entry_object_of_an_external_tileset_is_not_read(tmp_path: Path) -> None:
    small = Small()
    small.write(tmp_path)
    text = {"asset": {"version": "1.1"}, "extensions": {"3DTILES_nav": {"version": "9"}}, "root": small.root}
    (tmp_path / "e.json").write_text(json.dumps(text), encoding="utf-8")
    small.tileset["root"] = {**VOLUME, "content": {"uri": "e.json"}}
    assert failures(small.write(tmp_path), rays=0) == []


def test_a_content_without_the_object_need_only_be_there(tmp_path: Path) -> None:
    (tmp_path / "tree.glb").write_bytes(b"no glTF at all")
    small = Small()
    plain = {**VOLUME, "boundingVolume": {"sphere": [999, 0, 0, 0]}, "content": {"uri": "tree.glb"}}
    small.tileset["root"] = {**VOLUME, "children": [small.root, plain]}
    assert failures(small.write(tmp_path), rays=0) == []
    (tmp_path / "tree.glb").unlink()
    assert failures(small.write(tmp_path), rays=0) == ["core/content-resolves"]


def test_many_levels_of_tiles(tmp_path: Path) -> None:
    small = Small()
    root = small.root
    for _ in range(150):
        root = {**VOLUME, "children": [root]}
    small.tileset["root"] = root
    assert failures(small.write(tmp_path), rays=0) == []


@pytest.mark.parametrize(
    "oddity",
    [
        {"children": 5},
        {"children": [None, 7, "x"]},
        {"contents": "x"},
        {"contents": [1, None]},
        {"content": []},
    ],
)
def test_oddities_beside_nav_contents_do_no_harm(tmp_path: Path, oddity: dict[str, Any]) -> None:
    small = Small()
    small.tileset["root"] = {**VOLUME, "children": [small.root, {**VOLUME, **oddity}]}
    assert failures(small.write(tmp_path), rays=0) == []


def test_templates_of_implicit_tiling_name_no_file(tmp_path: Path) -> None:
    small = Small()
    implicit = {**VOLUME, "implicitTiling": {}, "content": {"uri": "{level}/{x}.glb"}}
    small.tileset["root"] = {**VOLUME, "children": [small.root, implicit]}
    assert failures(small.write(tmp_path), rays=0) == []
    implicit["content"] = {"uri": "{level}/{x}.glb", "extensions": small.root["content"]["extensions"]}
    assert failures(small.write(tmp_path), rays=0) == ["core/content-resolves"]


@pytest.mark.parametrize("value", [[1] * 15, "x", [1] * 15 + [True], [1] * 15 + [10**299]])
def test_malformed_transforms(tmp_path: Path, value: Any) -> None:
    small = Small()
    small.root["transform"] = value
    assert failures(small.write(tmp_path), rays=0) == ["core/content-transform"]


def test_a_transform_that_overflows(tmp_path: Path) -> None:
    small = Small()
    small.extension["transform"] = [1.7e308] * 16
    assert failures(small.write(tmp_path), rays=0) == ["core/transform-rigid"]


def test_transforms(tmp_path: Path) -> None:
    def verdict(matrix: np.ndarray[Any, Any], tile: np.ndarray[Any, Any]) -> list[str]:
        small = Small(transform=matrix.T.flatten().tolist())
        small.root["transform"] = tile.T.flatten().tolist()
        return failures(small.write(tmp_path), rays=0)

    turned = np.array([[0.0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]])
    assert verdict(turned, turned) == []
    assert verdict(turned, turned + 0.9e-6) == []
    assert verdict(turned, np.eye(4)) == ["core/content-transform"]
    scaled = turned.copy()
    scaled[:3, :3] *= 1 + 4e-10
    assert verdict(scaled, turned) == []
    scaled[:3, :3] *= 1 + 4e-9
    assert verdict(scaled, turned) == ["core/transform-rigid"]
    mirrored = np.diag([1.0, 1, -1, 1])
    assert verdict(mirrored, mirrored) == ["core/transform-rigid"]
    row = np.eye(4)
    row[3, 0] = 1e-12
    assert verdict(row, row) == ["core/transform-rigid"]
    huge = np.eye(4)
    huge[0, 3] = 1e307
    assert verdict(huge, np.eye(4)) == ["core/content-transform"]
