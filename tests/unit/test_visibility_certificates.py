"""Proofs that are kept: complete, the same whatever the room for them, and without effect on the sets."""

from __future__ import annotations

import numpy as np
import pytest

from tilesnav_ref.cells.model import CellComplex, box_corners
from tilesnav_ref.scene.analytic import SCENES
from tilesnav_ref.tileset.certificates import certificate_file
from tilesnav_ref.tileset.errors import EncodeError
from tilesnav_ref.visibility import VisibilitySettings, compute_pvs
from tilesnav_ref.visibility.certificates import Certificates, Proofs, region_form
from tilesnav_ref.visibility.geometry import FineFrame
from tilesnav_ref.visibility.model import PvsTable

KEEP = VisibilitySettings(rays=500, certificates=True, threads=1)
NAMES = ["one_wall", "box_in_room", "l_corridor"]


def _table(name: str, settings: VisibilitySettings) -> PvsTable:
    """The table of the two halves of the cell of an analytic scene."""
    case = SCENES[name]()
    middle = (case.cell_lower[0] + case.cell_upper[0]) // 2
    lower, upper = np.stack([case.cell_lower] * 2), np.stack([case.cell_upper] * 2)
    lower[1, 0] = upper[0, 0] = middle
    none = np.zeros(0, np.int64)
    cells = CellComplex(
        lower, upper, np.zeros(2, np.uint8), np.zeros(3, np.int64),
        none, none, 0, 1.0,
    )  # fmt: skip
    return compute_pvs(case.scene, cells, settings)


@pytest.mark.parametrize("name", NAMES)
def test_every_face_that_is_not_listed_is_a_target_of_a_proof_in_use(name: str) -> None:
    table = _table(name, KEEP)
    assert table.certificates is not None
    tables = table.certificates.tables(0, 2)
    hidden = 0
    for cell in range(2):
        used = tables.uses[tables.cell_offsets[cell] : tables.cell_offsets[cell + 1]]
        assert (np.diff(used) > 0).all()
        proved = {int(f) for k in used for f in tables.targets[slice(*tables.target_offsets[k : k + 2])]}
        missing = set(range(SCENES[name]().scene.face_count)) - set(table.faces_of(cell).tolist())
        assert missing <= proved
        assert not proved & set(table.faces_of(cell)[_proven(table, cell)].tolist())
        hidden += len(missing)
    assert hidden > 0


def _proven(table: PvsTable, cell: int) -> np.ndarray:
    return table.pvs_proven[table.pvs_offsets[cell] : table.pvs_offsets[cell + 1]]


@pytest.mark.parametrize("name", NAMES)
def test_tables_hold_together(name: str) -> None:
    table = _table(name, KEEP)
    assert table.certificates is not None
    tables = table.certificates.tables(0, 2)
    count = len(tables.regions)
    assert len(tables.target_offsets) == len(tables.cut_offsets) == count + 1
    assert tables.target_offsets[-1] == len(tables.targets)
    assert tables.cut_offsets[-1] == len(tables.cuts)
    assert tables.occluder_offsets[-1] == len(tables.occluders)
    assert np.count_nonzero(tables.cuts == 0) == len(tables.leaves)
    assert sorted(set(tables.leaves.tolist())) == list(range(len(tables.occluder_offsets) - 1))
    for k in range(count):
        codes = tables.cuts[slice(*tables.cut_offsets[k : k + 2])]
        open_pairs = 1
        for code in codes:
            assert open_pairs > 0
            open_pairs += -1 if code == 0 else 1
        assert open_pairs == 0
        targets = tables.targets[slice(*tables.target_offsets[k : k + 2])]
        assert len(targets) == 1 or codes.tolist() == [0]
        assert (np.diff(targets) > 0).all()
    sets = [tables.occluders[slice(*tables.occluder_offsets[k : k + 2])] for k in set(tables.leaves.tolist())]
    assert all((np.diff(faces) > 0).all() for faces in sets)
    assert len({faces.tobytes() for faces in sets}) == len(sets)


def test_proofs_are_cut_where_one_occluder_does_not_do() -> None:
    patient = VisibilitySettings(rays=2000, attempts=8192, depth=24, certificates=True)
    table = _table("two_walls_apart", patient)
    assert table.certificates is not None
    assert (table.certificates.tables(0, 2).cuts > 0).any()


def test_proofs_are_refused_where_faces_are_left_out_for_their_distance() -> None:
    with pytest.raises(ValueError, match="certificates: found one-sided faces or a range"):
        _table("one_wall", VisibilitySettings(rays=1, certificates=True, max_range=5.0))


