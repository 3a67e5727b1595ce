"""Bad input: exit status, one line of message, nothing left behind."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tilesnav_ref import cli
from tilesnav_ref.cli import main
from tilesnav_ref.scene import load_scene
from tilesnav_ref.scene.sample import make_town

Make = Callable[[Path], list[str]]


def write_wall(path: Path) -> str:
    """A wall of two faces on a ground of two, 16 m wide."""
    ground = [[0, 0, 0], [16, 0, 0], [16, 16, 0], [0, 16, 0]]
    wall = [[0, 8, 0], [16, 8, 0], [16, 8, 6], [0, 8, 6]]
    faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]
    path.write_bytes(trimesh.Trimesh(np.array(ground + wall), faces, process=False).export(file_type="ply"))
    return str(path)


def _with(text: str | bytes, name: str = "scene.ply") -> Make:
    def make(folder: Path) -> list[str]:
        (folder / name).write_bytes(text.encode() if isinstance(text, str) else text)
        return ["encode", str(folder / name), str(folder / "out")]

    return make


def _wall(*options: str) -> Make:
    return lambda folder: ["encode", write_wall(folder / "scene.ply"), str(folder / "out"), *options]


def _existing(folder: Path) -> list[str]:
    (folder / "out").mkdir()
    return _wall()(folder)


PLY = "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
FACES = "element face 1\nproperty list uchar int vertex_indices\nend_header\n"

BAD: dict[str, tuple[Make, int, str]] = {
    "no command": (lambda _: [], 2, "COMMAND"),
    "unknown command": (lambda _: ["fly"], 2, "fly"),
    "unknown option": (_wall("--fast"), 2, "--fast"),
    "missing argument": (lambda _: ["encode", "x"], 2, "OUT"),
    "no such scene": (lambda f: ["encode", str(f / "no.ply"), str(f / "out")], 2, "no.ply"),
    "empty file": (_with(""), 2, "scene.ply"),
    "text as ply": (_with("Dear reader,\n"), 2, "scene.ply"),
    "unknown ending": (_with("x", "scene.doc"), 2, "scene.doc"),
    "nan": (_with(PLY.format(3) + FACES + "0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n"), 2, "scene.ply"),
    "index out of range": (_with(PLY.format(3) + FACES + "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"), 2, "scene.ply"),
    "billions claimed": (_with(PLY.format(4_000_000_000) + FACES + "0 0 0\n"), 2, "scene.ply"),
    "out exists": (_existing, 2, "exists already; --force"),
    "out in nothing": (lambda f: [*_wall()(f)[:2], str(f / "no" / "out")], 2, "not a folder"),
    "three numbers": (_wall("--region", "-1,-1,5"), 2, "4 numbers with commas"),
    "no numbers": (_wall("--region", "a,b,c,d"), 2, "a finite number"),
    "infinite": (_wall("--clearance", "inf"), 2, "a finite number"),
    "negative clearance": (_wall("--clearance", "-1"), 2, "clearance"),
    "cells of no size": (_wall("--min-cell", "0"), 2, "min_size"),
    "negative rays": (_wall("--rays", "-5"), 2, "an integer from 0"),
    "half a thread": (_wall("--threads", "0.5"), 2, "an integer from 0"),
    "too many codes": (_wall("--lod-levels", "257"), 2, "an integer from 1 to 256"),
    "grid too fine": (_wall("--grid", "-30"), 2, "grid_exponent"),
    "region elsewhere": (_wall("--region", "100,100,200,200"), 2, "region"),
    "no free space": (_wall("--clearance", "50"), 1, "no free space"),
    "info of nothing": (lambda f: ["info", str(f / "no")], 2, "readable file"),
    "info of a scene": (lambda f: ["info", write_wall(f / "scene.ply")], 2, "no JSON"),
    "sample of a wrong ending": (lambda f: ["sample", str(f / "town.doc")], 2, "allowed: .ply, .glb"),
    "sample exists": (lambda f: ["sample", write_wall(f / "scene.ply")], 2, "exists already"),
    "sample in nothing": (lambda f: ["sample", str(f / "no" / "town.ply")], 2, "not a folder"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    make, status, message = BAD[name]
    arguments = make(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    assert main(arguments) == status
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("tilesnav: error: ")
    assert message in captured.err
    assert captured.err.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(
    ("stop", "status", "message"),
    [
        (KeyboardInterrupt(), 130, "SIGINT"),
        (MemoryError(), 1, "not enough memory"),
        (OSError(28, "No space left on device"), 2, "No space left"),
        (ZeroDivisionError("x"), 3, "internal error: ZeroDivisionError: x"),
    ],
)
def test_what_stops_an_encode_leaves_nothing_behind(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    stop: BaseException,
    status: int,
    message: str,
) -> None:
    def stopped(*_: object) -> None:
        raise stop

    arguments = _wall()(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    monkeypatch.setattr("tilesnav_ref.encode.compute_pvs", stopped)
    assert main(arguments) == status
    assert message in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == before


def test_debug_prints_where(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(cli, "check_output", broken)
    assert main([*_wall()(tmp_path), "--debug"]) == 3
    assert "Traceback" in capsys.readouterr().err


def test_the_handler_of_sigterm_is_put_back(tmp_path: Path) -> None:
    before = signal.getsignal(signal.SIGTERM)
    assert main(["info", str(tmp_path)]) == 2
    assert signal.getsignal(signal.SIGTERM) is before


@pytest.mark.parametrize("command", [[], ["encode"], ["info"], ["sample"]])
def test_help_states_the_exit_status(capsys: pytest.CaptureFixture[str], command: list[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main([*command, "--help"])
    assert stop.value.code == 0
    text = capsys.readouterr().out
    assert all(f"\n  {status}  " in text for status in range(4))


def test_sample_is_the_town_exactly(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "town.ply"
    assert main(["sample", str(out), "--seed", "2", "--terrain"]) == 0
    mesh = trimesh.load(out, process=False)
    assert f"{len(mesh.faces)} faces" in capsys.readouterr().out
    grid = np.asarray(mesh.vertices) * 1024
    assert np.array_equal(grid, np.rint(grid))
    assert [path.name for path in tmp_path.iterdir()] == ["town.ply"]
    again = tmp_path / "again.ply"
    assert main(["sample", str(again), "--seed", "2", "--terrain"]) == 0
    assert again.read_bytes() == out.read_bytes()


def test_sample_as_gltf_keeps_its_objects(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "town.glb"
    assert main(["sample", str(out)]) == 0
    scene, _ = load_scene(out)
    town = make_town()
    assert f"{town.object_count} objects" in capsys.readouterr().out
    assert scene.object_count > 1
    published, made = (
        {frozenset(map(tuple, face)) for face in one.corners().tolist()} for one in (scene, town)
    )
    assert published == made


def test_info_prints_a_table_and_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = _wall("--quiet", "--rays", "200")(tmp_path)
    assert main(arguments) == 0
    assert capsys.readouterr().out == ""
    assert main(["info", arguments[2]]) == 0
    assert "overestimate" in capsys.readouterr().out
    assert main(["info", arguments[2], "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert set(figures["pvs"]) == {"mean", "p95", "max", "proven_mean", "overestimate"}
    assert {"mean_entered", "bytes"} <= set(figures["delta"])
    assert set(figures["bytes"]["nav"]) == {"cells", "portals", "pvs", "lod", "deltas", "other"}
    assert list(figures["seconds"]) == ["scene", "cells", "visibility", "levels", "deltas", "write"]
    assert figures["peak_memory"] > 2**20
    assert figures["faces"] == 6  # the ends of the wall divide both faces of the ground
    files = [p for p in Path(arguments[2]).rglob("*") if p.is_file() and p.name != "encode-report.json"]
    assert figures["bytes"]["total"] == sum(p.stat().st_size for p in files)
