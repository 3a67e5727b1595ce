"""A tileset goes in, and one that the validator accepts comes out, at the same place on Earth."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from tileset_fixture import (
    Y_UP_TO_Z_UP,
    axes,
    b3dm,
    earth_transform,
    ecef,
    glb,
    model,
    moved,
    subtree,
    tile,
    tileset,
    write,
)

from tilesnav_ref.cli import main
from tilesnav_ref.scene.tiles import read_tileset

PLACE = (4.9, 52.4, 40.0)
SIZES = ((10, 8, 12), (6, 6, 4))
"""Widths, depths and heights of two houses, metres."""
OPTIONS = ("--quiet", "--min-cell", "2", "--max-cell", "8", "--rays", "500", "--attempts", "4")


def house(number: int, x: float) -> tuple[np.ndarray, np.ndarray]:
    """A box on the ground: corners in the axes of a tile, and faces."""
    box = trimesh.creation.box(SIZES[number])
    box.apply_translation((x, 0, SIZES[number][2] / 2))
    return np.asarray(box.vertices), np.asarray(box.faces)


def city(folder: Path) -> tuple[Path, np.ndarray]:
    """Two houses 20 m off the middle, an external b3dm tile and an implicit glb tile; and where they are."""
    (west, west_faces), (east, east_faces) = house(0, -20), house(1, 20)
    flat = np.array(((-35, -20, 0), (35, -20, 0), (35, 20, 0), (-35, 20, 0)), float)
    ground = model(flat @ Y_UP_TO_Z_UP, [[0, 1, 2], [0, 2, 3]])
    first = b3dm(
        glb(*model((west - (0, 0, 3)) @ Y_UP_TO_Z_UP, west_faces, batch=np.zeros(8))),
        {"BATCH_LENGTH": 1, "RTC_CENTER": [0, 0, 3]},
        {"name": ["west"]},
    )
    tiling = {"subdivisionScheme": "OCTREE", "availableLevels": 1, "subtreeLevels": 1}
    every, none = {"constant": 1}, {"constant": 0}
    leaves = {"tileAvailability": every, "contentAvailability": [every], "childSubtreeAvailability": none}
    implicit = tile("east{level}.glb", implicitTiling={**tiling, "subtrees": {"uri": "s{level}"}})
    root = tile("coarse.glb", refine="REPLACE", transform=earth_transform(*PLACE))
    root["children"] = [tile("ground.glb"), tile("in/west.json"), implicit]
    files = {
        "tileset.json": tileset(root),
        "coarse.glb": glb(*model(np.eye(3) * 9)),
        "ground.glb": glb(*ground),
        "in/west.json": tileset(tile("west.b3dm", transform=moved(0, 0))),
        "in/west.b3dm": first,
        "east0.glb": glb(*model(east @ Y_UP_TO_Z_UP, east_faces)),
        "s0": subtree(leaves),
    }
    local = np.concatenate((flat, west, east))
    return write(folder, files), ecef(*PLACE) + local @ axes(*PLACE[:2])


@pytest.fixture(scope="module")
def encoded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, np.ndarray]:
    folder = tmp_path_factory.mktemp("city")
    path, positions = city(folder / "in")
    assert main(["encode", str(path), str(folder / "out"), *OPTIONS]) == 0
    return folder / "out", positions


def test_the_validator_accepts_it(encoded: tuple[Path, np.ndarray]) -> None:
    command = [sys.executable, "-m", "tilesnav_validator", str(encoded[0] / "tileset.json")]
    done = subprocess.run(
        [*command, "--json", "--rays", "20000"], capture_output=True, text=True, check=False, timeout=300
    )
    report: dict[str, Any] = json.loads(done.stdout)
    assert report["verdict"] == "valid", done.stdout[-2000:]


def test_it_is_where_the_input_was(encoded: tuple[Path, np.ndarray]) -> None:
    """The output is a tileset too: its contents, read like any other, lie on the positions of the input."""
    out, expected = encoded
    parts = read_tileset(out / "tileset.json", "auto", 10_000).parts
    found = np.concatenate([part.vertices for part in parts])
    away = np.linalg.norm(found[:, None] - expected, axis=2)
    assert away.min(axis=1).max() < 1e-3
    assert away.min(axis=0).max() < 1e-3
    matrix = np.reshape(json.loads((out / "tileset.json").read_text())["root"]["transform"], (4, 4)).T
    assert np.degrees(np.arccos(matrix[:3, 2] @ axes(*PLACE[:2])[2])) < 1e-3
    assert np.linalg.norm(matrix[:3, 3] - ecef(*PLACE)) < 5


def test_what_was_read_is_stated(encoded: tuple[Path, np.ndarray]) -> None:
    text = (encoded[0] / "tileset.json").read_text()
    assert "6 files were read, 3 of them contents with faces" in text
    assert "1 replaced by finer ones" in text
    assert "nav frame: east, north, up around longitude 4.9000" in text


def test_the_same_bytes_again(encoded: tuple[Path, np.ndarray], tmp_path: Path) -> None:
    path, _ = city(tmp_path / "elsewhere")
    assert main(["encode", str(path), str(tmp_path / "out"), *OPTIONS, "--threads", "1"]) == 0
    names = sorted(one.relative_to(encoded[0]).as_posix() for one in encoded[0].rglob("*") if one.is_file())
    for name in names:
        if name != "encode-report.json":
            assert (tmp_path / "out" / name).read_bytes() == (encoded[0] / name).read_bytes(), name
    assert len(names) >= 4
