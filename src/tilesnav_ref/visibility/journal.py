"""Finished parts of a run in a folder, so that a run that was stopped goes on where it was.

A part is a file of arrays that appears complete or not at all. Its name and the folder's name, which is a
digest of everything that the results depend on, say what it is; so parts of another scene, of other settings
or of another version of the program are never taken.
"""

from __future__ import annotations

import hashlib
import logging
import shutil
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

logger = logging.getLogger(__name__)

Arrays = Mapping[str, NDArray[np.generic]]


def digest_of(parts: Iterable[NDArray[np.generic] | str]) -> str:
    """Digest of arrays, with their types and shapes, and of texts, in their order."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else np.ascontiguousarray(part).tobytes()
        kind = "text" if isinstance(part, str) else f"{part.dtype.str} {part.shape}"
        digest.update(f"{kind} {len(data)}\n".encode() + data)
    return digest.hexdigest()[:32]


class Journal:
    """Parts of the run with a digest, below a folder; without a folder nothing is kept."""

    def __init__(self, folder: Path | None, digest: str = "") -> None:
        self._folder = None if folder is None else folder / f"visibility-{digest}"
        if self._folder is not None:
            self._folder.mkdir(parents=True, exist_ok=True)

    def load(self, name: str) -> Arrays | None:
        """Arrays of a part; None when it is not there or cannot be read."""
        if self._folder is None:
            return None
        try:
            with (
                (self._folder / f"{name}.npz").open("rb") as file,
                np.load(file, allow_pickle=False) as stored,
            ):
                return dict(stored)
        except FileNotFoundError:
            return None
        except (OSError, EOFError, ValueError, zipfile.BadZipFile) as error:
            logger.warning("%s is done anew: %s", self._folder / name, error)
            return None

    def save(self, name: str, arrays: Arrays) -> None:
        """Keep a part."""
        if self._folder is None:
            return
        with tempfile.NamedTemporaryFile(dir=self._folder, suffix=".part", delete=False) as file:
            part = Path(file.name)
            try:
                np.savez(file, **dict(arrays))  # type: ignore[arg-type]
            except BaseException:
                part.unlink()
                raise
        part.replace(self._folder / f"{name}.npz")

    def forget(self) -> None:
        """Remove what was kept; the results are safe elsewhere."""
        if self._folder is not None:
            shutil.rmtree(self._folder)
