"""Resolving uris inside the folder of the entry tileset, and opening what they name."""

from __future__ import annotations

import mmap
import os
import stat
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote, urlsplit

MAX_URI = 4096
"""Longest uri in characters; longer ones are no file names on any common system."""


class UriOutsideError(ValueError):
    """A uri is not a relative reference inside the folder."""


class FileError(ValueError):
    """A file cannot be read."""


@dataclass(frozen=True)
class Folder:
    """The folder of the entry tileset.

    Attributes
    ----------
    real : Path
        Its path without symbolic links.
    """

    real: Path

    def resolve(self, base: tuple[str, ...], uri: str) -> tuple[str, ...]:
        """Return the place that ``uri`` names, as names from the folder downwards.

        Parameters
        ----------
        base : tuple of str
            Folder of the file that holds the uri, from the folder of the entry tileset downwards.
        uri : str
            As it stands in the file; query and fragment are left out of account.

        Raises
        ------
        UriOutsideError
            For schemes, hosts, absolute paths, back slashes, control characters, paths that climb out of the
            folder (percent-encoded or not) and symbolic links that lead out of it.
        """
        parts = list(base)
        for name in _relative_path(uri).split("/"):
            if name == "..":
                if not parts:
                    raise UriOutsideError("climbs out of the folder of the entry tileset")
                parts.pop()
            elif name not in ("", "."):
                parts.append(name)
        if not Path(os.path.realpath(self.path(tuple(parts)))).is_relative_to(self.real):
            raise UriOutsideError("leaves the folder of the entry tileset through a symbolic link")
        return tuple(parts)

    def path(self, place: tuple[str, ...]) -> Path:
        """Path of a resolved place."""
        return self.real.joinpath(*place)


def _relative_path(uri: str) -> str:
    """Decoded path of a relative reference."""
    if len(uri) > MAX_URI:
        raise UriOutsideError(f"is longer than {MAX_URI} characters")
    try:
        split = urlsplit(uri)
        path = unquote(split.path, errors="strict")
    except ValueError as error:
        raise UriOutsideError(f"is not a uri: {error}") from None
    if any(ord(letter) < 32 or letter == "\\" for letter in uri + path):
        raise UriOutsideError("has a control character or a back slash")
    if split.scheme or split.netloc or path.startswith("/"):
        raise UriOutsideError("is not relative")
    return path


def open_file(path: Path) -> memoryview:
    """Map a regular file into memory, read-only.

    Raises
    ------
    FileError
        If it does not exist, is no regular file (folder, pipe, device) or may not be read.
    """
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise FileError("is not a regular file")
        if status.st_size == 0:
            return memoryview(b"")
        with path.open("rb") as stream:
            return memoryview(mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ))
    except (OSError, ValueError) as error:
        if isinstance(error, FileError):
            raise
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise FileError(reason.lower()) from None
