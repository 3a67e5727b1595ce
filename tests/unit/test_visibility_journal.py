"""A run that was stopped goes on where it was, and takes nothing over that is not its own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tilesnav_ref.cells import CellSettings, decompose
from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.scene import Scene
from tilesnav_ref.scene.analytic import SCENES
from tilesnav_ref.visibility import VisibilitySettings, compute_pvs, engine, forget_work
from tilesnav_ref.visibility.journal import Journal, digest_of
from tilesnav_ref.visibility.model import PvsTable

LITTLE = VisibilitySettings(rays=200, attempts=8, block_cells=4, threads=1, certificates=True)


class _Stop(BaseException):
    """What a signal does."""


@pytest.fixture(scope="module")
def room() -> tuple[Scene, CellComplex]:
    scene = SCENES["box_in_room"]().scene
    return scene, decompose(scene, CellSettings(keep_interiors=True, min_size=0.5, max_size=4.0))


def _words(table: PvsTable) -> list[list[int]]:
    assert table.certificates is not None
    return [proofs.words.tolist() for proofs in table.certificates.proofs]


def _stopped(room: tuple[Scene, CellComplex], work: Path, after: float) -> list[str]:
    """Run until a share of the steps is done; returns the files that are left."""

    def progress(done: int, total: int) -> None:
        if done >= after * total:
            raise _Stop

    with pytest.raises(_Stop):
        compute_pvs(*room, LITTLE, progress, work)
    return sorted(path.name for path in work.glob("*/*"))


@pytest.mark.parametrize(("after", "expected"), [(0.2, set()), (0.7, {"survey", "block"})])
def test_a_stopped_run_goes_on_to_the_same_result(
    room: tuple[Scene, CellComplex], tmp_path: Path, after: float, expected: set[str]
) -> None:
    whole = compute_pvs(*room, LITTLE)
    left = _stopped(room, tmp_path, after)
    assert {name.split("-")[0] for name in left} == expected
    steps: list[tuple[int, int]] = []
    again = compute_pvs(*room, LITTLE, lambda *step: steps.append(step), tmp_path)
    for field in ("pvs_offsets", "pvs_faces", "pvs_proven"):
        assert np.array_equal(getattr(again, field), getattr(whole, field))
    assert again.undecided == whole.undecided
    assert _words(again) == _words(whole)
    assert steps[-1][0] == steps[-1][1]
    assert list(tmp_path.glob("*/block-*"))
    forget_work(*room, LITTLE, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_what_is_kept_is_not_done_again(
    room: tuple[Scene, CellComplex], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[int] = []
    work_on_block = engine._work_on_block

    def counted(*given: Any) -> Any:
        begun.append(given[1].cells[0])
        return work_on_block(*given)

    monkeypatch.setattr(engine, "_work_on_block", counted)
    left = _stopped(room, tmp_path, 0.7)
    kept = {int(name[6:-4]) for name in left if name.startswith("block-")}
    assert kept
    assert kept <= set(begun)
    begun.clear()
    compute_pvs(*room, LITTLE, None, tmp_path)
    assert begun
    assert not kept & set(begun)


def test_other_scenes_settings_and_cells_take_nothing_over(
    room: tuple[Scene, CellComplex], tmp_path: Path
) -> None:
    scene, cells = room
    assert _stopped(room, tmp_path, 0.7)
    before = sorted(tmp_path.iterdir())
    other = replace(LITTLE, seed=9)
    compute_pvs(scene, cells, other, None, tmp_path)
    higher = np.array([0, 0, 1024])
    moved = replace(scene, vertices=scene.vertices + higher)
    lower, upper = cells.lower + higher, cells.upper + higher
    up = replace(cells, lower=lower, upper=upper, corners=cells.corners + higher)
    compute_pvs(moved, up, LITTLE, None, tmp_path)
    assert len(list(tmp_path.iterdir())) == len(before) + 2
    forget_work(scene, cells, other, tmp_path)
    forget_work(moved, up, LITTLE, tmp_path)
    assert sorted(tmp_path.iterdir()) == before


def test_a_damaged_part_is_done_anew(
    room: tuple[Scene, CellComplex], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    _stopped(room, tmp_path, 0.7)
    for number, path in enumerate(sorted(tmp_path.glob("*/*.npz"))):
        path.write_bytes(b"" if number % 2 else path.read_bytes()[:-40])
    again = compute_pvs(*room, LITTLE, None, tmp_path)
    assert np.array_equal(again.pvs_faces, compute_pvs(*room, LITTLE).pvs_faces)
    assert "is done anew" in caplog.text


def test_nothing_is_half_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    journal = Journal(tmp_path, "x")
    journal.save("part", {"a": np.arange(3)})

    def full(*_: object, **__: object) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(OSError, match="No space"):
        journal.save("other", {"a": np.arange(3)})
    assert [path.name for path in tmp_path.glob("*/*")] == ["part.npz"]
    kept = journal.load("part")
    assert kept is not None
    assert kept["a"].tolist() == [0, 1, 2]
    assert journal.load("other") is None


def test_digests_tell_types_shapes_and_order_apart() -> None:
    row = np.arange(4)
    different = [
        [row],
        [row.astype(np.int32)],
        [row.reshape(2, 2)],
        [row[::-1]],
        [row, row],
        [row, ""],
        ["", row],
    ]
    assert len({digest_of(parts) for parts in different}) == len(different)
