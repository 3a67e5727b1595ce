"""A folder that appears complete or not at all."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tilesnav_ref.tileset.errors import OutputError
from tilesnav_ref.tileset.model import EXTENSION


@contextmanager
def new_folder(out: Path, force: bool) -> Iterator[Path]:
    """Yield an empty folder beside `out` that takes its place when the block ends well.

    Parameters
    ----------
    out : Path
        The folder to make; its parent exists.
    force : bool
        Whether an older tileset at `out` is replaced. It stays until the new one is complete.

    Raises
    ------
    OutputError
        When `out` cannot be made or may not be replaced; nothing has been changed then.

    Notes
    -----
    When the block raises, the new folder is removed and `out` is as it was. Both renames stay within one
    folder, so no byte is copied; between them `out` is missing for an instant, and a failure of the second
    undoes the first.
    """
    check_output(out, force)
    try:
        workplace = Path(tempfile.mkdtemp(prefix=f".{out.name}.", dir=out.parent))
    except OSError as error:
        raise OutputError(f"{out}: cannot make a folder beside it: {error.strerror}") from error
    try:
        new = workplace / "new"
        # mkdtemp makes a folder that is private to its owner; what is published has the usual permissions.
        new.mkdir()
        yield new
        # The work took a while: something else may stand at the place by now.
        check_output(out, force)
        _swap(new, out, workplace / "old")
    finally:
        shutil.rmtree(workplace)


def check_output(out: Path, force: bool) -> None:
    """Check that a tileset may be written to `out`, before any time is spent.

    Raises
    ------
    OutputError
        When its parent is not a folder, or `out` exists and is not to be replaced or is no tileset.
    """
    if not out.name:
        raise OutputError(f"{out}: the output is a folder that does not exist yet")
    if not out.parent.is_dir():
        raise OutputError(f"{out}: its parent {out.parent} is not a folder")
    if not (out.exists() or out.is_symlink()):
        return
    if not force:
        raise OutputError(f"{out}: exists already; --force replaces it")
    if out.is_symlink() or not out.is_dir():
        raise OutputError(f"{out}: is not a folder, and --force replaces folders only")
    if any(out.iterdir()) and not _is_nav_tileset(out / "tileset.json"):
        raise OutputError(
            f"{out}: holds other things than a tileset with {EXTENSION}, and --force does not remove them"
        )


def _is_nav_tileset(entry: Path) -> bool:
    try:
        document = json.loads(entry.read_bytes())
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(document, dict) and EXTENSION in str(document.get("extensionsUsed"))


def _swap(new: Path, out: Path, old: Path) -> None:
    replaces = out.exists()
    if replaces:
        out.rename(old)
    try:
        new.rename(out)
    except BaseException:
        if replaces:
            old.rename(out)
        raise
