"""Scenes with known visibility, encoded and put before the validator as a program of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from tilesnav_ref.cli import main
from tilesnav_ref.scene.analytic import SCENES
from tilesnav_ref.stream.figures import figures
from tilesnav_ref.stream.reader import open_tileset
from tilesnav_ref.stream.state import apply_delta

RAYS = "200000"
CASES = {
    "box_in_room": ("--keep-interiors", "--min-cell", "1"),
    "l_corridor": ("--keep-interiors", "--min-cell", "1", "--sector-cells", "7"),
    "two_walls": ("--min-cell", "2", "--max-cell", "8"),
    "ridge": ("--cells", "voxel", "--voxel-size", "4"),
    "party_walls": ("--keep-interiors", "--min-cell", "1", "--clearance", "0"),
    "slot": ("--crs", "enu", "--origin", "11.57,48.14,520", "--min-cell", "2"),
}


def write_scene(name: str, path: Path) -> int:
    """Write the mesh of an analytic scene as PLY, exactly, and return its number of faces."""
    scene = SCENES[name]().scene
    metres = scene.vertices * np.float64(scene.step)
    path.write_bytes(trimesh.Trimesh(metres, scene.faces, process=False).export(file_type="ply"))
    return scene.face_count


def encode_scene(name: str, folder: Path, *options: str) -> Path:
    """Encode an analytic scene and return the tileset's folder."""
    write_scene(name, folder / "scene.ply")
    arguments = [
        "encode",
        str(folder / "scene.ply"),
        str(folder / "out"),
        "--quiet",
        "--rays",
        "2000",
        *options,
    ]
    assert main(arguments) == 0
    return folder / "out"


def verdict(out: Path) -> dict[str, Any]:
    """Run the validator and return its report."""
    command = [
        sys.executable,
        "-m",
        "tilesnav_validator",
        str(out / "tileset.json"),
        "--json",
        "--rays",
        RAYS,
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode in (0, 1), done.stderr
    report: dict[str, Any] = json.loads(done.stdout)
    return report


def test_the_validator_finds_nothing(tmp_path: Path) -> None:
    report = verdict(encode_scene("box_in_room", tmp_path, *CASES["box_in_room"]))
    verdicts = {one["id"]: one["verdict"] for one in report["requirements"]}
    assert set(verdicts.values()) == {"pass", "not refuted"}, verdicts
    assert report["verdict"] == "valid"


@pytest.mark.parametrize("name", CASES)
def test_the_validator_accepts_every_certificate(tmp_path: Path, name: str) -> None:
    out = encode_scene(name, tmp_path, "--certificates", *CASES[name])
    report = verdict(out)
    verdicts = {one["id"]: one["verdict"] for one in report["requirements"]}
    assert verdicts.pop("pvs/conservative") == "proved"
    assert set(verdicts.values()) == {"pass"}, verdicts
    assert report["verdict"] == "valid"
    sizes = figures(open_tileset(out))["bytes"]
    assert sizes["certificates"] == sum(path.stat().st_size for path in out.glob("nav/*.cert")) > 0
    others = [p for p in out.rglob("*") if p.is_file() and p.name != "encode-report.json"]
    assert sizes["total"] == sum(path.stat().st_size for path in others)


def test_a_long_random_walk_over_the_deltas(tmp_path: Path) -> None:
    sizes = ("--min-cell", "1", "--max-cell", "2", "--sector-cells", "10")
    out = encode_scene("box_in_room", tmp_path, "--keep-interiors", *sizes)
    tileset = open_tileset(out)
    random = np.random.default_rng(5)
    cell, visited = 0, {0}
    state = tileset.state(cell)
    for _ in range(500):
        following = int(random.choice(tileset.neighbours(cell)))
        state = apply_delta(state, tileset.delta(cell, following), tileset.object_offsets)
        cell = following
        visited.add(cell)
        assert state.digest() == tileset.digest(cell)
    assert len(visited) > 20


def test_a_georeferenced_scene_stands_on_the_earth(tmp_path: Path) -> None:
    out = encode_scene("slot", tmp_path, *CASES["slot"])
    origin = open_tileset(out).tileset_from_nav[:3, 3]
    # The ellipsoid's radius of curvature at 48.14 degrees: positions there are 6,366 km from the centre.
    assert np.linalg.norm(origin) == pytest.approx(6_366_600, abs=1_500)
    assert np.degrees(np.arctan2(origin[1], origin[0])) == pytest.approx(11.57, abs=1e-9)


def test_published_faces_are_those_of_the_scene(tmp_path: Path) -> None:
    faces = write_scene("l_corridor", tmp_path / "scene.ply")
    tileset = open_tileset(encode_scene("l_corridor", tmp_path, "--keep-interiors", "--min-cell", "1"))
    assert tileset.face_count == tileset.provenance["scene"]["faces"] >= faces
    corners = np.concatenate([tileset.corners(i) for i in range(len(tileset.contents))]).astype(np.float64)
    scene = SCENES["l_corridor"]().scene
    areas = [_area(corners), _area(scene.corners() * scene.step)]
    assert areas[0] == pytest.approx(areas[1], rel=1e-12)


def _area(corners: np.ndarray) -> float:
    edges = corners[:, 1:] - corners[:, :1]
    return float(np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).sum() / 2)
