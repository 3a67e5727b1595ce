"""Tilesets that others made: the counts and extents that their descriptions state, in float64."""

from __future__ import annotations

import tarfile
from pathlib import Path

import numpy as np
import pytest
from tileset_fixture import A, B, ecef

from tilesnav_ref.scene import SceneError, SceneSettings
from tilesnav_ref.scene.parts import MeshFile
from tilesnav_ref.scene.tiles import place, read_tileset

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"

pytestmark = [
    pytest.mark.realdata,
    pytest.mark.skipif(not DATA.is_dir(), reason="../shared/data is not beside the checkout"),
]


def read(path: Path) -> tuple[MeshFile, np.ndarray]:
    mesh = read_tileset(path, "auto", 20_000_000)
    return mesh, np.concatenate([part.vertices for part in mesh.parts])


def geodetic(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Longitude, latitude and height, by iteration on the latitude."""
    flat = np.hypot(positions[:, 0], positions[:, 1])
    square = 1 - (B / A) ** 2
    latitude = np.arctan2(positions[:, 2], flat * (1 - square))
    for _ in range(6):
        normal = A / np.sqrt(1 - square * np.sin(latitude) ** 2)
        height = flat / np.cos(latitude) - normal
        latitude = np.arctan2(positions[:, 2], flat * (1 - square * normal / (normal + height)))
    return np.degrees(np.arctan2(positions[:, 1], positions[:, 0])), np.degrees(latitude), height


def unpacked(archive: Path, folder: Path) -> Path:
    with tarfile.open(archive) as tar:
        tar.extractall(folder, filter="data")
    return folder


def test_amsterdam() -> None:
    mesh, positions = read(DATA / "amsterdam_3dtiles10" / "tileset.json")
    assert sum(len(part.faces) for part in mesh.parts) == 35_102
    longitude, latitude, height = geodetic(positions)
    assert (longitude.min(), longitude.max()) == pytest.approx((4.8871, 4.9603), abs=1e-4)
    assert (latitude.min(), latitude.max()) == pytest.approx((52.3709, 52.4051), abs=1e-4)
    assert (height.min(), height.max()) == pytest.approx((39.4, 85.3), abs=0.05)
    frame = place("amsterdam", positions, SceneSettings())
    back = frame.positions @ frame.tileset_from_nav[:3, :3].T + frame.tileset_from_nav[:3, 3]
    assert np.abs(back - positions).max() < 1e-8  # float64 at the radius of the Earth has steps of 1e-9 m
    assert np.abs(frame.positions[:, :2]).max() < 2_600  # half of 5.0 x 3.8 km: the frame is at the middle
    assert "0363100012075795" in {label for part in mesh.parts for label in part.labels}


def test_delaware_is_implicit_and_compressed() -> None:
    pytest.importorskip("DracoPy", reason="DracoPy is not installed (extra tiles)")
    mesh, positions = read(DATA / "delaware_3dtiles_implicit" / "tileset.json")
    assert (sum(len(part.faces) for part in mesh.parts), len(positions)) == (440_818, 1_294_964)
    assert "59 of them contents" in mesh.notes[0]
    longitude, latitude, height = geodetic(positions)
    assert (longitude.min(), longitude.max()) == pytest.approx((-75.5916, -75.4466), abs=1e-4)
    assert (latitude.min(), latitude.max()) == pytest.approx((39.0894, 39.2305), abs=1e-4)
    assert (height.min(), height.max()) == pytest.approx((-1.1, 77.1), abs=0.05)
    frame = place("delaware", positions, SceneSettings())
    assert np.abs(frame.positions[:, :2]).max() < 8_000  # 12.5 x 15.7 km: all of it is on the grid


def test_rotterdam_is_projected(tmp_path: Path) -> None:
    folder = DATA / "rotterdam_3dtiles10_epsg3857"
    path = unpacked(folder / "rotterdam_3dtiles_small.tar.gz", tmp_path) / "tileset.json"
    mesh, positions = read(path)
    assert (sum(len(part.faces) for part in mesh.parts), len(positions)) == (308_277, 924_831)
    frame = place("rotterdam", positions, SceneSettings())
    assert np.array_equal(frame.tileset_from_nav[:3, :3], np.eye(3))
    assert frame.tileset_from_nav[:2, 3] == pytest.approx((499946, 6783362), abs=300)
    extent = frame.positions.max(axis=0) - frame.positions.min(axis=0)
    assert extent == pytest.approx((6779, 4545, 175), abs=2)


def test_rotterdam_where_it_is(tmp_path: Path) -> None:
    """With its coordinate system said, horizontal lengths are true and the place is Rotterdam."""
    pytest.importorskip("pyproj", reason="pyproj is not installed (extra crs)")
    folder = DATA / "rotterdam_3dtiles10_epsg3857"
    path = unpacked(folder / "rotterdam_3dtiles_small.tar.gz", tmp_path) / "tileset.json"
    frame = place("rotterdam", read(path)[1], SceneSettings(crs="EPSG:3857"))
    extent = frame.positions.max(axis=0) - frame.positions.min(axis=0)
    assert extent[:2] == pytest.approx((4180, 2800), rel=0.01)
    away = np.linalg.norm(frame.tileset_from_nav[:3, 3] - ecef(4.4911, 51.9, 0.0))
    assert away < 10_000


SAMPLES = {
    "1.1/SparseImplicitQuadtree": (32, 64),
    "1.1/SparseImplicitOctree": (31, 372),
    "1.1/MetadataGranularities": (20, 10_868),
    "1.1/MultipleContents": (1, 2_048),
    "glTF/GpuInstancesMetadata": (1, 120),
    "glTF/EXT_mesh_features/FeatureIdAttribute": (4, 8),
}


def test_samples(tmp_path: Path) -> None:
    folder = unpacked(DATA / "tiles_conformance" / "samples_cc0.tar.gz", tmp_path)
    for name, expected in SAMPLES.items():
        mesh = read_tileset(folder / name / "tileset.json", "auto", 100_000)
        assert (len(mesh.parts), sum(len(part.faces) for part in mesh.parts)) == expected, name
    with pytest.raises(SceneError, match=r"'dragon_high.b3dm', which is not there"):
        read_tileset(folder / "1.0/TilesetWithDiscreteLOD/tileset.json", "auto", 100_000)
    with pytest.raises(SceneError, match=r"no face \(2 i3dm\)"):
        read_tileset(folder / "1.0/TilesetWithTreeBillboards/tileset.json", "auto", 100_000)


def test_tilesets_of_tilesets_and_broken_ones(tmp_path: Path) -> None:
    folder = unpacked(DATA / "tiles_conformance" / "validator_specs_data.tar.gz", tmp_path)
    entries = sorted(folder.rglob("Samples/TilesetOfTilesets/tileset.json"))
    assert len(entries) == 1
    mesh, positions = read(entries[0])
    assert sum(len(part.faces) for part in mesh.parts) == 600
    assert "8 files were read, 5 of them contents" in mesh.notes[0]
    assert np.abs(geodetic(positions)[1] - 40.04).max() < 0.01
    read_or_refused = 0
    for path in sorted(folder.rglob("*.json")):
        try:
            read_tileset(path, "auto", 100_000)
            read_or_refused += 1
        except SceneError as error:
            read_or_refused += "; allowed: " in str(error)
    assert read_or_refused == len(list(folder.rglob("*.json"))) > 600
