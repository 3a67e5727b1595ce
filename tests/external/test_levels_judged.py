"""What others say about coarse levels: the Khronos validator about their glTF, CesiumJS about the chain."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tilesnav_ref.cli import main

pytestmark = pytest.mark.node
Judge = Callable[..., str]


@pytest.fixture(scope="module")
def town(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The median sample town in three levels; few rays, since no judge here looks at visibility."""
    folder = tmp_path_factory.mktemp("levels")
    scene, out = folder / "town.ply", folder / "tileset"
    assert main(["sample", str(scene), "--detail", "median", "--size", "small"]) == 0
    few = ["--rays", "200", "--attempts", "0", "--min-cell", "8", "--max-cell", "32", "--levels", "3"]
    assert main(["encode", str(scene), str(out), "--quiet", *few]) == 0
    return out


def test_gltf_validator_finds_no_error_and_no_warning(judge: Judge, town: Path) -> None:
    files = sorted(town.rglob("*.glb"))
    reports = [json.loads(line) for line in judge("gltf_validate.mjs", *files).splitlines()]
    assert len(reports) == len(files) > 2
    assert [one for one in reports if one["errors"] or one["warnings"]] == []


def test_cesium_finds_a_chain_of_levels_that_replace_each_other(judge: Judge, town: Path) -> None:
    seen = json.loads(judge("cesium_load.mjs", town / "tileset.json"))
    assert seen["missing"] == []
    chains: dict[int, list[Any]] = {}
    for one in seen["contents"]:
        chains.setdefault(one["nav"]["contentId"], []).append(one)
    for chain in chains.values():
        assert [one["nav"]["level"] for one in chain] == [2, 1, 0]
        assert [one["replaced"] for one in chain] == [True, True, False]
        assert len({one["primitives"] for one in chain}) == 1
        errors = [one["error"] for one in chain]
        assert errors == sorted(errors, reverse=True)
        assert errors[1] > errors[2] == 0
        triangles = [one["triangles"] for one in chain]
        assert triangles == sorted(triangles)
        assert triangles == [one["nav"]["faceCount"] for one in chain]
