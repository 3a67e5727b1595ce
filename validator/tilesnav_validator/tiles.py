"""Walking the tiles of the entry tileset and of its external tilesets, without recursion."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator import strictjson
from tilesnav_validator.files import FileError, Folder, UriOutsideError, open_file
from tilesnav_validator.findings import Finding, UnreadableInputError

EXTENSION = "3DTILES_nav"
MAX_NESTED = 32
MAX_TILES = 2**21
"""Most tiles that are walked; a tileset that refers to itself in a fan would otherwise never end."""

_OBJECT = re.compile(rb"(\xef\xbb\xbf)?[ \t\r\n]*\{")

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Tile:
    """A tile and the way to it.

    Attributes
    ----------
    place : str
        File and JSON pointer.
    parent : Tile or None
        Also across the border of an external tileset.
    transform : ndarray of float64, shape (4, 4), or None
        To the frame of the parent; None when it is not 16 finite numbers.
    volume : object
        The bounding volume as it stands in the file.
    refine : object
        As it stands in the file, or else that of the parent.
    error : object
        The geometric error as it stands in the file.
    """

    place: str
    parent: Tile | None
    transform: FloatArray | None
    volume: Any
    refine: Any = None
    error: Any = None

    def chain(self) -> Iterator[Tile]:
        """The tile itself, its parent, and so on to the root."""
        tile: Tile | None = self
        while tile is not None:
            yield tile
            tile = tile.parent


@dataclass(frozen=True)
class Content:
    """A content with an object ``3DTILES_nav``.

    Attributes
    ----------
    place : str
        File and JSON pointer of the content.
    nav : object
        The extension object as it stands in the file.
    data : memoryview or None
        Bytes of the file, None when it could not be opened.
    folder : tuple of str
        Where the tileset file lies that the content stands in, from that of the entry tileset downwards.
    """

    place: str
    tile: Tile
    nav: Any
    data: memoryview | None
    folder: tuple[str, ...] = ()


@dataclass
class Walk:
    """Everything met on the walk; faults are kept under the requirement that they break."""

    contents: list[Content] = field(default_factory=list)
    faults: dict[str, list[Finding]] = field(default_factory=lambda: defaultdict(list))
    tiles: int = 0


@dataclass(frozen=True)
class _Source:
    """A tileset file that is being read, and those that referred to it."""

    name: str
    place: tuple[str, ...]
    outer: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class _Step:
    """A tile still to be walked."""

    json: Any
    pointer: str
    parent: Tile | None
    source: _Source


def read_tileset(data: memoryview) -> dict[str, Any]:
    """Parse a tileset file.

    Raises
    ------
    strictjson.JsonError
        If it is not a JSON object.
    """
    value = strictjson.parse_view(data, 0, len(data))
    if not isinstance(value, dict):
        raise strictjson.JsonError("is not a JSON object")
    return value


def as_transform(value: Any) -> FloatArray | None:
    """Return a column-major list of 16 finite numbers as a matrix, the identity for a missing one."""
    if value is None:
        return np.eye(4)
    if not isinstance(value, list) or len(value) != 16 or not all(_is_finite(item) for item in value):
        return None
    return np.array(value, dtype=np.float64).reshape(4, 4).T


def _is_finite(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return abs(value) < 2**1023 and math.isfinite(value)


def walk(folder: Folder, entry_place: tuple[str, ...], entry: dict[str, Any]) -> Walk:
    """Visit every tile reachable from the entry tileset.

    Raises
    ------
    UnreadableInputError
        If there are more than ``MAX_TILES`` tiles.
    """
    result = Walk()
    source = _Source("/".join(entry_place), entry_place, (entry_place,))
    pending = [_Step(entry.get("root"), "/root", None, source)]
    while pending:
        step = pending.pop()
        result.tiles += 1
        if result.tiles > MAX_TILES:
            raise UnreadableInputError(
                f"more than {MAX_TILES} tiles, counting external tilesets as often as referred to"
            )
        if isinstance(step.json, dict):
            pending.extend(reversed(list(_visit(folder, step, result))))
    return result


def _visit(folder: Folder, step: _Step, result: Walk) -> Iterator[_Step]:
    """Take note of a tile; yield its children and the roots of its external tilesets."""
    place = f"{step.source.name}#{step.pointer}"
    tile = Tile(
        place,
        step.parent,
        as_transform(step.json.get("transform")),
        step.json.get("boundingVolume"),
        step.json.get("refine", step.parent.refine if step.parent else None),
        step.json.get("geometricError"),
    )
    for pointer, content in _contents(step):
        yield from _visit_content(folder, _Step(content, pointer, tile, step.source), step.json, result)
    children = step.json.get("children")
    if isinstance(children, list):
        for index, child in enumerate(children):
            yield _Step(child, f"{step.pointer}/children/{index}", tile, step.source)


def _contents(step: _Step) -> Iterator[tuple[str, dict[str, Any]]]:
    """The contents of a tile with their JSON pointers."""
    single, several = step.json.get("content"), step.json.get("contents")
    if isinstance(single, dict):
        yield f"{step.pointer}/content", single
    if isinstance(several, list):
        for index, content in enumerate(several):
            if isinstance(content, dict):
                yield f"{step.pointer}/contents/{index}", content


def _visit_content(folder: Folder, step: _Step, tile_json: dict[str, Any], result: Walk) -> Iterator[_Step]:
    """Resolve a content, keep it if it is a nav content, follow it if it is an external tileset."""
    assert step.parent is not None
    place = f"{step.source.name}#{step.pointer}"
    extensions = step.json.get("extensions")
    is_nav = isinstance(extensions, dict) and EXTENSION in extensions
    uri = step.json.get("uri")
    found: tuple[tuple[str, ...], memoryview] | None = None
    if "implicitTiling" in tile_json:  # the uri is a template and names no file
        if is_nav:
            result.faults["core/content-resolves"].append(
                Finding(place, "a template of implicit tiling", "a file")
            )
    else:
        found = _open(folder, step.source, uri, f"{place}/uri", result)
    if is_nav:
        data = found[1] if found else None
        folder_of = step.source.place[:-1]
        result.contents.append(Content(place, step.parent, extensions[EXTENSION], data, folder_of))
    elif found and _may_be_tileset(*found):
        yield from _external(found, f"{place}/uri", step, result)


def _open(
    folder: Folder, source: _Source, uri: Any, where: str, result: Walk
) -> tuple[tuple[str, ...], memoryview] | None:
    """Resolve and map a file; note the fault when that fails."""
    if not isinstance(uri, str):
        result.faults["core/content-resolves"].append(Finding(where, f"{type(uri).__name__}", "a string"))
        return None
    try:
        place = folder.resolve(source.place[:-1], uri)
    except UriOutsideError as error:
        allowed = "a relative reference inside the folder of the entry tileset"
        result.faults["core/uri-inside"].append(Finding(where, f"{uri[:200]!r} {error}", allowed))
        return None
    try:
        return place, open_file(folder.path(place))
    except FileError as error:
        result.faults["core/content-resolves"].append(
            Finding(where, f"{uri[:200]!r}: {error}", "a readable file")
        )
        return None


def _may_be_tileset(place: tuple[str, ...], data: memoryview) -> bool:
    """Whether a file looks like a JSON object (with a byte order mark, it is one that cannot be read), and is
    not called a glTF."""
    return not place[-1].lower().endswith(".gltf") and _OBJECT.match(data) is not None


def _external(
    found: tuple[tuple[str, ...], memoryview], where: str, step: _Step, result: Walk
) -> Iterator[_Step]:
    """Yield the root of an external tileset unless it leads in a circle or too deep."""
    place, data = found
    name = "/".join(place)
    source = _Source(name, place, (*step.source.outer, place))
    if place in step.source.outer:
        finding = Finding(where, f"{name} is being read already", "no reference back")
        result.faults["core/external-tilesets-end"].append(finding)
    elif len(step.source.outer) > MAX_NESTED:
        finding = Finding(where, f"more than {MAX_NESTED} deep", f"at most {MAX_NESTED}")
        result.faults["core/external-tilesets-end"].append(finding)
    else:
        try:
            tileset = read_tileset(data)
        except strictjson.JsonError as error:
            result.faults["core/content-resolves"].append(
                Finding(where, f"{name}: {error}", "a readable tileset")
            )
            return
        if "asset" in tileset and "root" in tileset:
            yield _Step(tileset["root"], "/root", step.parent, source)
