"""A folder appears complete or not at all."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tilesnav_ref.tileset.errors import OutputError
from tilesnav_ref.tileset.folder import new_folder

ENTRY = json.dumps({"extensionsUsed": ["3DTILES_nav"]})


def _older(out: Path) -> None:
    out.mkdir()
    (out / "tileset.json").write_text(ENTRY)
    (out / "old.txt").write_text("old")


def _names(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.iterdir())


def test_appears_at_the_end(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with new_folder(out, force=False) as folder:
        (folder / "a").write_text("1")
        assert not out.exists()
    assert (out / "a").read_text() == "1"
    assert _names(tmp_path) == ["out"]


def test_has_the_usual_permissions(tmp_path: Path) -> None:
    (tmp_path / "usual").mkdir()
    with new_folder(tmp_path / "out", force=False):
        pass
    assert (tmp_path / "out").stat().st_mode == (tmp_path / "usual").stat().st_mode


@pytest.mark.parametrize("stop", [ValueError, KeyboardInterrupt])
def test_nothing_is_left_of_an_interrupted_one(tmp_path: Path, stop: type[BaseException]) -> None:
    def interrupted() -> None:
        with new_folder(tmp_path / "out", force=False) as folder:
            (folder / "half").write_text("1")
            raise stop

    with pytest.raises(stop):
        interrupted()
    assert _names(tmp_path) == []


def test_force_replaces_when_complete(tmp_path: Path) -> None:
    out = tmp_path / "out"
    _older(out)
    with new_folder(out, force=True) as folder:
        (folder / "new.txt").write_text("new")
        assert (out / "old.txt").read_text() == "old"
    assert _names(out) == ["new.txt"]
    assert _names(tmp_path) == ["out"]


def test_the_old_one_survives_an_interruption(tmp_path: Path) -> None:
    out = tmp_path / "out"
    _older(out)

    def interrupted() -> None:
        with new_folder(out, force=True) as folder:
            (folder / "half").write_text("1")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert _names(out) == ["old.txt", "tileset.json"]
    assert _names(tmp_path) == ["out"]


def test_the_old_one_comes_back_when_the_rename_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    _older(out)
    rename = Path.rename

    def failing(self: Path, target: Path) -> Path:
        if self.name == "new":
            raise OSError("no")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", failing)

    def complete() -> None:
        with new_folder(out, force=True):
            pass

    with pytest.raises(OSError, match="no"):
        complete()
    assert _names(out) == ["old.txt", "tileset.json"]
    assert _names(tmp_path) == ["out"]


def _file(tmp_path: Path) -> Path:
    (tmp_path / "out").write_text("x")
    return tmp_path / "out"


def _foreign(tmp_path: Path) -> Path:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.txt").write_text("x")
    return tmp_path / "out"


def _link(tmp_path: Path) -> Path:
    _older(tmp_path / "real")
    (tmp_path / "out").symlink_to(tmp_path / "real")
    return tmp_path / "out"


def _other_tileset(tmp_path: Path) -> Path:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "tileset.json").write_text("{}")
    return tmp_path / "out"


def _no_parent(tmp_path: Path) -> Path:
    return tmp_path / "no" / "out"


def _in_a_file(tmp_path: Path) -> Path:
    return _file(tmp_path) / "out"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (_file, "is not a folder"),
        (_foreign, "holds other things"),
        (_link, "is not a folder"),
        (_other_tileset, "holds other things"),
        (_no_parent, "is not a folder"),
        (_in_a_file, "is not a folder"),
    ],
)
def test_places_that_even_force_does_not_take(tmp_path: Path, make, message: str) -> None:
    out = make(tmp_path)
    before = sorted(tmp_path.rglob("*"))

    def attempt() -> None:
        with new_folder(out, force=True):
            pass

    with pytest.raises(OutputError, match=message):
        attempt()
    assert sorted(tmp_path.rglob("*")) == before


def test_an_existing_one_needs_force(tmp_path: Path) -> None:
    _older(tmp_path / "out")

    def attempt() -> None:
        with new_folder(tmp_path / "out", force=False):
            pass

    with pytest.raises(OutputError, match=r"exists already; --force"):
        attempt()


def test_what_appears_in_the_meantime_is_not_replaced(tmp_path: Path) -> None:
    out = tmp_path / "out"

    def attempt() -> None:
        with new_folder(out, force=False):
            _foreign(tmp_path)

    with pytest.raises(OutputError, match="exists already"):
        attempt()
    assert _names(out) == ["thesis.txt"]
    assert _names(tmp_path) == ["out"]


def test_an_empty_folder_may_be_replaced(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    with new_folder(tmp_path / "out", force=True) as folder:
        (folder / "a").write_text("1")
    assert _names(tmp_path / "out") == ["a"]
