"""The command `tilesnav planes`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from test_planar_detect import corner

from tilesnav_ref.cli import main
from tilesnav_ref.clouds import read_cloud


@pytest.fixture
def cloud(tmp_path: Path) -> Path:
    path = tmp_path / "corner.xyz"
    np.savetxt(path, corner(120)[0] + (1000.0, 2000.0, 30.0), fmt="%.4f")
    return path


def test_files_and_figures(cloud: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "planes"
    assert main(["planes", str(cloud), str(out), "--min-points", "40", "--json", "--quiet"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["features"] == 3
    assert figures["points"] == 366
    written = json.loads((out / "planes.json").read_text())
    assert written["origin"] == [900.0, 1900.0, 0.0] or written["origin"] == [1000.0, 2000.0, 0.0]
    assert sum(one["count"] for one in written["features"]) == figures["points_in_features"]
    points = read_cloud(out / "points.ply")
    assert np.allclose(points.points + points.origin, np.loadtxt(cloud), atol=1e-9)
    rows = np.frombuffer(
        (out / "points.ply").read_bytes().partition(b"end_header\n")[2],
        [("place", "<f8", 3), ("feature", "<i4"), ("colour", "u1", 3)],
    )
    for k, one in enumerate(written["features"]):
        own = rows["place"][rows["feature"] == k] - written["origin"]
        assert len(own) == one["count"]
        assert np.abs(own @ one["normal"] + one["offset"]).max() < 1.1 * written["inlierDistance"]
        assert np.allclose(own.mean(axis=0), one["centroid"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["corner.xyz", "planes"]


def test_the_table(cloud: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["planes", str(cloud), str(tmp_path / "a"), "--min-points", "40", "--units", "ft"]) == 0
    text = capsys.readouterr().out
    assert "points in features" in text
    assert json.loads((tmp_path / "a/planes.json").read_text())["metresPerUnit"] == 0.3048


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["missing.ply", "out"], "missing.ply"),
        (["corner.xyz", "there"], "exists already"),
        (["corner.xyz", "no/where"], "not a folder"),
        (["corner.xyz", "out", "--thin", "-1"], "thin"),
        (["corner.xyz", "out", "--normal-sigmas", "0"], "normal_sigmas"),
        (["corner.xyz", "out", "--classes", "300"], "300"),
        (["corner.xyz", "out", "--plot", "a.bmp"], ".bmp"),
    ],
)
def test_what_cannot_be_done(
    arguments: list[str],
    said: str,
    cloud: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(cloud.parent)
    (cloud.parent / "there").mkdir()
    before = sorted(cloud.parent.iterdir())
    assert main(["planes", *arguments, "--quiet"]) == 2
    assert said in capsys.readouterr().err
    assert sorted(cloud.parent.iterdir()) == before
