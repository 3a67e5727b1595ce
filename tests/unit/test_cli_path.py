"""`tilesnav path`: tables, files and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from delivery_fixture import random_map, written

from tilesnav_ref.cli import main
from tilesnav_ref.commands.arguments import UsageError, parse
from tilesnav_ref.packet.wire import read_sequence

WAY = ("--route", "1.5,2,2", "6.5,2,2", "2,2,2")


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("path") / "out"
    written(folder, random_map(1))
    return folder


def test_figures_add_up(out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report, packets = tmp_path / "path.json", tmp_path / "path.vep"
    options = ("--speed", "5", "--lod", "auto", "--json", str(report), "--packets", str(packets))
    assert main(["path", str(out), *WAY, *options]) == 0
    printed = capsys.readouterr().out
    found = json.loads(report.read_text())
    route, drive = found["route"], found["packets"]["auto"]
    assert [cell for cell, _, _ in route["passages"]] == [0, 1, 2, 1, 0] == drive["cells"]
    assert route["length"] == pytest.approx(9.5, abs=1e-3)
    assert route["duration"] == pytest.approx(1.9, abs=1e-3)
    assert sum(drive["bytes"]) == packets.stat().st_size == drive["summary"]["total_kB"] * 1e3
    assert len(read_sequence(packets.read_bytes())) == 5 == drive["summary"]["packets"]
    later = sum(drive["bytes"][1:])
    assert drive["summary"]["mean_kB_s"] == pytest.approx(later / route["duration"] / 1e3)
    assert drive["summary"]["bytes_per_metre"] == pytest.approx(later / route["length"])
    assert drive["times"] == pytest.approx([begin / 5.0 for _, begin, _ in route["passages"]])
    assert [rival["name"] for rival in found["rivals"]][:2] == ["tiles-drop", "tiles-keep"]
    assert found["packets_keeping_all"]["auto"]["summary"]["total_kB"] <= drive["summary"]["total_kB"]
    assert f"{drive['summary']['mean_kB_s']:.1f}" in printed
    assert "5 cells" in printed
    assert sorted(tmp_path.iterdir()) == [report, packets]


def test_all_levels_are_driven_unless_one_is_named(
    out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    report = tmp_path / "path.json"
    points = tmp_path / "way.csv"
    points.write_text("x,y,z\n1.5,2,2\n6.5,2,2\n")
    assert main(["path", str(out), "--route", str(points), "--json", str(report), "--quiet"]) == 0
    assert capsys.readouterr().out == ""
    found = json.loads(report.read_text())
    assert list(found["packets"]) == ["fine", "coarse", "auto"]
    assert found["settings"]["speed"] == 20.0
    assert [cell for cell, _, _ in found["route"]["passages"]] == [0, 1, 2]


@pytest.mark.parametrize(("name", "head"), [("plot.png", b"\x89PNG"), ("plot.svg", b"<?xml")])
def test_pictures_are_written(out: Path, tmp_path: Path, name: str, head: bytes) -> None:
    pytest.importorskip("matplotlib", reason="pictures are an extra")
    plot = tmp_path / name
    assert main(["path", str(out), *WAY, "--quiet", "--plot", str(plot)]) == 0
    assert plot.read_bytes().startswith(head)
    assert list(tmp_path.iterdir()) == [plot]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--route", "1.5,2,2"), "found 1 way points; allowed: two or more"),
        (("--route", "1.5,2,2 99,2,2"), "way point 2: found 99, 2, 2, which lies in no cell"),
        (("--route", "1.5,2,2 1.5,2,2"), "all in one place"),
        (("--route", "1.5,2 6,2"), "allowed: 3 numbers"),
        (("--route", "street"), "found 'street'; allowed: roof, ground"),
        (("--route", "missing.json"), "missing.json cannot be read"),
        (("--route", "roof"), "route roof: found"),
        ((*WAY, "--speed", "0"), "setting speed: found 0"),
        ((*WAY, "--retain", "-1"), "allowed: an integer from 0"),
        ((*WAY, "--lod", "medium"), "medium"),
        ((*WAY, "--screen-error", "0"), "allowed: positive values"),
        ((*WAY, "--sensor-range", "-3"), "setting sensor_range: found -3"),
        ((*WAY, "--packets", "p.vep"), "--packets: found 3 levels of detail; allowed: one --lod"),
        ((*WAY, "--plot", "p.gif"), "found the ending '.gif'"),
        ((*WAY, "--json", "missing/p.json"), "found no place for a file"),
        ((*WAY, "--lod", "fine", "--json", "p.x", "--packets", "p.x"), "found one file twice"),
    ],
)
def test_what_is_wrong_is_named_and_nothing_is_written(
    out: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    options: tuple[str, ...],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["path", str(out), "--quiet", *options]) == 2
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_tileset_that_cannot_be_read_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["path", str(tmp_path / "nothing"), *WAY]) == 2
    assert "nothing" in capsys.readouterr().err


def test_way_points_may_be_one_value_or_many_and_negative() -> None:
    expected = ((-1.0, 2.0, 3.0), (-4.0, 5.0, 6.0))
    assert parse(["path", "OUT", "--route", "-1,2,3", "-4,5,6", "--speed", "3"]).route == expected
    assert parse(["path", "OUT", "--route", "-1,2,3 -4,5,6"]).route == expected
    assert parse(["path", "OUT", "--route", "-1,2,3;-4,5,6"]).route == expected
    assert parse(["path", "OUT"]).route == "roof"
    with pytest.raises(UsageError):
        parse(["path", "OUT", "--route"])
