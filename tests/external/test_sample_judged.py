"""What others say about the sample town: the Khronos validator about its glTF, CesiumJS about the whole."""

from __future__ import annotations

import json
import shutil
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tilesnav_ref.cli import main

pytestmark = pytest.mark.node
Judge = Callable[..., str]

FLOAT32_SLACK = 1e-3
"""Metres a position may lie outside CesiumJS's sphere: float32 positions of a town of 100 m, and rounding."""


@pytest.fixture(scope="module")
def town(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Tileset of the coarse sample town; few rays, since no judge here looks at visibility."""
    folder = tmp_path_factory.mktemp("town")
    scene, out = folder / "town.ply", folder / "tileset"
    assert main(["sample", str(scene), "--detail", "coarse", "--size", "small"]) == 0
    few = ["--rays", "200", "--attempts", "0", "--min-cell", "8", "--max-cell", "32"]
    assert main(["encode", str(scene), str(out), "--quiet", *few]) == 0
    return out


@pytest.fixture
def damaged(town: Path, tmp_path: Path) -> Path:
    """A copy that a test may damage."""
    return Path(shutil.copytree(town, tmp_path / "damaged"))


def entry(folder: Path) -> Any:
    return json.loads((folder / "tileset.json").read_text(encoding="utf-8"))


def rewrite(folder: Path, change: Callable[[Any], None]) -> None:
    document = entry(folder)
    change(document)
    (folder / "tileset.json").write_text(json.dumps(document), encoding="utf-8")


def gltf_reports(judge: Judge, folder: Path) -> list[Any]:
    files = sorted(folder.rglob("*.glb"))
    assert files
    reports = [json.loads(line) for line in judge("gltf_validate.mjs", *files).splitlines()]
    assert [report["file"] for report in reports] == [str(file) for file in files]
    return reports


def cesium(judge: Judge, folder: Path) -> Any:
    return json.loads(judge("cesium_load.mjs", folder / "tileset.json"))


@pytest.fixture(scope="module")
def seen(judge: Judge, town: Path) -> Any:
    """What CesiumJS sees in the town."""
    return cesium(judge, town)


def test_gltf_validator_finds_no_error_and_no_warning(judge: Judge, town: Path) -> None:
    faulty = [one for one in gltf_reports(judge, town) if one["errors"] or one["warnings"]]
    assert faulty == []


def test_gltf_validator_notices_a_position_that_is_no_number(judge: Judge, damaged: Path) -> None:
    file = min(damaged.rglob("*.glb"))
    data = bytearray(file.read_bytes())
    json_length = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + json_length])
    positions = document["accessors"][document["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
    start = document["bufferViews"][positions["bufferView"]].get("byteOffset", 0) + positions.get(
        "byteOffset", 0
    )
    struct.pack_into("<f", data, 20 + json_length + 8 + start, float("nan"))
    file.write_bytes(data)
    reports = {report["file"]: report["errors"] for report in gltf_reports(judge, damaged)}
    assert reports[str(file)] > 0


def test_cesium_reads_the_extension_at_run_time(seen: Any, town: Path) -> None:
    assert seen["nav"] == entry(town)["extensions"]["3DTILES_nav"]
    assert seen["asset"]["version"] == "1.1"


def test_cesium_loads_every_content_and_counts_the_same_faces(seen: Any) -> None:
    nav = seen["nav"]
    assert seen["missing"] == []
    assert sorted(one["nav"]["contentId"] for one in seen["contents"]) == list(range(len(seen["contents"])))
    assert sum(one["triangles"] for one in seen["contents"]) == nav["faceCount"]
    assert sum(one["primitives"] for one in seen["contents"]) == nav["objectCount"]
    assert [one for one in seen["contents"] if one["triangles"] != one["nav"]["faceCount"]] == []


def test_cesium_culls_no_position_of_a_visible_tile(seen: Any) -> None:
    assert max(one["outside"] for one in seen["contents"]) <= FLOAT32_SLACK


def test_cesium_loads_the_same_without_the_extension(judge: Judge, seen: Any, damaged: Path) -> None:
    def strip(document: Any) -> None:
        del document["extensions"], document["extensionsUsed"]

    rewrite(damaged, strip)
    without = cesium(judge, damaged)
    assert without["nav"] is None
    assert without["contents"] == seen["contents"]


def test_the_cesium_judge_notices_a_volume_that_does_not_bound(judge: Judge, damaged: Path) -> None:
    def shrink(document: Any) -> None:
        volume = document["root"]["children"][0]["boundingVolume"]
        volume["box"][3:] = [value / 100 for value in volume["box"][3:]]

    rewrite(damaged, shrink)
    assert max(one["outside"] for one in cesium(judge, damaged)["contents"]) > 1


def test_the_cesium_judge_notices_a_content_that_is_missing(judge: Judge, damaged: Path) -> None:
    min(damaged.rglob("*.glb")).unlink()
    with pytest.raises(AssertionError, match=r"404|Failed to load"):
        cesium(judge, damaged)


def test_a_required_extension_would_shut_viewers_out(judge: Judge, damaged: Path) -> None:
    """The reason behind core/extension-optional."""

    def require(document: Any) -> None:
        document["extensionsRequired"] = ["3DTILES_nav"]

    rewrite(damaged, require)
    with pytest.raises(AssertionError, match="3DTILES_nav"):
        cesium(judge, damaged)
