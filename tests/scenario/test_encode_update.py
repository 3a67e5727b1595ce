"""Towns that change, brought up to date by command and put before the validator."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import trimesh
from test_encode_analytic import verdict

from tilesnav_ref.cli import main
from tilesnav_ref.stream.reader import NavTileset, open_tileset

SIZES = ("--min-cell", "2", "--max-cell", "8", "--altitude-min", "0", "--altitude-max", "6", "--rays", "500")
REST = ("--quiet", "--threads", "2")


def write_yards(path: Path, *boxes: tuple[float, ...]) -> Path:
    """Three yards along x, 16 m each, with walls between them that are higher than all cells, and boxes."""
    ground = [[0, 0, 0], [48, 0, 0], [48, 16, 0], [0, 16, 0]]
    pieces = [trimesh.Trimesh(ground, [[0, 1, 2], [0, 2, 3]], process=False)]
    for x in (16, 32):
        corners = [[x, -40, 0], [x, 56, 0], [x, 56, 90], [x, -40, 90]]
        pieces.append(trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False))
    for x, y, size in boxes:
        bounds = [[x, y, 0], [x + size, y + size, size]]
        pieces.append(trimesh.creation.box(bounds=bounds))
    path.write_bytes(trimesh.util.concatenate(pieces).export(file_type="ply"))
    return path


def run(scene: Path, out: Path, *options: str) -> int:
    return main(["encode", str(scene), str(out), *REST, *SIZES, *options])


@pytest.fixture(scope="module")
def earlier(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with old.ply and its tileset `old`."""
    folder = tmp_path_factory.mktemp("yards")
    assert run(write_yards(folder / "old.ply", (4, 4, 2), (40, 4, 2)), folder / "old") == 0
    return folder


@pytest.fixture(scope="module")
def changed(earlier: Path) -> Path:
    """A box more in the last yard: new.ply, encoded from the start as `full` and as an update as `new`."""
    scene = write_yards(earlier / "new.ply", (4, 4, 2), (40, 4, 2), (35, 10, 2))
    assert run(scene, earlier / "full") == 0
    assert run(scene, earlier / "new", "--update", str(earlier / "old")) == 0
    return earlier


def digests(folder: Path) -> dict[str, str]:
    files = [p for p in sorted(folder.rglob("*")) if p.is_file() and p.name != "encode-report.json"]
    return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def sets(tileset: NavTileset) -> list[list[int]]:
    return [tileset.state(cell).faces.tolist() for cell in range(tileset.cell_count)]


def test_an_update_is_what_a_run_from_the_start_gives(changed: Path) -> None:
    new, full = (open_tileset(changed / name) for name in ("new", "full"))
    found = new.provenance["update"]
    assert 0 < found["cellsKept"] < found["cellsMatched"] <= new.cell_count
    assert (found["facesAdded"], found["facesRemoved"]) == (12, 0)
    # In a scene as simple as this nothing stays undecided, so the sets are those of all visible faces.
    assert new.provenance["undecided"] == full.provenance["undecided"] == {}
    assert sets(new) == sets(full)
    kept = {name: value for name, value in digests(changed / "new").items() if name != "tileset.json"}
    assert kept == {
        name: value for name, value in digests(changed / "full").items() if name != "tileset.json"
    }


def test_cells_of_the_yard_that_changed_are_recomputed_and_no_others(changed: Path) -> None:
    new = open_tileset(changed / "new")
    planes = new.sectors[0].planes
    last_yard = planes[:, :, 3][planes[:, :, 0] == -1] >= 32
    assert new.provenance["update"]["cellsKept"] <= (~last_yard).sum()
    # Only cells above or beside the middle wall could see more, and there are none.
    first_yard = -planes[:, :, 3][planes[:, :, 0] == 1] <= 16
    assert new.provenance["update"]["cellsKept"] >= first_yard.sum() > 0


def test_the_validator_accepts_an_update(changed: Path) -> None:
    report = verdict(changed / "new")
    verdicts = {one["id"]: one["verdict"] for one in report["requirements"]}
    assert set(verdicts.values()) == {"pass", "not refuted"}, verdicts


