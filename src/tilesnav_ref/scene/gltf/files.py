"""Files that a tileset names: only those in its folder, and never more than a bound."""

from __future__ import annotations

import hashlib
from pathlib import Path
from urllib.parse import unquote, urlsplit

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.gltf.values import Value

FILE_BYTES_LIMIT = 2 << 30
"""Bytes of one file, and of what is decompressed from it; parsers hold a file several times over."""
TOTAL_BYTES_LIMIT = 64 << 30
"""Bytes that are read at all; files that are named again count again."""


class Files:
    """Reads files in the folder of the entry tileset, or below, and remembers what was read.

    Parameters
    ----------
    entry : Path
        The entry tileset.
    """

    def __init__(self, entry: Path) -> None:
        self.folder = entry.resolve().parent
        self.count = 0
        self._bytes = 0
        self._digest = hashlib.sha256()

    def named(self, uri: Value, base: Path) -> Path:
        """Find the file that a URI names.

        Parameters
        ----------
        uri : Value
            Relative to `base`.
        base : Path
            File that holds the URI.

        Raises
        ------
        SceneError
            When the URI is of the network, leaves the folder of the entry tileset, or names no file.
        """
        return self.at(uri, uri.text(), base)

    def at(self, place: Value, text: str, base: Path) -> Path:
        """Find the file of a URI that was made from a template; `place` is named in errors."""
        allowed = f"a file in the folder of the entry tileset, or below ({self.folder.name}/)"
        try:
            parts = urlsplit(text)
            if parts.scheme or parts.netloc:
                raise place.error(f"{text!r}", f"{allowed}; nothing is fetched from a network")
            target = (base.resolve().parent / unquote(parts.path)).resolve()
            inside = target.is_relative_to(self.folder)
            there = inside and target.is_file()
        except (ValueError, OSError) as error:
            if isinstance(error, SceneError):
                raise
            raise place.error(f"{text!r}", allowed) from error
        if not inside:
            raise place.error(f"{text!r}, which lies outside", allowed)
        if not there:
            raise place.error(f"{text!r}, which is not there", allowed)
        return target

    def read(self, path: Path) -> bytes:
        """Read a file that was found.

        Raises
        ------
        SceneError
            When it cannot be read, is too large, or too much has been read.
        """
        try:
            size = path.stat().st_size
            self._bytes += size
            if size > FILE_BYTES_LIMIT or self._bytes > TOTAL_BYTES_LIMIT:
                found = f"{size} bytes, {self._bytes} with all before"
                allowed = f"at most {FILE_BYTES_LIMIT} a file and {TOTAL_BYTES_LIMIT} in all"
                raise SceneError(str(path), "file", found, allowed)
            data = path.read_bytes()
        except OSError as error:
            raise SceneError(str(path), "file", error.strerror or str(error), "a readable file") from error
        self.count += 1
        self._digest.update(hashlib.sha256(data).digest())
        return data

    def name(self, path: Path) -> str:
        """Give the path from the folder of the entry tileset."""
        return path.relative_to(self.folder).as_posix()

    @property
    def digest(self) -> str:
        """SHA-256 over the SHA-256 of every file, in the order of reading."""
        return self._digest.hexdigest()
