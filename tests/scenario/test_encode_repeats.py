"""The same input gives the same bytes, and a run that is stopped leaves nothing."""

from __future__ import annotations

import hashlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tilesnav_ref.cli import main
from tilesnav_ref.scene.analytic import SCENES
from tilesnav_ref.stream.reader import open_tileset
from tilesnav_ref.visibility import VisibilitySettings

FEW = ("--quiet", "--rays", "300", "--keep-interiors", "--min-cell", "0.5", "--max-cell", "2")


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A room with a box in it: more cells than are treated in one block."""
    path = tmp_path_factory.mktemp("room") / "room.ply"
    scene = SCENES["box_in_room"]().scene
    metres = scene.vertices * np.float64(scene.step)
    path.write_bytes(trimesh.Trimesh(metres, scene.faces, process=False).export(file_type="ply"))
    return path


def _digests(folder: Path) -> dict[str, str]:
    files = [p for p in sorted(folder.rglob("*")) if p.is_file() and p.name != "encode-report.json"]
    return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def test_same_bytes_whatever_the_threads(room: Path, tmp_path: Path) -> None:
    for threads in ("1", "2", "3"):
        assert main(["encode", str(room), str(tmp_path / threads), *FEW, "--threads", threads]) == 0
    one, two, three = (_digests(tmp_path / threads) for threads in ("1", "2", "3"))
    assert one == two == three
    assert {"tileset.json", "nav/0.nav", "contents/0.glb"} <= set(one)
    # Two blocks or more, so that threads had something to share.
    assert open_tileset(tmp_path / "1").cell_count > VisibilitySettings().block_cells


def test_same_bytes_in_another_process_and_place(room: Path, tmp_path: Path) -> None:
    assert main(["encode", str(room), str(tmp_path / "here"), *FEW]) == 0
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "other.ply").write_bytes(room.read_bytes())
    arguments = ["encode", str(elsewhere / "other.ply"), str(elsewhere / "there"), *FEW]
    command = [sys.executable, "-m", "tilesnav_ref.cli", *arguments]
    subprocess.run(command, check=True, env={**os.environ, "PYTHONHASHSEED": "7"}, timeout=300)
    assert _digests(tmp_path / "here") == _digests(elsewhere / "there")


def test_provenance_states_every_setting_and_the_source(room: Path, tmp_path: Path) -> None:
    assert main(["encode", str(room), str(tmp_path / "out"), *FEW, "--seed", "4"]) == 0
    provenance = open_tileset(tmp_path / "out").provenance
    parameters = provenance["parameters"]
    assert set(parameters) == {"scene", "cells", "visibility", "lod", "tileset"}
    assert (parameters["visibility"]["seed"], parameters["visibility"]["rays"]) == (4, 300)
    assert parameters["cells"]["min_size"] == 0.5
    assert not [stage for stage, of_stage in parameters.items() if "threads" in of_stage]
    assert provenance["sourceSha256"] == hashlib.sha256(room.read_bytes()).hexdigest()
    assert provenance["scene"]["file_faces"] == len(trimesh.load(room, process=False).faces)
    assert "source" not in provenance["scene"]
    assert 0 < provenance["coverage"] <= 1


def test_force_replaces_and_an_interrupted_one_does_not(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    assert main(["encode", str(room), str(out), *FEW]) == 0
    before = _digests(out)
    with monkeypatch.context() as patch:
        patch.setattr("tilesnav_ref.encode.make_deltas", _interrupted)
        assert main(["encode", str(room), str(out), *FEW, "--force", "--clearance", "0.5"]) == 130
    assert _digests(out) == before
    assert main(["encode", str(room), str(out), *FEW, "--force", "--clearance", "0.5"]) == 0
    assert open_tileset(out).clearance == 0.5
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_finished_work_is_kept_until_the_tileset_is_there(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    work = tmp_path / "work"
    assert main(["encode", str(room), str(tmp_path / "plain"), *FEW]) == 0
    arguments = ["encode", str(room), str(tmp_path / "out"), *FEW, "--work", str(work)]
    with monkeypatch.context() as patch:
        patch.setattr("tilesnav_ref.encode.make_deltas", _interrupted)
        assert main(arguments) == 130
    assert "the same command goes on with the finished work" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert list(work.glob("*/block-*.npz"))
    assert main(arguments) == 0
    assert _digests(tmp_path / "out") == _digests(tmp_path / "plain")
    assert list(work.iterdir()) == []


def _interrupted(*_: object) -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_leaves_nothing(room: Path, tmp_path: Path, number: signal.Signals) -> None:
    # Minutes of work, so that the run is still at it when the signal comes; a stop is heeded within a cell.
    many = ("--quiet", "--rays", "1000000", "--keep-interiors", "--min-cell", "0.5", "--max-cell", "1")
    command = [sys.executable, "-m", "tilesnav_ref.cli", "encode", str(room), str(tmp_path / "out"), *many]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            deadline = time.monotonic() + 120
            while not any(tmp_path.iterdir()):
                assert process.poll() is None, "the run ended before it could be stopped"
                assert time.monotonic() < deadline
                time.sleep(0.02)
            assert not (tmp_path / "out").exists()
            process.send_signal(number)
            _, message = process.communicate(timeout=300)
        finally:
            process.kill()
    assert process.returncode == 128 + number
    assert message == f"tilesnav: error: stopped by {number.name}; nothing was left behind\n"
    assert list(tmp_path.iterdir()) == []
