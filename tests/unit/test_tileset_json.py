"""tileset.json: against the schemas, the files beside it and the facts of the scene."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from referencing import Registry, Resource
from test_tileset_small_map import STEP, small_map

from tilesnav_ref.cells import planes
from tilesnav_ref.cells.model import box_corners
from tilesnav_ref.stream.glb import open_glb
from tilesnav_ref.tileset.bounds import box_volume
from tilesnav_ref.tileset.errors import EncodeError
from tilesnav_ref.tileset.model import NavMap, TilesetSettings
from tilesnav_ref.tileset.write import write_tileset

SCHEMAS = Path(__file__).parents[2] / "schema"


def _write(folder: Path, one: NavMap, cells_per_sector: int = 100) -> dict[str, Any]:
    write_tileset(folder, one, planes(one.cells, one.scene.step), TilesetSettings(cells_per_sector))
    document: dict[str, Any] = json.loads((folder / "tileset.json").read_text(encoding="utf-8"))
    return document


def _validator(name: str) -> Draft202012Validator:
    schemas = [json.loads(path.read_text()) for path in SCHEMAS.glob("*.schema.json")]
    registry = Registry().with_resources((s["$id"], Resource.from_contents(s)) for s in schemas)
    return Draft202012Validator({"$ref": name}, registry=registry)


def test_documents_are_valid_against_the_schemas(tmp_path: Path) -> None:
    document = _write(tmp_path, small_map(), cells_per_sector=2)
    assert list(_validator("entry-tileset.schema.json").iter_errors(document)) == []
    for tile in document["root"]["children"]:
        extension = tile["content"]["extensions"]["3DTILES_nav"]
        assert list(_validator("content.3DTILES_nav.schema.json").iter_errors(extension)) == []
    for path in (tmp_path / "nav").iterdir():
        file = path.read_bytes()
        part = json.loads(file[24 : 24 + int.from_bytes(file[8:16], "little")])
        assert list(_validator("nav.schema.json").iter_errors(part)) == []


def test_entry_object(tmp_path: Path) -> None:
    document = _write(tmp_path, small_map(), cells_per_sector=2)
    assert document["extensionsUsed"] == ["3DTILES_nav"]
    assert "extensionsRequired" not in document
    entry = document["extensions"]["3DTILES_nav"]
    counts = [entry[f"{name}Count"] for name in ("face", "object", "cell", "portal")]
    assert counts == [5, 3, 3, 4]
    assert entry["clearance"] == 0.25
    assert entry["pvs"] == {"listed": 8, "provenVisible": 6}
    assert [(s["uri"], s["firstCell"], s["cellCount"]) for s in entry["sectors"]] == [
        ("nav/0.nav", 0, 2),
        ("nav/1.nav", 2, 1),
    ]
    # Cells 0 and 1 fill 1 to 5 m along x and 1 to 3 m along y and z.
    assert entry["sectors"][0]["boundingVolume"]["box"] == [3, 2, 2, 2, 0, 0, 0, 1, 0, 0, 0, 1]


def test_contents_are_the_files_beside(tmp_path: Path) -> None:
    document = _write(tmp_path, small_map())
    for number, tile in enumerate(document["root"]["children"]):
        extension = tile["content"]["extensions"]["3DTILES_nav"]
        data = (tmp_path / tile["content"]["uri"]).read_bytes()
        assert extension["sha256"] == hashlib.sha256(data).hexdigest()
        assert (extension["contentId"], extension["level"]) == (number, 0)
        counts = open_glb(tmp_path / tile["content"]["uri"]).face_counts
        assert (extension["faceCount"], extension["objectCount"]) == (sum(counts), len(counts))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["contents", "nav", "tileset.json"]


def _inside(box: list[float], points: np.ndarray, allowance: float) -> bool:
    centre, axes = np.array(box[:3]), np.array(box[3:]).reshape(3, 3)
    lengths = np.linalg.norm(axes, axis=1)
    along = np.abs((points - centre) @ (axes / lengths[:, None]).T)
    return bool(np.all(along <= lengths + allowance))


def test_volumes_bound_what_the_files_hold(tmp_path: Path) -> None:
    document = _write(tmp_path, small_map())
    root = document["root"]
    for tile in root["children"]:
        glb = open_glb(tmp_path / tile["content"]["uri"])
        points = np.concatenate([glb.corners(i).reshape(-1, 3) for i in range(len(glb.primitives))])
        assert _inside(tile["boundingVolume"]["box"], points.astype(np.float64), 0.0)
        assert _inside(root["boundingVolume"]["box"], points.astype(np.float64), 0.0)
        # Tight: half a metre less on one side and a corner is outside.
        smaller = list(tile["boundingVolume"]["box"])
        smaller[3] -= 0.5
        assert not _inside(smaller, points.astype(np.float64), 0.0)
    assert (
        root["geometricError"] == document["geometricError"] == pytest.approx(math.sqrt(8**2 + 5**2 + 6**2))
    )
    assert [tile["geometricError"] for tile in root["children"]] == [0, 0]


def test_flat_box_has_a_volume() -> None:
    box = box_volume(np.array([0, 0, 5]), np.array([2048, 1023, 5]), STEP)
    assert box == [1.0, 1023 * STEP / 2, 5 * STEP, 1.0, 0, 0, 0, 1023 * STEP / 2, 0, 0, 0, STEP]


def test_transform_is_column_major_and_the_same_twice(tmp_path: Path) -> None:
    one = small_map()
    moved = np.array([[0.0, -1, 0, 4e6], [1, 0, 0, 5e5], [0, 0, 1, 4.9e6], [0, 0, 0, 1]])
    document = _write(tmp_path, replace(one, scene=replace(one.scene, tileset_from_nav=moved)))
    expected = [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 4e6, 5e5, 4.9e6, 1]
    assert document["root"]["transform"] == expected
    assert document["extensions"]["3DTILES_nav"]["transform"] == expected
    assert all("transform" not in tile for tile in document["root"]["children"])


def test_numbers_stand_on_one_line_and_text_is_left_alone(tmp_path: Path) -> None:
    one = small_map()
    provenance = {**one.provenance, "parameters": {"note": "[ 1, 2 ]", "name": "[\n 1\n]"}}
    document = _write(tmp_path, replace(one, provenance=provenance))
    lines = (tmp_path / "tileset.json").read_text(encoding="utf-8").splitlines()
    assert sum('"box": [' in line and line.rstrip(",").endswith("]") for line in lines) == 4
    parameters = document["extensions"]["3DTILES_nav"]["provenance"]["parameters"]
    assert parameters == {"note": "[ 1, 2 ]", "name": "[\n 1\n]"}


def test_same_map_same_bytes(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    _write(tmp_path / "a", small_map())
    _write(tmp_path / "b", small_map())
    files = [p.relative_to(tmp_path / "a") for p in sorted((tmp_path / "a").rglob("*")) if p.is_file()]
    assert len(files) == 4
    assert [(tmp_path / "a" / f).read_bytes() for f in files] == [
        (tmp_path / "b" / f).read_bytes() for f in files
    ]


def test_no_cells_are_refused(tmp_path: Path) -> None:
    one = small_map()
    empty = np.empty((0, 3), dtype=np.int64)
    none = replace(one.cells, lower=empty, upper=empty, corners=box_corners(empty, empty))
    with pytest.raises(EncodeError, match="no cell"):
        write_tileset(
            tmp_path,
            replace(one, cells=none),
            np.empty((0, 6, 4)),
            TilesetSettings(),
        )
    assert list(tmp_path.iterdir()) == []


def test_tables_of_another_length_are_refused(tmp_path: Path) -> None:
    one = small_map()
    pvs = replace(one.pvs, pvs_offsets=one.pvs.pvs_offsets[:-1])
    with pytest.raises(ValueError, match="pvs_offsets has 3 rows; needed are 4"):
        _write(tmp_path, replace(one, pvs=pvs))
