"""What is porous, one-sided or limited in range is written, read back, and absent where not asked for."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_tileset_small_map import small_map

from tilesnav_ref.cells import planes
from tilesnav_ref.scene import SceneSettings
from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.figures import figures
from tilesnav_ref.stream.reader import open_tileset
from tilesnav_ref.tileset.model import NavMap, TilesetSettings
from tilesnav_ref.tileset.provenance import _members
from tilesnav_ref.tileset.write import write_tileset
from tilesnav_ref.visibility import VisibilitySettings


def write(folder: Path, one: NavMap) -> dict[str, Any]:
    """Write a map; return the entry tileset."""
    folder.mkdir(exist_ok=True)
    write_tileset(folder, one, planes(one.cells, one.scene.step), TilesetSettings())
    document: dict[str, Any] = json.loads((folder / "tileset.json").read_text())
    return document


def flagged(porous: list[bool], one_sided: list[bool], max_range: float | None) -> NavMap:
    one = small_map()
    scene = replace(
        one.scene,
        object_porous=np.array(porous, np.bool_),
        object_one_sided=np.array(one_sided, np.bool_),
    )
    return replace(one, scene=scene, max_range=max_range)


def facts(document: dict[str, Any]) -> list[dict[str, Any]]:
    return [child["content"]["extensions"]["3DTILES_nav"] for child in document["root"]["children"]]


def test_flags_are_indices_within_the_content(tmp_path: Path) -> None:
    document = write(tmp_path / "out", flagged([False, True, True], [True, True, False], 80.5))
    first, second = facts(document)
    assert (first["porous"], first["oneSided"]) == ([1], [0, 1])
    assert second["porous"] == [0]
    assert "oneSided" not in second
    assert document["extensions"]["3DTILES_nav"]["visibility"] == {"maxRange": 80.5}
    tileset = open_tileset(tmp_path / "out")
    assert tileset.porous_objects.tolist() == [1, 2]
    assert tileset.one_sided_objects.tolist() == [0, 1]
    assert tileset.max_range == 80.5
    found = figures(tileset)
    assert (found["max_range"], found["porous_objects"], found["one_sided_objects"]) == (80.5, 2, 2)


def test_what_is_not_asked_for_is_absent(tmp_path: Path) -> None:
    document = write(tmp_path / "out", small_map())
    for content in facts(document):
        assert content.keys() == {"contentId", "level", "faceCount", "objectCount", "sha256"}
    assert "visibility" not in document["extensions"]["3DTILES_nav"]
    tileset = open_tileset(tmp_path / "out")
    assert (tileset.max_range, tileset.porous_objects.tolist()) == (None, [])
    assert tileset.one_sided_objects.tolist() == []


def test_parameters_are_stated_where_they_were_given() -> None:
    assert not {"transparent", "one_sided"} & _members(SceneSettings()).keys()
    assert "max_range" not in _members(VisibilitySettings())
    assert _members(SceneSettings(transparent=("tree*",)))["transparent"] == ("tree*",)
    assert _members(VisibilitySettings(max_range=9.0))["max_range"] == 9.0
    assert _members(VisibilitySettings(rays=0))["rays"] == 0


@pytest.mark.parametrize("value", [[2], [1, 0], [0, 0], [-1], ["0"], [0.5], 0, None, {}])
@pytest.mark.parametrize("member", ["porous", "oneSided"])
def test_indices_that_are_none_are_refused(tmp_path: Path, member: str, value: object) -> None:
    document = write(tmp_path / "out", small_map())
    facts(document)[0][member] = value
    (tmp_path / "out" / "tileset.json").write_text(json.dumps(document))
    with pytest.raises(TilesetError, match=member):
        open_tileset(tmp_path / "out")


@pytest.mark.parametrize("value", [{}, {"maxRange": 0}, {"maxRange": "9"}, {"maxRange": -1}, 9, []])
def test_ranges_that_are_none_are_refused(tmp_path: Path, value: object) -> None:
    document = write(tmp_path / "out", small_map())
    document["extensions"]["3DTILES_nav"]["visibility"] = value
    (tmp_path / "out" / "tileset.json").write_text(json.dumps(document))
    with pytest.raises(TilesetError, match="visibility"):
        open_tileset(tmp_path / "out")
