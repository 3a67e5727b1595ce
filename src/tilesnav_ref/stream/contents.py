"""The nav contents of a tileset: where they are, and how their faces share out to objects."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.fields import JSON_LIMIT, Fields, parse_object
from tilesnav_ref.stream.glb import open_glb
from tilesnav_ref.stream.uris import read_bytes, resolve_uri

EXTENSION = "3DTILES_nav"
DEPTH_LIMIT = 32
"""External tilesets may be nested this deep."""
CHUNK_BYTES = 4096
"""Bytes of a file in which the first character of a JSON text is looked for."""


@dataclass(frozen=True)
class FaceMapRef:
    """A face map as the tileset states it."""

    path: Path
    sha256: str
    """Digest of the file, in hexadecimal digits."""


@dataclass(frozen=True)
class ContentRef:
    """A content as the tileset states it."""

    path: Path
    content_id: int
    face_count: int
    object_count: int
    porous: tuple[int, ...] = ()
    """Ascending indices of its primitives that hide nothing."""
    one_sided: tuple[int, ...] = ()
    """Ascending indices of its primitives that are seen from their front only."""
    sha256: str = ""
    """Digest of the file as the tileset states it, in hexadecimal digits."""
    level: int = 0
    face_map: FaceMapRef | None = None
    """Of a content of level 1 or more; None where it has none."""


@dataclass(frozen=True)
class _Document:
    tileset: Fields
    folder: Path
    chain: tuple[Path, ...]
    """Files of the tilesets that led here, this one included."""


@dataclass(frozen=True)
class Contents:
    """The nav contents of a tileset."""

    fine: tuple[ContentRef, ...]
    """Those of level 0, by contentId."""
    coarse: dict[int, tuple[ContentRef, ...]]
    """Those with face maps of every level above, by contentId; levels ascend."""


def find_contents(entry: Fields, path: Path, root: Path) -> Contents:
    """Walk the tiles, external tilesets included, and list the nav contents by level and contentId.

    Raises
    ------
    TilesetError
        When a reference leads outside or back, nests too deep, or the ids of a level are not 0, 1, 2, ...
        each once.
    """
    found: dict[int, list[ContentRef]] = {0: []}
    documents = [_Document(entry, path.parent, (path,))]
    while documents:
        document = documents.pop()
        tiles = [document.tileset.fields("root")]
        while tiles:
            tile = tiles.pop()
            if tile.has("children"):
                tiles.extend(tile.list_of_fields("children"))
            for content in _contents_of(tile):
                target = resolve_uri(content, document.folder, root)
                if _is_nav_content(content):
                    ref = _content_ref(content, target, document.folder, root)
                    # A coarser content without a face map is for viewers: its form and its id are free.
                    if ref is not None:
                        found.setdefault(ref.level, []).append(ref)
                elif _may_be_tileset(target):
                    inner = _external(document, target)
                    documents.extend([inner] if inner.tileset.has("root") else [])
    levels = {level: _by_id(found[level], path, level) for level in sorted(found)}
    return Contents(levels.pop(0), levels)


def _by_id(contents: list[ContentRef], path: Path, level: int) -> tuple[ContentRef, ...]:
    ordered = sorted(contents, key=lambda content: content.content_id)
    ids = [content.content_id for content in ordered]
    if ids != list(range(len(ids))):
        place = f"contentId of level {level}" if level else "contentId"
        raise TilesetError(str(path), place, f"{ids[:8]}", "0, 1, 2, ... each once")
    return tuple(ordered)


def object_offsets(contents: tuple[ContentRef, ...]) -> NDArray[np.int64]:
    """First face of every primitive of contents and, last, the number of faces: a prefix sum.

    Of the contents of level 0 the primitives are the objects.

    Returns
    -------
    (K + 1,) int64

    Raises
    ------
    TilesetError
        When a glb cannot be read or its counts are not those that the tileset states.
    """
    counts: list[int] = []
    for content in contents:
        faces = open_glb(content.path).face_counts
        if len(faces) != content.object_count or sum(faces) != content.face_count:
            found = f"{sum(faces)} faces in {len(faces)} primitives"
            stated = f"{content.face_count} faces in {content.object_count} primitives, as the tileset states"
            raise TilesetError(str(content.path), "meshes", found, stated)
        counts.extend(faces)
    return np.concatenate(([0], np.cumsum(counts, dtype=np.int64)))


def _contents_of(tile: Fields) -> list[Fields]:
    contents = tile.list_of_fields("contents") if tile.has("contents") else []
    return [*contents, tile.fields("content")] if tile.has("content") else contents


def _may_be_tileset(target: Path) -> bool:
    """Whether a content without the object is to be read: a tileset may have any name, a glTF has its own."""
    if target.suffix in (".json", ".gltf"):
        return target.suffix == ".json"
    try:
        with target.open("rb") as file:
            return file.read(CHUNK_BYTES).lstrip(b" \t\r\n").startswith(b"{")
    except OSError:  # contents for viewers are none of this reader's business
        return False


def _external(document: _Document, target: Path) -> _Document:
    if target in document.chain:
        raise TilesetError(
            str(document.chain[-1]), "content.uri", f"{target.name} again", "tilesets without a cycle"
        )
    if len(document.chain) > DEPTH_LIMIT:
        raise TilesetError(
            str(target), "file", f"more than {DEPTH_LIMIT} nested tilesets", f"at most {DEPTH_LIMIT}"
        )
    tileset = parse_object(read_bytes(target, JSON_LIMIT), str(target))
    return _Document(tileset, target.parent, (*document.chain, target))


def _is_nav_content(content: Fields) -> bool:
    return content.has("extensions") and content.fields("extensions").has(EXTENSION)


def _content_ref(content: Fields, path: Path, folder: Path, root: Path) -> ContentRef | None:
    """Read the object of a nav content; None for a coarser content without a face map."""
    extension = content.fields("extensions").fields(EXTENSION)
    level = extension.integer("level")
    if level and not extension.has("faceMap"):
        return None
    objects = extension.integer("objectCount")
    return ContentRef(
        path,
        extension.integer("contentId"),
        extension.integer("faceCount"),
        objects,
        _indices(extension, "porous", objects),
        _indices(extension, "oneSided", objects),
        extension.text("sha256") if extension.has("sha256") else "",
        level,
        _face_map(extension.fields("faceMap"), folder, root) if level else None,
    )


def _face_map(stated: Fields, folder: Path, root: Path) -> FaceMapRef:
    return FaceMapRef(resolve_uri(stated, folder, root), stated.text("sha256"))


def _indices(extension: Fields, name: str, below: int) -> tuple[int, ...]:
    """Ascending indices of primitives; none when the member is absent."""
    return extension.ascending(name, below) if extension.has(name) else ()
