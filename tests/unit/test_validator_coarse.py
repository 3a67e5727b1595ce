"""Coarse contents: distances, and faults that no conformance case has."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from trimesh.triangles import closest_point

from tilesnav_validator.distances import to_triangles
from tilesnav_validator.findings import Settings
from tilesnav_validator.runner import judge

CASE = Path(__file__).parents[2] / "conformance" / "cases" / "valid" / "two-coarse-levels"


def failed(folder: Path) -> dict[str, list[str]]:
    result = judge(folder / "tileset.json", Settings(rays=0, threads=1))
    wrong = [one for one in result.judgements if one.verdict == "fail"]
    return {one.requirement.id: [found.measured for found in one.findings] for one in wrong}


@pytest.fixture
def changed(tmp_path: Path) -> Callable[[Callable[[Any], object]], dict[str, list[str]]]:
    """What fails after a change of the tileset of a valid case."""

    def run(change: Callable[[Any], object]) -> dict[str, list[str]]:
        folder = Path(shutil.copytree(CASE, tmp_path / "case"))
        document = json.loads((folder / "tileset.json").read_text(encoding="utf-8"))
        change(document)
        (folder / "tileset.json").write_text(json.dumps(document), encoding="utf-8")
        return failed(folder)

    return run


def test_distances_agree_with_another_program() -> None:
    random = np.random.default_rng(5)
    triangles, points = random.normal(size=(300, 3, 3)), 2 * random.normal(size=(300, 1, 3))
    triangles[:20, 2] = triangles[:20, 1]
    found = to_triangles(points, triangles)[:, 0]
    expected = np.linalg.norm(points[:, 0] - closest_point(triangles, points[:, 0]), axis=1)
    assert np.allclose(found[20:], expected[20:], atol=1e-12)
    along = np.linspace(0, 1, 2001)[None, :, None]
    line = triangles[:20, None, 0] + along * (triangles[:20, None, 1] - triangles[:20, None, 0])
    sampled = np.linalg.norm(points[:20] - line, axis=2).min(axis=1)
    assert np.allclose(found[:20], sampled, atol=2e-3)
    assert (found[:20] <= sampled + 1e-12).all()


def test_the_case_is_valid_and_was_searched() -> None:
    result = judge(CASE / "tileset.json", Settings(rays=0, threads=1))
    found = {j.requirement.id: (j.verdict, j.note) for j in result.judgements}["level/error-holds"]
    assert found[0] == "not refuted"
    assert " points, seed 0" in found[1]
    assert failed(CASE) == {}


@pytest.mark.parametrize("error", ["4", None, True])
def test_a_geometric_error_that_is_no_number(changed: Any, error: Any) -> None:
    found = changed(lambda tileset: tileset["root"]["children"][0].update(geometricError=error))
    assert found.keys() == {"level/chain"}
    assert found["level/chain"] == [str(error)]


def test_a_finer_tile_without_a_number_is_a_fault_of_what_is_above(changed: Any) -> None:
    def change(tileset: Any) -> None:
        del tileset["root"]["children"][0]["children"][0]["children"][0]["geometricError"]

    assert len(changed(change)["level/chain"]) == 2


def test_refine_is_taken_from_above(changed: Any) -> None:
    def change(tileset: Any) -> None:
        del tileset["root"]["children"][0]["children"][0]["refine"]

    assert changed(change) == {}


def test_a_face_map_of_level_0_has_no_meaning(changed: Any) -> None:
    def change(tileset: Any) -> None:
        finest = tileset["root"]["children"][0]["children"][0]["children"][0]
        finest["content"]["extensions"]["3DTILES_nav"]["faceMap"] = {"uri": "none.fmap", "sha256": ""}

    assert changed(change) == {}


def test_a_map_in_an_external_tileset_is_sought_beside_it(changed: Any, tmp_path: Path) -> None:
    """The same chain in a folder of its own, with its files."""

    def change(tileset: Any) -> None:
        folder = tmp_path / "case"
        shutil.copytree(folder / "content", folder / "inner" / "content")
        child = tileset["root"]["children"][1]
        inner = {"asset": {"version": "1.1"}, "geometricError": 1, "root": {**child}}
        (folder / "inner" / "tiles.json").write_text(json.dumps(inner), encoding="utf-8")
        (folder / "content" / "1-1.fmap").unlink()
        tileset["root"]["children"][1] = {
            "boundingVolume": child["boundingVolume"],
            "geometricError": child["geometricError"],
            "content": {"uri": "inner/tiles.json"},
        }

    assert changed(change) == {}
