"""References between the files of a tileset: relative, and inside of its folder."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote, urlsplit

from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.fields import Fields


def resolve_uri(owner: Fields, base: Path, root: Path) -> Path:
    """Turn the member `uri` into the path of a file.

    Parameters
    ----------
    owner : Fields
        The object with the member.
    base : Path
        Folder of the file that holds the reference.
    root : Path
        Folder of the entry tileset, resolved.

    Raises
    ------
    TilesetError
        When the reference is absolute, has a scheme, or leads out of the folder, by a symbolic link too.
    """
    uri = owner.text("uri")
    allowed = "a relative reference that stays inside the folder of the entry tileset"
    try:
        parts = urlsplit(uri)
        path = unquote(parts.path, errors="strict")
    except ValueError as error:
        raise owner.error("uri", uri, allowed) from error
    if parts.scheme or parts.netloc or not path or path.startswith("/") or "\\" in path or "\0" in path:
        raise owner.error("uri", uri, allowed)
    resolved = (base / path).resolve()
    if not resolved.is_relative_to(root):
        raise owner.error("uri", uri, allowed)
    return resolved


def read_bytes(path: Path, limit: int) -> bytes:
    """Read a file of at most that many bytes.

    Raises
    ------
    TilesetError
        When it cannot be read or is longer.
    """
    try:
        size = path.stat().st_size
        if size > limit:
            raise TilesetError(str(path), "file", f"{size} bytes", f"at most {limit}")
        return path.read_bytes()
    except OSError as error:
        raise TilesetError(str(path), "file", error.strerror or "an error", "a readable file") from error