def test_keeping_proofs_changes_no_set() -> None:
    kept = _table("box_in_room", KEEP)
    plain = _table("box_in_room", VisibilitySettings(rays=500, threads=1))
    assert plain.certificates is None
    assert np.array_equal(kept.pvs_faces, plain.pvs_faces)
    assert np.array_equal(kept.pvs_proven, plain.pvs_proven)


def test_too_little_room_is_found_out_and_the_block_done_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = _table("box_in_room", KEEP)
    monkeypatch.setattr("tilesnav_ref.visibility.engine.FIRST_WORDS", 3)
    small = _table("box_in_room", KEEP)
    assert whole.certificates is not None
    assert small.certificates is not None
    words = [[p.words.tolist() for p in t.certificates.proofs] for t in (whole, small) if t.certificates]
    assert words[0] == words[1]
    assert sum(map(len, words[0])) > 3


def test_sectors_share_the_proofs_of_a_block() -> None:
    table = _table("box_in_room", KEEP)
    assert table.certificates is not None
    both = table.certificates.tables(0, 2)
    one, two = table.certificates.tables(0, 1), table.certificates.tables(1, 2)
    assert len(one.uses) + len(two.uses) == len(both.uses)
    assert len(one.regions) + len(two.regions) >= len(both.regions)


def test_a_file_larger_than_readers_accept_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    words = np.array([1, 7, 2, 1, 9], np.int32)
    region = box_corners(np.zeros((1, 3), np.int64), np.full((1, 3), 4))[0].astype(np.float64)
    certificates = Certificates(FineFrame(np.zeros(3, np.int64), 4), 1, [Proofs((0,), region, words)])
    assert b"".join(certificate_file(certificates, 0, 1))[:4] == b"cert"
    monkeypatch.setattr("tilesnav_ref.tileset.certificates.COUNT_LIMIT", 1)
    with pytest.raises(EncodeError, match="certificates: count is 1; allowed: less than 1"):
        certificate_file(certificates, 0, 1)


AXES = {1: (0, 1), 2: (1, 2), 3: (2, 0), 4: (0, 2), 5: (1, 0), 6: (2, 1)}


def _prism(shape: int, row: list[int]) -> np.ndarray:
    """Corners of a region by its written numbers."""
    u, v = AXES[shape]
    corners = box_corners(np.array([row[:3]]), np.array([row[3:6]]))[0]
    for i in range(8):
        if i >> u & 1:
            corners[i, v] = row[6 + (i >> v & 1)]
    return corners.astype(np.float64)


@pytest.mark.parametrize("shape", AXES)
def test_regions_are_written_in_their_one_form(shape: int) -> None:
    _, v = AXES[shape]
    row = [10, 20, 30, 50, 61, 72, 0, 0]
    for p, q in ((row[v] - 7, row[v + 3]), (row[v], row[v + 3] + 7), (90, 91), (-91, -90)):
        numbers = [*row[:6], p, q]
        assert region_form(_prism(shape, numbers)) == (numbers, shape)
    assert region_form(_prism(shape, [*row[:6], row[v], row[v + 3]])) == (row, 0)


def test_corners_of_nothing_that_can_be_written_are_refused() -> None:
    corners = _prism(1, [0, 0, 0, 8, 8, 8, -4, 9])
    corners[7, 1] = 10.0
    with pytest.raises(ValueError, match="no box and no prism over a trapezoid"):
        region_form(corners)


def test_regions_of_both_kinds_stand_in_the_tables() -> None:
    words = np.array([1, 7, 2, 1, 9, 1, 8, 2, 1, 9], np.int32)  # two proofs of one leaf
    box = _prism(1, [0, 0, 0, 8, 8, 8, 0, 8])
    slanted = _prism(6, [0, 0, 0, 8, 8, 8, -4, 9])
    frame = FineFrame(np.zeros(3, np.int64), 4)
    made = Certificates(frame, 2, [Proofs((0,), box, words[:5]), Proofs((0, 1), slanted, words)])
    tables = made.tables(0, 2)
    assert tables.shapes.tolist() == [0, 6, 6]
    assert tables.regions.tolist() == [[0, 0, 0, 8, 8, 8, 0, 0]] + [[0, 0, 0, 8, 8, 8, -4, 9]] * 2
    data = b"".join(certificate_file(made, 1, 2))
    numbers = np.array([0, 0, 0, 8, 8, 8, -4, 9] * 2, "<i4").tobytes()
    assert numbers + bytes([6, 6]) in data
