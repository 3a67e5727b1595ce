"""From a point cloud to a valid tileset that states its planes and has no cell in unknown space."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pygltflib
import pytest
from survey_fixture import site_from_above, write_las

from tilesnav_ref.cli import main
from tilesnav_ref.stream.reader import open_tileset
from tilesnav_validator.cli import main as validate

OPTIONS = ["--attempts", "8", "--rays", "500", "--min-cell", "4", "--max-cell", "16", "--quiet"]


@pytest.fixture(scope="module")
def points() -> np.ndarray:
    return site_from_above()


@pytest.fixture(scope="module")
def tileset(tmp_path_factory: pytest.TempPathFactory, points: np.ndarray) -> Path:
    folder = tmp_path_factory.mktemp("survey")
    cloud = write_las(folder / "site.las", points)
    assert main(["encode", str(cloud), str(folder / "out"), *OPTIONS]) == 0
    return folder / "out"


def test_the_tileset_is_valid(tileset: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert validate([str(tileset / "tileset.json"), "--rays", "20000"]) == 0
    assert "valid" in capsys.readouterr().out


def test_no_cell_has_a_return_above_its_lower_side(tileset: Path, points: np.ndarray) -> None:
    """Judged by the returns themselves: what is under one is unknown."""
    planes = np.concatenate([sector.planes for sector in open_tileset(tileset).sectors])
    assert len(planes) > 5
    assert not inside(planes, points - (0.0, 0.0, 0.05)).any()
    assert inside(planes, points - (0.0, 0.0, -2.0)).any(axis=1).mean() > 0.5


def inside(planes: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(P, C) whether each point is in each cell by its six planes."""
    distances = np.einsum("ckj,pj->pck", planes[:, :, :3], points) + planes[:, :, 3]
    return (distances <= 0).all(axis=2)


def test_provenance_states_the_cloud_and_its_settings(tileset: Path) -> None:
    nav = json.loads((tileset / "tileset.json").read_text())["extensions"]["3DTILES_nav"]
    found = nav["provenance"]["scene"]["survey"]
    assert found["points"] == 19200
    assert found["planes"] >= 2
    assert 0 < found["unknown_share"] < 1
    assert nav["provenance"]["parameters"]["survey"]["unknown_is_free"] is False


def test_every_face_names_its_plane(tileset: Path) -> None:
    for path in sorted((tileset / "contents").glob("*.glb")):
        document = pygltflib.GLTF2.load(str(path))
        table = document.extensions["EXT_structural_metadata"]["propertyTables"][0]
        blob = document.binary_blob()

        def column(name: str, dtype: str, width: int) -> np.ndarray:
            view = document.bufferViews[table["properties"][name]["values"]]  # noqa: B023
            assert view.byteOffset % 8 == 0
            return np.frombuffer(blob, dtype, table["count"] * width, view.byteOffset).reshape(-1, width)  # noqa: B023

        normals, offsets = column("normal", "<f8", 3), column("offset", "<f8", 1)
        assert np.allclose(np.linalg.norm(normals, axis=1), 1.0)
        for primitive in document.meshes[0].primitives:
            (feature,) = primitive.extensions["EXT_mesh_features"]["featureIds"]
            ids = _values(document, getattr(primitive.attributes, f"_FEATURE_ID_{feature['attribute']}"), 1)
            positions = _values(document, primitive.attributes.POSITION, 3)
            rows = ids[:, 0].astype(np.int64)
            on = rows != feature["nullFeatureId"]
            assert on.all() or (primitive.extras["name"] == "ground" and not on.any())
            rows, positions = rows[on], positions[on]
            assert feature["featureCount"] == max(len(np.unique(rows)), 1)
            assert feature["nullFeatureId"] == table["count"]
            assert rows.max(initial=0) < table["count"]
            distances = np.einsum("vk,vk->v", positions, normals[rows]) + offsets[rows, 0]
            assert np.abs(distances).max(initial=0.0) < 0.05


def _values(document: pygltflib.GLTF2, index: int, width: int) -> np.ndarray:
    accessor = document.accessors[index]
    begin = document.bufferViews[accessor.bufferView].byteOffset + accessor.byteOffset
    return np.frombuffer(document.binary_blob(), "<f4", accessor.count * width, begin).reshape(-1, width)
