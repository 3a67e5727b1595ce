"""A yard with a hedge, a screen seen from one side, and a range: encoded and put before the validator."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from test_encode_analytic import verdict

from tilesnav_ref.cli import main
from tilesnav_ref.stream.reader import NavTileset, open_tileset

SIZES = ("--min-cell", "2", "--max-cell", "8", "--altitude-min", "0", "--altitude-max", "6", "--rays", "500")


def plate(lower: tuple[float, ...], upper: tuple[float, ...], cuts: int) -> trimesh.Trimesh:
    """A rectangle in a plane of constant x (front towards +x) or z (upwards), in strips along y."""
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    ys = np.linspace(y0, y1, cuts + 1)
    first = [(x0, y, z0) for y in ys]
    second = [(x1, y, z1) for y in ys]
    vertices = np.array(first + second)
    n = cuts + 1
    quads = [(i, i + 1, n + i + 1, n + i) for i in range(cuts)]
    faces = [f for a, b, c, d in quads for f in ((a, b, c), (a, c, d))]
    if x0 != x1:
        faces = [face[::-1] for face in faces]
    return trimesh.Trimesh(vertices, faces, process=False)


@pytest.fixture(scope="module")
def yard(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Ground, a hedge at x = 10, a screen at x = 20, a wall at x = 30, each 20 m wide or more."""
    pieces = {
        "ground": plate((0, 0, 0), (40, 20, 0), 8),
        "hedge": plate((10, 0, 0), (10, 20, 7), 10),
        "screen": plate((20, 0, 0), (20, 20, 7), 10),
        "wall": plate((30, 0, 0), (30, 20, 7), 10),
    }
    scene = trimesh.Scene()
    for name, mesh in pieces.items():
        mesh.apply_transform(np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]]))
        scene.add_geometry(mesh, node_name=name, geom_name=name)
    path = tmp_path_factory.mktemp("yard") / "yard.glb"
    path.write_bytes(scene.export(file_type="glb"))
    return path


def encoded(yard: Path, out: Path, *options: str) -> NavTileset:
    assert main(["encode", str(yard), str(out), "--quiet", "--threads", "2", *SIZES, *options]) == 0
    return open_tileset(out)


def seen_from(tileset: NavTileset, low: float, high: float) -> dict[str, float]:
    """Share of the faces of each piece that the cells between two x list together."""
    planes = tileset.sectors[0].planes
    first, last = planes[:, :, 3][planes[:, :, 0] == -1], -planes[:, :, 3][planes[:, :, 0] == 1]
    inside = (first >= low) & (last <= high)
    listed = {int(f) for cell in np.flatnonzero(inside) for f in tileset.state(int(cell)).faces}
    assert inside.any()
    x = tileset.corners(0)[:, :, 0]
    places = {"hedge": 10, "screen": 20, "wall": 30}
    found = {}
    for name, at in places.items():
        own = np.flatnonzero((x == at).all(axis=1))
        found[name] = len(listed.intersection(own.tolist())) / len(own)
    return found


def verdicts(out: Path) -> dict[str, str]:
    return {row["id"]: row["verdict"] for row in verdict(out)["requirements"]}


GOOD = {"pass", "not refuted"}


def test_a_hedge_hides_nothing_where_it_is_transparent(yard: Path, tmp_path: Path) -> None:
    opaque = encoded(yard, tmp_path / "opaque")
    assert seen_from(opaque, 0, 10) == {"hedge": 1, "screen": 0, "wall": 0}
    porous = encoded(yard, tmp_path / "porous", "--transparent", "hed*")
    assert seen_from(porous, 0, 10) == {"hedge": 1, "screen": 1, "wall": 0}
    assert len(porous.porous_objects) == 1
    assert set(verdicts(tmp_path / "porous").values()) == GOOD


def test_a_screen_is_seen_from_its_front_and_hides_from_both_sides(yard: Path, tmp_path: Path) -> None:
    tileset = encoded(yard, tmp_path / "out", "--one-sided", "screen")
    assert seen_from(tileset, 10, 20) == {"hedge": 1, "screen": 0, "wall": 0}
    assert seen_from(tileset, 20, 30) == {"hedge": 0, "screen": 1, "wall": 1}
    assert set(verdicts(tmp_path / "out").values()) == GOOD


def test_all_three_at_once_and_a_range_that_is_not_stated(yard: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    options = ("--transparent", "hedge", "--transparent", "screen", "--one-sided", "*", "--max-range", "12")
    tileset = encoded(yard, out, *options)
    assert seen_from(tileset, 0, 10)["wall"] == 0
    assert seen_from(tileset, 20, 30) == {"hedge": 1, "screen": 1, "wall": 0}
    assert set(verdicts(out).values()) == GOOD
    document: dict[str, Any] = json.loads((out / "tileset.json").read_text())
    del document["extensions"]["3DTILES_nav"]["visibility"]
    (out / "tileset.json").write_text(json.dumps(document))
    assert verdicts(out)["pvs/conservative"] == "fail"
