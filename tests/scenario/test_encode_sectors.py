"""A scene encoded in sectors: one nav file each, portals across, and every sector also by itself."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from mission_scenes import box_faces, rectangle
from test_encode_analytic import verdict

from tilesnav_ref.cells import CellComplex
from tilesnav_ref.cli import main
from tilesnav_ref.stream.reader import NavTileset, open_tileset
from tilesnav_ref.stream.state import apply_delta
from tilesnav_ref.tileset.write import file_ranges

OPTIONS = ("--quiet", "--min-cell", "2", "--max-cell", "8", "--altitude-max", "10", "--rays", "500")
SECTORS = ("--sector-size", "16")


@pytest.fixture(scope="module")
def yard(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two houses on ground that lies in two times three sectors."""
    faces = np.concatenate(
        (
            rectangle((0, 32), (-8, 24), (0, 0)),
            box_faces((6, 2, 0), (20, 8, 5)),
            box_faces((24, 10, 0), (28, 20, 4)),
        )
    )
    path = tmp_path_factory.mktemp("yard") / "yard.ply"
    mesh = trimesh.Trimesh(faces.reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3), process=False)
    mesh.export(path)
    return path


@pytest.fixture(scope="module")
def whole(yard: Path, tmp_path_factory: pytest.TempPathFactory) -> NavTileset:
    out = tmp_path_factory.mktemp("whole") / "out"
    assert main(["encode", str(yard), str(out), *OPTIONS, *SECTORS]) == 0
    return open_tileset(out)


def test_nav_files_are_the_sectors(whole: NavTileset) -> None:
    assert len(whole.sectors) == 6  # y goes from -8 to 24: three rows of two
    for sector in whole.sectors:
        low, high = sector.planes[:, ::2, 3].min(axis=0), (-sector.planes[:, 1::2, 3]).max(axis=0)
        place = np.floor(low[:2] / 16.0)
        assert np.all(high[:2] <= 16.0 * (place + 1))
    entry = json.loads((whole.path).read_text())["extensions"]["3DTILES_nav"]
    assert [one["firstCell"] for one in entry["sectors"]] == [one.first_cell for one in whole.sectors]
    assert entry["provenance"]["parameters"]["cells"]["sector_size"] == 16.0


def test_the_validator_finds_nothing_in_sectors(whole: NavTileset) -> None:
    report = verdict(whole.path.parent)
    assert report["verdict"] == "valid"


def test_deltas_lead_across_borders(whole: NavTileset) -> None:
    sector_of = np.repeat(np.arange(len(whole.sectors)), [one.cell_count for one in whole.sectors])
    crossed = 0
    for cell in range(whole.cell_count):
        for target in whole.neighbours(cell).tolist():
            if sector_of[cell] == sector_of[target]:
                continue
            crossed += 1
            state = apply_delta(whole.state(cell), whole.delta(cell, target), whole.object_offsets)
            assert state.digest() == whole.digest(target)
            assert np.array_equal(whole.portal_polygon(cell, target), whole.portal_polygon(target, cell))
    assert crossed > 20


def test_a_sector_alone_has_the_cells_and_faces_that_it_has_among_all(
    yard: Path, whole: NavTileset, tmp_path: Path
) -> None:
    assert main(["encode", str(yard), str(tmp_path / "one"), *OPTIONS, *SECTORS, "--sector", "1,0"]) == 0
    alone = open_tileset(tmp_path / "one")
    assert len(alone.sectors) == 1
    same = [one for one in whole.sectors if np.array_equal(one.planes, alone.sectors[0].planes)]
    assert len(same) == 1
    assert alone.face_count == whole.face_count  # so numbers of faces and objects are the same too
    assert (tmp_path / "one/contents/0.glb").read_bytes() == (
        whole.path.parent / "contents/0.glb"
    ).read_bytes()
    assert np.array_equal(same[0].kinds, alone.sectors[0].kinds)
    assert verdict(tmp_path / "one")["verdict"] == "valid"


def test_info_reads_sectors(whole: NavTileset, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(whole.path.parent), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["cells"] == whole.cell_count


@pytest.mark.parametrize(
    ("offsets", "most", "expected"),
    [
        ([0, 3, 10], 100, [(0, 3), (3, 10)]),
        ([0, 3, 10], 4, [(0, 3), (3, 7), (7, 10)]),
        ([], 4, [(0, 4), (4, 8), (8, 10)]),
    ],
)
def test_sectors_with_many_cells_are_several_files(
    offsets: list[int], most: int, expected: list[tuple[int, int]]
) -> None:
    ends = np.arange(10)[:, None] + np.zeros((1, 3), np.int64)
    nothing = np.zeros(0, np.int64)
    kinds, offsets_of = np.zeros(10, np.uint8), np.zeros(11, np.int64)
    given = np.array(offsets, np.int64)
    cells = CellComplex(ends, ends + 1, kinds, offsets_of, nothing, nothing, 0, 1.0, sector_offsets=given)
    assert file_ranges(cells, most) == expected
