"""Coarse levels as they are written, read by the validator as a program of others."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_tileset_small_map import STEP, small_map

from tilesnav_ref.cells import planes
from tilesnav_ref.commands.arguments import encode_settings, parse
from tilesnav_ref.encode import EncodeSettings, _stages
from tilesnav_ref.levels import CoarseLevel, LevelSettings, coarse_levels
from tilesnav_ref.stream.reader import open_tileset
from tilesnav_ref.tileset import facemap
from tilesnav_ref.tileset.errors import EncodeError
from tilesnav_ref.tileset.facemap import face_map_file
from tilesnav_ref.tileset.model import NavMap, TilesetSettings
from tilesnav_ref.tileset.write import write_tileset
from tilesnav_validator.findings import Settings
from tilesnav_validator.runner import judge

SETTINGS = LevelSettings(3, (0.5, 6.0))


def coarse_map() -> NavMap:
    one = small_map()
    return replace(one, coarse=coarse_levels(one.scene, SETTINGS))


def written(folder: Path, one: NavMap) -> Any:
    write_tileset(folder, one, planes(one.cells, STEP), TilesetSettings())
    return json.loads((folder / "tileset.json").read_text(encoding="utf-8"))


def chains(document: Any) -> list[list[Any]]:
    """The tiles of each content, from the coarsest to the finest."""
    found = []
    for tile in document["root"]["children"]:
        chain = [tile]
        while "children" in chain[-1]:
            (child,) = chain[-1]["children"]
            chain.append(child)
        found.append(chain)
    return found


def test_levels_are_a_chain_of_replacement(tmp_path: Path) -> None:
    document = written(tmp_path, coarse_map())
    assert document["root"]["refine"] == "ADD"
    for number, chain in enumerate(chains(document)):
        facts = [tile["content"]["extensions"]["3DTILES_nav"] for tile in chain]
        assert [one["level"] for one in facts] == [2, 1, 0]
        assert [one["contentId"] for one in facts] == [number] * 3
        errors = [document["root"]["geometricError"], *(tile["geometricError"] for tile in chain)]
        assert errors == sorted(errors, reverse=True)
        assert errors[-1] == 0 < errors[-2]
        assert [tile.get("refine") for tile in chain] == ["REPLACE", "REPLACE", None]
        assert ["faceMap" in one for one in facts] == [True, True, False]


def test_the_validator_finds_the_levels_sound(tmp_path: Path) -> None:
    written(tmp_path, coarse_map())
    result = judge(tmp_path / "tileset.json", Settings(rays=0, threads=1))
    found = {j.requirement.id: (j.verdict, j.findings) for j in result.judgements}
    level = {name: verdict for name, verdict in found.items() if name.startswith(("level/", "core/"))}
    assert {name: one for name, one in level.items() if one[0] not in {"pass", "not refuted"}} == {}
    assert len(result.subject.coarse) == 4


def test_readers_of_the_finest_level_see_the_same(tmp_path: Path) -> None:
    for name, one in (("plain", small_map()), ("coarse", coarse_map())):
        (tmp_path / name).mkdir()
        written(tmp_path / name, one)
    first, second = (open_tileset(tmp_path / name) for name in ("plain", "coarse"))
    assert first.face_count == second.face_count
    for name in ("contents/0.glb", "contents/1.glb", "nav/0.nav"):
        assert (tmp_path / "plain" / name).read_bytes() == (tmp_path / "coarse" / name).read_bytes()


def test_a_face_map_that_readers_would_refuse_is_not_written(monkeypatch: pytest.MonkeyPatch) -> None:
    level = coarse_map().coarse[0]
    monkeypatch.setattr(facemap, "COUNT_LIMIT", 1)
    with pytest.raises(EncodeError, match=r"a face map of \d+ pairs; allowed: 1 or less"):
        face_map_file(level, 0)


def test_numbers_of_faces_are_those_of_the_file() -> None:
    """Content 1 begins with object 2 and face 4."""
    one = coarse_map()
    level: CoarseLevel = one.coarse[0]
    parts = b"".join(bytes(part) for part in face_map_file(level, 1))
    length = int.from_bytes(parts[8:16], "little")
    members = json.loads(parts[24 : 24 + length])
    view = members["bufferViews"][members["faceMap"]["objects"]]
    start = 24 + length + view["byteOffset"]
    assert np.frombuffer(parts[start : start + view["byteLength"]], "<u4").tolist() == [2]
    view = members["bufferViews"][members["faceMap"]["faces"]]
    start = 24 + length + view["byteOffset"]
    assert set(np.frombuffer(parts[start : start + view["byteLength"]], "<u4").tolist()) == {4}


def test_options() -> None:
    given = parse(["encode", "a.ply", "b", "--levels", "3", "--level-errors", "0.1,0.3"])
    assert encode_settings(given).coarse == LevelSettings(3, (0.1, 0.3))
    given = parse(["encode", "a.ply", "b", "--levels", "2", "--level-errors", "0.1"])
    assert encode_settings(given).coarse == LevelSettings(2, (0.1,))


def test_what_is_not_made_is_not_stated() -> None:
    scene = small_map().scene
    plain, coarse = _stages(EncodeSettings(), scene, None), EncodeSettings(coarse=SETTINGS)
    assert not {"coarse", "survey"} & set(plain)
    assert _stages(coarse, scene, None)["coarse"] == SETTINGS
