"""Face maps that others wrote: what is not sound is refused before it is used."""

from __future__ import annotations

import hashlib
import json
import struct
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from delivery_fixture import edit_json, edit_map, random_map, set_digest, written
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tilesnav_ref.stream.contents import ContentRef, FaceMapRef
from tilesnav_ref.stream.delivery import Delivery
from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.facemaps import open_face_map
from tilesnav_ref.stream.policy import LevelPolicy
from tilesnav_ref.stream.reader import open_tileset

FIRST = "0-1.fmap"
"""Face map of level 1 for content 0, which holds the objects 0 and 1 of 4."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    written(tmp_path / "out", random_map(2))
    return tmp_path / "out"


def _member(name: str, value: object) -> Callable[[Path], None]:
    def edit(members: dict[str, Any], _: dict[str, bytes]) -> None:
        members["faceMap"][name] = value

    return lambda folder: edit_map(folder, FIRST, edit)


def _table(name: str, change: Callable[[np.ndarray], Any]) -> Callable[[Path], None]:
    def edit(_: dict[str, Any], tables: dict[str, bytes]) -> None:
        kind = "<f8" if name == "errors" else "<u4"
        table = np.frombuffer(tables[name], kind).copy()
        tables[name] = np.asarray(change(table)).astype(kind).tobytes()

    return lambda folder: edit_map(folder, FIRST, edit)


def _set(place: int, value: float) -> Callable[[np.ndarray], np.ndarray]:
    def change(table: np.ndarray) -> np.ndarray:
        table[place] = value
        return table

    return change


def _lists(change: Callable[[list[list[int]]], None]) -> Callable[[Path], None]:
    """Change the lists of faces, and count and offsets with them."""

    def edit(members: dict[str, Any], tables: dict[str, bytes]) -> None:
        ends = np.frombuffer(tables["offsets"], "<u4")
        faces = np.frombuffer(tables["faces"], "<u4")
        lists = [faces[a:b].tolist() for a, b in pairwise(ends)]
        change(lists)
        members["faceMap"]["count"] = sum(map(len, lists))
        tables["offsets"] = np.cumsum([0, *map(len, lists)]).astype("<u4").tobytes()
        tables["faces"] = np.array([f for one in lists for f in one], "<u4").tobytes()

    return lambda folder: edit_map(folder, FIRST, edit)


def _raw(change: Callable[[bytearray], None]) -> Callable[[Path], None]:
    """Change the bytes and state their digest."""

    def apply(folder: Path) -> None:
        path = folder / "contents" / FIRST
        data = bytearray(path.read_bytes())
        change(data)
        path.write_bytes(data)
        digest = hashlib.sha256(data).hexdigest()
        edit_json(folder / "tileset.json", lambda d: set_digest(d["root"], FIRST, digest))

    return apply


def _coarsest(document: dict[str, Any]) -> dict[str, Any]:
    facts: dict[str, Any] = document["root"]["children"][0]["content"]["extensions"]["3DTILES_nav"]
    return facts


def _entry(edit: Callable[[dict[str, Any]], Any]) -> Callable[[Path], None]:
    return lambda folder: edit_json(folder / "tileset.json", edit)


def _link_out(folder: Path) -> None:
    path = folder / "contents" / FIRST
    (folder.parent / "secret.fmap").write_bytes(path.read_bytes())
    path.unlink()
    path.symlink_to(folder.parent / "secret.fmap")


def _other_content(folder: Path) -> None:
    (folder / "contents" / "0-1.glb").write_bytes((folder / "contents" / "0.glb").read_bytes())


BAD: dict[str, tuple[Callable[[Path], Any], str]] = {
    "missing": (lambda f: (f / "contents" / FIRST).unlink(), f"{FIRST}: file: found No such file"),
    "a folder": (
        lambda f: ((f / "contents" / FIRST).unlink(), (f / "contents" / FIRST).mkdir()),
        "Is a directory",
    ),
    "other digest": (
        lambda f: edit_map(f, FIRST, lambda m, _: m.update(x=1), keep_digest=False),
        "sha256: found [0-9a-f]{64}; allowed: [0-9a-f]{64}, as the tileset states",
    ),
    "magic of a nav file": (_raw(lambda d: d.__setitem__(slice(0, 4), b"nav1")), "magic: found b'nav1'"),
    "cut": (_raw(lambda d: d.__delitem__(slice(-8, None))), "a claim of"),
    "empty": (_raw(lambda d: d.clear()), "0 bytes; allowed: at least 24"),
    "claims exabytes": (
        _raw(lambda d: struct.pack_into("<Q", d, 16, 1 << 62)),
        "a claim of 46116860184273[0-9]{5} bytes",
    ),
    "more objects": (_member("objectCount", 3), "objectCount: found 3; allowed: 2, as the tileset states"),
    "billions of faces": (_member("faceCount", 2**31), r"faceCount: found 2147483648; allowed: \d+, as"),
    "billions of pairs": (_member("count", 2**31), "offsets: found .other offsets"),
    "fewer pairs": (_member("count", 1), "offsets: found .other offsets"),
    "true is no number": (_member("count", True), "count: found true"),
    "no errors": (
        lambda f: edit_map(f, FIRST, lambda m, _: m["faceMap"].pop("errors")),
        "errors: found nothing",
    ),
    "no face map": (lambda f: edit_map(f, FIRST, lambda m, _: m.pop("faceMap")), "faceMap: found nothing"),
    "one view for two tables": (_member("objects", 3), "faces: found .*buffer view 3|bytes"),
    "no such view": (_member("faces", 4), "faces: found 4; allowed: an integer from 0 to 3"),
    "objects not ascending": (_table("objects", lambda o: o[::-1]), "strictly ascending"),
    "object beyond": (_table("objects", _set(1, 4)), "objects: found 4; allowed: numbers less than 4"),
    "short table": (_table("errors", lambda e: e[:1]), "buffer view 1 of 8 bytes"),
    "error below 0": (_table("errors", _set(0, -0.25)), "errors: found -0.25; allowed: numbers of 0"),
    "error without a number": (_table("errors", _set(0, np.nan)), "finite numbers"),
    "error without a bound": (_table("errors", _set(0, np.inf)), "finite numbers"),
    "offsets that fall": (_table("offsets", _set(1, 2**32 - 1)), "offsets: found .other offsets"),
    "face beyond": (_table("faces", _set(-1, 10**6)), "faces: found 1000000; allowed: numbers less than"),
    "face twice": (_lists(lambda faces: faces[0].append(faces[0][-1])), "ascending lists"),
    "face for nothing": (_lists(lambda faces: faces[1].clear()), "no face for face 1"),
    "face of another object": (_lists(lambda faces: faces[-1].insert(0, 0)), "0 of another object"),
    "face left out": (_lists(lambda faces: [one.__delitem__(slice(1, None)) for one in faces]), "all"),
    "objects of others": (_table("objects", lambda o: o + 2), "of another object"),
    "leads out": (
        _entry(lambda d: _coarsest(d)["faceMap"].update(uri="../x.fmap")),
        "faceMap.uri: found \"../x.fmap\"",
    ),
    "link out": (_link_out, "faceMap.uri: found"),
    "no uri": (_entry(lambda d: _coarsest(d)["faceMap"].pop("uri")), "uri: found nothing"),
    "no digest": (_entry(lambda d: _coarsest(d)["faceMap"].pop("sha256")), "sha256: found nothing"),
    "not an object": (_entry(lambda d: _coarsest(d).update(faceMap=[])), r"faceMap: found \[\]"),
    "same id twice": (
        _entry(lambda d: _coarsest(d).update(contentId=1)),
        r"contentId of level 2: found \[1, 1\]",
    ),
    "object left out": (
        _entry(lambda d: d["root"]["children"].append(d["root"]["children"].pop()["children"][0])),
        "objects of level 2: found 2 primitives for 2 objects; allowed: each of the 4 objects",
    ),
    "object twice": (
        lambda f: edit_json(f / "tileset.json", _twice),
        "objects of level 2: found 6 primitives for 4 objects",
    ),
    "geometry of another level": (_other_content, "primitives, as the tileset states|of another"),
}


def _twice(document: dict[str, Any]) -> None:
    again = json.loads(json.dumps(document["root"]["children"][0]))
    del again["children"]
    again["content"]["extensions"]["3DTILES_nav"]["contentId"] = 2
    document["root"]["children"].append(again)


@pytest.mark.parametrize("name", BAD)
def test_bad_face_maps_are_refused(folder: Path, name: str) -> None:
    change, message = BAD[name]
    change(folder)
    with pytest.raises(TilesetError, match=message):
        _ = open_tileset(folder).levels


def test_more_objects_than_the_contents_have(folder: Path) -> None:
    edit_json(
        folder / "tileset.json", lambda d: d["extensions"]["3DTILES_nav"].update(objectCount=5)
    )
    with pytest.raises(TilesetError, match="objectCount: found 5; allowed: the sum over the contents"):
        open_tileset(folder)


def test_positions_off_the_grid(folder: Path) -> None:
    edit_json(
        folder / "tileset.json", lambda d: d["extensions"]["3DTILES_nav"]["grid"].update(exponent=-3)
    )
    tileset = open_tileset(folder)
    assert tileset.step == 0.125
    assert len(tileset.finest.corners)  # the map is on a grid of half a metre
    edit_json(folder / "tileset.json", lambda d: d["extensions"]["3DTILES_nav"]["grid"].update(exponent=0))
    with pytest.raises(TilesetError, match=r"0.glb: POSITION: found -?\d\.5; allowed: a multiple of 1.0 m"):
        _ = open_tileset(folder).finest


@pytest.mark.parametrize(
    ("lod", "message"),
    [
        ({"reference": 0}, "reference: found 0.0; allowed: a number greater than 0"),
        ({"base": 1}, "base: found 1.0; allowed: a number greater than 1"),
        ({"base": "2"}, "base: found \"2\"; allowed: a finite number"),
        ({"levelCount": 257}, "levelCount: found 257"),
    ],
)
def test_bad_scales_of_codes(folder: Path, lod: dict[str, Any], message: str) -> None:
    edit_json(folder / "tileset.json", lambda d: d["extensions"]["3DTILES_nav"]["lod"].update(lod))
    with pytest.raises(TilesetError, match=message):
        open_tileset(folder)


def test_a_content_without_a_map_has_none_to_open(folder: Path) -> None:
    content = open_tileset(folder).contents[0]
    with pytest.raises(ValueError, match="without a face map"):
        open_face_map(content, np.zeros(1, np.int64), np.zeros(1, np.int64))


@pytest.fixture(scope="module")
def map_file(tmp_path_factory: pytest.TempPathFactory) -> tuple[ContentRef, bytes, np.ndarray, np.ndarray]:
    tileset = written(tmp_path_factory.mktemp("map") / "out", random_map(2))
    content = tileset.coarse[1][0]
    assert content.face_map is not None
    return (
        content,
        content.face_map.path.read_bytes(),
        tileset.levels[0].geometry.offsets[:3],
        tileset.object_offsets,
    )


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_damaged_face_map_is_read_or_refused_never_worse(
    map_file: tuple[ContentRef, bytes, np.ndarray, np.ndarray], tmp_path: Path, data: st.DataObject
) -> None:
    content, whole, primitive_offsets, object_offsets = map_file
    damaged = bytearray(whole)
    if data.draw(st.booleans()):
        del damaged[data.draw(st.integers(0, len(damaged) - 1)) :]
    for _ in range(data.draw(st.integers(0, 4)) if damaged else 0):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path / "damaged.fmap"
    path.write_bytes(damaged)
    stated = FaceMapRef(path, hashlib.sha256(damaged).hexdigest())
    ref = ContentRef(content.path, 0, content.face_count, content.object_count, level=1, face_map=stated)
    try:
        found = open_face_map(ref, primitive_offsets, object_offsets)
    except TilesetError:
        return
    for number, first, last in zip(found.objects, primitive_offsets, primitive_offsets[1:], strict=False):
        listed = np.concatenate([found.faces.row(row) for row in range(first, last)])
        assert np.array_equal(np.unique(listed), np.arange(*object_offsets[number : number + 2]))
    assert np.all(found.errors >= 0)
    assert np.isfinite(found.errors).all()


def test_what_is_not_asked_for_is_not_read(folder: Path) -> None:
    """A vehicle that takes level 0 only has no use for face maps."""
    (folder / "contents" / FIRST).unlink()
    delivery = Delivery(open_tileset(folder))
    assert {part.level for part in delivery.held(2, LevelPolicy("fine"))} == {0}
