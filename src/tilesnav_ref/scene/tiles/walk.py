"""The tree of a tileset: which contents are the finest, and where each is placed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.gltf.files import Files
from tilesnav_ref.scene.gltf.values import Value, parse
from tilesnav_ref.scene.parts import Part
from tilesnav_ref.scene.tiles.implicit import Address, expand, implicit_tiles, parents

TILES_LIMIT = 1 << 22
"""Explicit tiles, those of external tilesets counted as often as they are named."""
DEPTH_LIMIT = 100
"""Tiles above a tile, those of the tilesets around an external one counted."""
EXTERNAL_LIMIT = 32
"""External tilesets within one another."""
EXTENSIONS = frozenset(
    {
        "3DTILES_content_gltf",
        "3DTILES_multiple_contents",
        "3DTILES_metadata",
        "3DTILES_bounding_volume_S2",
        "3DTILES_bounding_volume_cylinder",
        "3DTILES_ellipsoid",
        "3DTILES_nav",
    }
)
"""Extensions of tilesets that may be required: they are read, or say nothing about where faces are."""


@dataclass(frozen=True)
class Placed:
    """A content file and what the tree says about it."""

    path: Path
    data: bytes
    matrix: NDArray[np.float64]
    """(4, 4) from the axes of the tile (z up) to those of the entry tileset."""
    up: str
    """Axis of its glTF that points up."""


@dataclass(frozen=True)
class _State:
    """What a tile has from those above it."""

    path: Path
    """Tileset that it is in."""
    matrix: NDArray[np.float64]
    refine: str | None
    up: str
    depth: int
    above: tuple[Path, ...]
    """Tilesets around this one, and this."""


class Walk:
    """Goes through a tileset and reads the contents of the finest level.

    Parameters
    ----------
    files : Files
    read : function
        Gives the parts of a content.
    up : str
        Axis of the glTF that points up; "auto" as each tileset says.
    """

    def __init__(self, files: Files, read: Callable[[Placed], list[Part]], up: str) -> None:
        self.left_out: Counter[str] = Counter()
        """Contents that a finer level replaces, by reason."""
        self._files, self._read, self._up = files, read, up
        self._tiles = 0

    def entry(self, path: Path) -> list[Part]:
        """Read an entry tileset and all that it names.

        Raises
        ------
        SceneError
            Naming the file and the place.
        """
        return self._tileset(path, self._files.read(path), _State(path, np.eye(4), None, "y", 0, ()))

    def _tileset(self, path: Path, data: bytes, state: _State) -> list[Part]:
        document = parse(str(path), "", data)
        if path in state.above:
            chain = " -> ".join(self._files.name(one) for one in (*state.above, path))
            raise document.error(f"a tileset within itself: {chain}", "external tilesets without a cycle")
        if len(state.above) > EXTERNAL_LIMIT:
            raise document.error(f"{len(state.above)} tilesets around this one", f"at most {EXTERNAL_LIMIT}")
        root = document.need("root")
        for extension in document.items("extensionsRequired"):
            if extension.text() not in EXTENSIONS:
                raise extension.error(repr(extension.raw), ", ".join(sorted(EXTENSIONS)))
        asset = document.need("asset")
        said = asset.member("gltfUpAxis") if self._up == "auto" else Value(str(path), "up", self._up)
        # the axis that old tilesets state; y is the definition of glTF
        up = "y" if said is None else said.one_of(("X", "Y", "Z")).lower()
        inner = replace(state, path=path, up=up, above=(*state.above, path))
        return self._tile(root, inner)

    def _tile(self, tile: Value, state: _State) -> list[Part]:
        self._tiles += 1
        if self._tiles > TILES_LIMIT:
            raise tile.error(f"{self._tiles} tiles", f"at most {TILES_LIMIT}")
        if state.depth > DEPTH_LIMIT:
            raise tile.error(f"{state.depth} tiles above this one", f"at most {DEPTH_LIMIT}")
        refine, transform = tile.member("refine"), tile.member("transform")
        state = replace(
            state,
            matrix=state.matrix if transform is None else state.matrix @ transform.matrix(),
            refine=state.refine if refine is None else refine.one_of(("ADD", "REPLACE")),
            depth=state.depth + 1,
        )
        uris = _uris(tile)
        if tile.has("implicitTiling"):
            return self._implicit(tile, uris, state)
        below: list[Part] = []
        for child in tile.items("children"):
            below += self._tile(child, state)
        return self._finest([(uri, uri.text()) for uri in uris], below, state)

    def _finest(self, uris: list[tuple[Value, str]], below: list[Part], state: _State) -> list[Part]:
        """Contents of a tile, external tilesets included, and what is below it; or only what is below."""
        tilesets: list[Path] = []
        meshes: list[Path] = []
        for place, text in uris:
            path = self._files.at(place, text, state.path)
            (tilesets if _is_tileset(path) else meshes).append(path)
        for path in tilesets:
            below = self._tileset(path, self._files.read(path), state) + below
        if below and state.refine == "REPLACE":
            self.left_out["replaced by finer ones"] += len(meshes)
            return below
        own: list[Part] = []
        for path in meshes:
            own += self._read(Placed(path, self._files.read(path), state.matrix, state.up))
        return own + below

    def _implicit(self, tile: Value, uris: list[Value], state: _State) -> list[Part]:
        """Contents of an implicit tree; from the finest level up, since the finest replace those above."""
        tree = implicit_tiles(self._files, tile, state.path, len(uris)).contents
        found: dict[Address, list[Part]] = {}
        replaced: set[Address] = set()
        for address in sorted(tree, key=lambda one: (-one[0], one)):
            if state.refine == "REPLACE" and address in replaced:
                self.left_out["replaced by finer ones"] += len(tree[address])
                continue
            named = [(uris[k], expand(uris[k].text(), address)) for k in tree[address]]
            found[address] = self._finest(named, [], state)
            if found[address] and state.refine == "REPLACE":
                replaced.update(parents(address))
        return [part for address in sorted(found) for part in found[address]]


def _uris(tile: Value) -> list[Value]:
    """URIs of the contents of a tile; `url` is of tilesets before 1.0."""
    one, contents = tile.member("content"), tile.items("contents")
    extension = tile.member("extensions")
    multiple = None if extension is None else extension.member("3DTILES_multiple_contents")
    if multiple is not None:
        contents += multiple.items("contents") + multiple.items("content")
    contents = contents if one is None else [one, *contents]
    return [content.member("uri") or content.need("url") for content in contents]


def _is_tileset(path: Path) -> bool:
    """Whether a content file is an external tileset: JSON that is not named as glTF or as GeoJSON."""
    if path.suffix.lower() in (".gltf", ".geojson"):
        return False
    try:
        with path.open("rb") as file:
            return file.read(64).removeprefix(b"\xef\xbb\xbf").lstrip().startswith(b"{")
    except OSError as error:
        raise SceneError(str(path), "file", error.strerror or str(error), "a readable file") from error
