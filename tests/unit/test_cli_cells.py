"""`tilesnav cells`: figures, pictures and what is refused."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from mission_scenes import box_faces, rectangle

from tilesnav_ref.cells import CellSettings, decompose
from tilesnav_ref.cells.picture import SIDES, check_picture, make_view
from tilesnav_ref.cli import main
from tilesnav_ref.commands.arguments import cell_settings, parse
from tilesnav_ref.scene import load_scene

PLOTTED = pytest.importorskip("matplotlib", reason="pictures are an extra")
FEW = ("--max-cell", "8", "--altitude-max", "16", "--coverage-points", "500", "--quiet")


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A house on a square, with the ground as a part of its own."""
    path = tmp_path_factory.mktemp("scene") / "house.obj"
    parts = {"soil": rectangle((0, 32), (0, 32), (0, 0)), "house": box_faces((8, 8, 0), (20, 20, 6))}
    lines, count = [], 0
    for name, faces in parts.items():
        lines.append(f"o {name}")
        for face in faces:
            lines += [f"v {x} {y} {z}" for x, y, z in face]
            lines.append(f"f {count + 1} {count + 2} {count + 3}")
            count += 3
    path.write_text("\n".join(lines) + "\n")
    return path


def test_figures_as_json(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["cells", str(scene), "--up", "z", *FEW, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["cells"] > 10
    assert found["parts"] == [found["cells"]]
    assert 0.5 < found["coverage"] <= 1.0
    assert found["clearance"] == 0.25
    assert [band["from"] for band in found["coverage_by_height"]] == [0.0, 5.0, 10.0]
    points = sum(band["points"] for band in found["coverage_by_height"])
    covered = sum(band["points"] * band["coverage"] for band in found["coverage_by_height"])
    assert covered / points == pytest.approx(found["coverage"])
    assert found["seconds"].keys() == {"scene", "cells", "plot"}


@pytest.mark.parametrize(
    ("options", "kind"),
    [
        (("--mission", "ground", "--min-cell", "1", "--terrain", "soil", "--max-cell", "8"), "ground"),
        (("--mission", "corridor", "--corridor", "-1,4,9;31,4,9", *FEW), "aerial"),
        (("--sector-size", "16", "--sector", "1,0", *FEW), "aerial"),
    ],
)
def test_missions_and_sectors(
    scene: Path, options: tuple[str, ...], kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (
        main(["cells", str(scene), "--up", "z", *options, "--json", "--quiet", "--coverage-points", "500"])
        == 0
    )
    found = json.loads(capsys.readouterr().out)
    assert found["cells"] > 0
    assert (found["ground_cells"] == found["cells"]) == (kind == "ground")


@pytest.mark.parametrize(("name", "head"), [("plot.png", b"\x89PNG"), ("plot.svg", b"<?xml")])
def test_picture_is_written(
    scene: Path, tmp_path: Path, name: str, head: bytes, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / name
    assert main(["cells", str(scene), "--up", "z", *FEW, "--plot", str(out)]) == 0
    assert out.read_bytes().startswith(head)
    assert len(out.read_bytes()) > 10_000
    printed = capsys.readouterr().out
    assert "connected parts, cells" in printed
    assert "height above the ground" in printed


def test_view_shows_every_cell_and_every_portal_once(scene: Path) -> None:
    settings = cell_settings(parse(["cells", str(scene), "--up", "z"]))
    loaded, _ = load_scene(scene, settings[0])
    cells = decompose(loaded, CellSettings(max_size=8.0, altitude_max=16.0, coverage_points=100))
    view = make_view(loaded, cells)
    assert view.sides.shape == (cells.count, 6, 4, 3)
    assert len(view.paths) == cells.portal_count // 2
    # a portal is in both of the cells that its path joins
    low, high = cells.lower * loaded.step, cells.upper * loaded.step
    inside = np.all((low <= view.paths[:, None, 1]) & (view.paths[:, None, 1] <= high), axis=2)
    assert np.all(inside.sum(axis=1) >= 2)
    for corners in SIDES:
        shared = [sum((corner >> axis) & 1 for corner in corners) for axis in range(3)]
        assert sorted(shared) in ([0, 2, 2], [2, 2, 4])  # four corners on one side of one axis
        ring = [bin(a ^ b).count("1") for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
        assert ring == [1, 1, 1, 1]


@pytest.mark.parametrize(
    ("options", "status", "message"),
    [
        (("--plot", "picture.bmp"), 2, "allowed: .png, .svg, .pdf"),
        (("--plot", "nowhere/picture.png"), 2, "is not a folder"),
        (("--sector", "0,0"), 2, "without sector_size"),
        (("--sector", "a,b", "--sector-size", "16"), 2, "integer"),
        (("--sector", "0,0,0", "--sector-size", "16"), 2, "two integers"),
        (("--sector", "9,9", "--sector-size", "16"), 1, "holds no part"),
        (("--mission", "corridor"), 2, "2 or more points"),
        (("--mission", "corridor", "--corridor", "1,2;3,4"), 2, "3 numbers"),
        (("--mission", "corridor", "--corridor", "none.csv"), 2, "cannot be read"),
        (("--mission", "ground", "--altitude-max", "9"), 2, "ground_height alone"),
        (("--terrain", "lawn"), 2, "'house'"),
        (("--ground-slope", "-1"), 2, "ground_slope"),
        (("--altitude-max", "1e300"), 1, "altitude_max is 1e+300 m; allowed: less than 8192 m"),
        (("--sector-size", "1e300"), 1, "sector_size is 1e+300 m; allowed: less than 8192 m"),
        (("--mission", "ground", "--ground-step", "1e300"), 1, "ground_step is 1e+300 m; allowed: less than"),
        (("--clearance", "1e300"), 1, "clearance is 1e+300 m; allowed: less than 8192 m"),
        (("--mission", "corridor", "--corridor", "4,4,28;9,9,28"), 1, "is connected to a point of the corr"),
    ],
)
def test_what_is_wrong_is_said(
    scene: Path, options: tuple[str, ...], status: int, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["cells", str(scene), "--up", "z", *options, "--quiet"]) == status
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("line.csv", "x,y,z\n1,2,3\n4,5,6\n"),
        ("line.csv", "1, 2, 3\n4, 5, 6\n"),
        ("line.json", "[[1, 2, 3], [4.0, 5, 6]]"),
    ],
)
def test_line_of_a_corridor_from_a_file(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    given = parse(["cells", "scene.ply", "--mission", "corridor", "--corridor", str(tmp_path / name)])
    assert given.corridor == ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0))


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("line.csv", "1,2\n", "point 1"),
        ("line.json", "{}", "a list of points"),
        ("line.json", "[[1, 2", "no JSON"),
        ("line.json", '[[1, 2, "x"], [1, 2, 3]]', "finite number"),
    ],
)
def test_bad_file_of_a_corridor(
    tmp_path: Path, name: str, text: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_text(text)
    assert main(["cells", "scene.ply", "--mission", "corridor", "--corridor", str(tmp_path / name)]) == 2
    assert message in capsys.readouterr().err


def test_missing_matplotlib_names_the_extra(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(Exception, match=r"tilesnav\[plot\]"):
        check_picture(tmp_path / "plot.png")


def test_scene_named_by_its_mesh_is_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    faces = rectangle((0, 32), (0, 32), (0, 0))
    trimesh.Trimesh(faces.reshape(-1, 3), np.arange(6).reshape(-1, 3), process=False).export(
        tmp_path / "a.ply"
    )
    assert main(["cells", str(tmp_path / "a.ply"), *FEW]) == 0
    assert "cells" in capsys.readouterr().out