def test_an_update_says_so(changed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    new, full = (open_tileset(changed / name) for name in ("new", "full"))
    digest = hashlib.sha256((changed / "old" / "tileset.json").read_bytes()).hexdigest()
    assert new.provenance["parameters"]["update"] == {"previous_sha256": digest}
    assert "update" not in full.provenance["parameters"]
    assert "update" not in full.provenance
    assert main(["info", str(changed / "new")]) == 0
    assert "cells kept from an earlier tileset" in capsys.readouterr().out
    assert main(["info", str(changed / "full")]) == 0
    assert "kept" not in capsys.readouterr().out


def test_the_same_update_gives_the_same_bytes_and_may_take_the_place(changed: Path, tmp_path: Path) -> None:
    place = tmp_path / "moved"
    shutil.copytree(changed / "old", place)
    options = ("--update", str(place / "tileset.json"), "--threads", "1")
    assert run(changed / "new.ply", place, *options) == 2
    assert digests(place) == digests(changed / "old")
    assert run(changed / "new.ply", place, *options, "--force", "--work", str(tmp_path / "work")) == 0
    assert digests(place) == digests(changed / "new")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["moved", "work"]
    assert list((tmp_path / "work").iterdir()) == []


def test_updates_follow_one_another(changed: Path, tmp_path: Path) -> None:
    assert run(changed / "old.ply", tmp_path / "back", "--update", str(changed / "new")) == 0
    assert sets(open_tileset(tmp_path / "back")) == sets(open_tileset(changed / "old"))


def test_without_a_change_everything_is_kept(earlier: Path, tmp_path: Path) -> None:
    assert run(earlier / "old.ply", tmp_path / "same", "--update", str(earlier / "old")) == 0
    same = open_tileset(tmp_path / "same")
    assert same.provenance["update"]["cellsKept"] == same.cell_count
    found, expected = (digests(folder) for folder in (tmp_path / "same", earlier / "old"))
    assert {name for name in expected if found[name] != expected[name]} == {"tileset.json"}


def test_what_another_encoder_calls_an_update_is_not_printed(
    earlier: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(earlier / "old", tmp_path / "old")
    edit(tmp_path / "old", lambda entry: entry["provenance"].update(update="yesterday"))
    assert main(["info", str(tmp_path / "old")]) == 0
    assert "kept" not in capsys.readouterr().out


def edit(place: Path, change: Callable[[dict[str, Any]], None]) -> None:
    path = place / "tileset.json"
    document = json.loads(path.read_text())
    change(document["extensions"]["3DTILES_nav"])
    path.write_text(json.dumps(document))


def _overwrite(path: Path, table: bytes, row: int, value: int) -> None:
    """Change one element of a table of UINT32."""
    data = bytearray(path.read_bytes())
    assert data.count(table) == 1
    at = data.find(table) + 4 * row
    data[at : at + 4] = value.to_bytes(4, "little")
    path.write_bytes(data)


def _other_encoder(place: Path) -> None:
    edit(place, lambda entry: entry["provenance"].update(encoder="maps 2.0"))


def _no_parameters(place: Path) -> None:
    edit(place, lambda entry: entry["provenance"].update(parameters=7))


def _other_range(place: Path) -> None:
    edit(place, lambda entry: entry.update(visibility={"maxRange": 30}))


def _other_face_in_a_set(place: Path) -> None:
    tileset = open_tileset(place)
    sector = tileset.sectors[0]
    faces = sector.faces.row(0)
    spare = next(f for f in range(tileset.face_count) if f > faces[-1])
    _overwrite(sector.path, sector.faces.values.astype("<u4").tobytes(), len(faces) - 1, spare)


def _too_many_proven(place: Path) -> None:
    tileset = open_tileset(place)
    sector = tileset.sectors[0]
    _overwrite(sector.path, sector.proven_visible.astype("<u4").tobytes(), 0, tileset.face_count)


def _other_content(place: Path) -> None:
    path = next((place / "contents").iterdir())
    data = bytearray(path.read_bytes())
    data[-3] ^= 1
    path.write_bytes(data)


def _no_content(place: Path) -> None:
    next((place / "contents").iterdir()).unlink()


def _nothing(place: Path) -> None:
    """Leave the tileset as it is."""


def _no_tileset(place: Path) -> None:
    shutil.rmtree(place)


BAD: dict[str, tuple[Callable[[Path], None], tuple[str, ...], str]] = {
    "no tileset": (_no_tileset, (), "readable file"),
    "another encoder": (_other_encoder, (), "provenance.encoder: found 'maps 2.0'; allowed: 'tilesnav"),
    "no parameters": (_no_parameters, (), "provenance.parameters.visibility: found nothing"),
    "another range": (_other_range, (), "visibility.maxRange: found 30.0; allowed: None"),
    "a range": (_nothing, ("--max-range", "20"), "visibility.max_range: found None; allowed: 20.0"),
    "another seed": (_nothing, ("--seed", "5"), "visibility.seed: found 1; allowed: 5"),
    "another grid": (_nothing, ("--grid", "-9"), "grid.exponent: found -10; allowed: -9"),
    "another frame": (_nothing, ("--crs", "enu", "--origin", "11,48,500"), "transform: found"),
    "certificates": (
        _nothing,
        ("--certificates",),
        "setting certificates: found certificates beside an update",
    ),
    "another face": (_other_face_in_a_set, (), "cell 0: found another state; allowed: the state that its"),
    "too many proven": (_too_many_proven, (), "faces proven visible; allowed: at most"),
    "another content": (_other_content, (), "SHA-256: found"),
    "no content": (_no_content, (), ".glb: file: found No such file"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_updated_is_refused(
    earlier: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    spoil, options, message = BAD[name]
    place = tmp_path / "old"
    shutil.copytree(earlier / "old", place)
    spoil(place)
    before = sorted(tmp_path.rglob("*"))
    capsys.readouterr()
    assert run(earlier / "old.ply", tmp_path / "out", "--update", str(place), *options) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert str(tmp_path / "old") in captured.err
    assert captured.err.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before


def test_a_cell_with_other_planes_is_another_cell(earlier: Path, tmp_path: Path) -> None:
    place = tmp_path / "old"
    shutil.copytree(earlier / "old", place)
    sector = open_tileset(place).sectors[0]
    right = sector.planes.copy()
    planes = right.astype("<f8").tobytes()
    data = bytearray(sector.path.read_bytes())
    at = data.find(planes)
    other = right.copy()
    other[0, 0, 3] += 2.0**-40
    data[at : at + len(planes)] = other.astype("<f8").tobytes()
    sector.path.write_bytes(data)
    assert run(earlier / "old.ply", tmp_path / "out", "--update", str(place)) == 0
    found = open_tileset(tmp_path / "out").provenance["update"]
    assert found["cellsMatched"] == len(right) - 1
