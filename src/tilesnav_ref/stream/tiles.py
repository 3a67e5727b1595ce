"""The tree of tiles as a viewer reads it: volumes, geometric errors, refinement, contents."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.contents import EXTENSION
from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.fields import JSON_LIMIT, Fields, parse_object
from tilesnav_ref.stream.uris import read_bytes, resolve_uri

DEPTH_LIMIT = 64
"""Tiles may be nested this deep."""


@dataclass(frozen=True)
class TileContent:
    """A nav content of a tile, or an object that is given a tile of its own."""

    path: Path | None
    """None for an object."""
    content_id: int
    """Or the number of the object."""
    level: int


@dataclass(frozen=True)
class TileTree:
    """Tiles in the order of a walk that visits parents first; metres, frame of the tileset."""

    parents: NDArray[np.int64]
    """(T,) -1 for the root."""
    errors: NDArray[np.float64]
    """(T,) geometric error, scaled as the transforms of the tiles say."""
    adds: NDArray[np.bool_]
    """(T,) refinement ADD; else REPLACE."""
    centres: NDArray[np.float64]
    """(T, 3) of the boxes."""
    axes: NDArray[np.float64]
    """(T, 3, 3) half-axes of the boxes, one a row, orthogonal."""
    contents: tuple[tuple[TileContent, ...], ...]
    """Of each tile."""

    @property
    def count(self) -> int:
        """Number of tiles."""
        return len(self.parents)

    def distances(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """(T,) distance of a point (3,) from the box of each tile, m; 0 inside."""
        lengths = np.linalg.norm(self.axes, axis=2)
        units = self.axes / np.maximum(lengths, 1e-300)[:, :, None]
        along = np.abs(np.einsum("tij,tj->ti", units, point - self.centres))
        return np.asarray(np.linalg.norm(np.maximum(along - lengths, 0.0), axis=1))


def read_tiles(path: Path) -> TileTree:
    """Read the tiles of an entry tileset; external tilesets and contents without nav object are left out.

    Raises
    ------
    TilesetError
        When the file cannot be read, a bounding volume is no box, or tiles are nested too deep.
    """
    tileset = parse_object(read_bytes(path, JSON_LIMIT), str(path))
    root_folder = path.parent.resolve()
    rows: list[_Row] = []
    open_tiles = [_Open(tileset.fields("root"), -1, np.eye(4), False, 1)]
    while open_tiles:
        one = open_tiles.pop()
        if one.depth > DEPTH_LIMIT:
            raise TilesetError(
                str(path), one.tile.place, f"more than {DEPTH_LIMIT} levels", "fewer tiles in tiles"
            )
        row = _row(one, root_folder)
        if one.tile.has("children"):
            children = one.tile.list_of_fields("children")
            open_tiles.extend(
                _Open(child, len(rows), row.transform, row.adds, one.depth + 1)
                for child in reversed(children)
            )
        rows.append(row)
    return TileTree(
        np.array([row.parent for row in rows]),
        np.array([row.error for row in rows]),
        np.array([row.adds for row in rows]),
        np.array([row.box[0] for row in rows]),
        np.array([row.box[1:] for row in rows]),
        tuple(row.contents for row in rows),
    )


@dataclass(frozen=True)
class _Open:
    tile: Fields
    parent: int
    transform: NDArray[np.float64]
    adds: bool
    """Refinement of the parent."""
    depth: int


@dataclass(frozen=True)
class _Row:
    parent: int
    error: float
    adds: bool
    box: NDArray[np.float64]
    """(4, 3) centre and half-axes."""
    transform: NDArray[np.float64]
    contents: tuple[TileContent, ...]


def _row(one: _Open, root: Path) -> _Row:
    tile, transform = one.tile, one.transform
    if tile.has("transform"):
        transform = transform @ np.reshape(tile.numbers("transform", 16), (4, 4)).T
    volume = tile.fields("boundingVolume")
    if not volume.has("box"):
        raise volume.error("box", "nothing", "a box; spheres and regions are not followed")
    box = np.reshape(volume.numbers("box", 12), (4, 3)) @ transform[:3, :3].T
    box[0] += transform[:3, 3]
    scale = float(np.linalg.norm(transform[:3, :3], axis=0).max())
    refine = tile.text("refine").upper() if tile.has("refine") else ""
    adds = refine == "ADD" if refine else one.adds
    return _Row(
        one.parent, tile.number("geometricError") * scale, adds, box, transform, _contents(tile, root)
    )


def _contents(tile: Fields, root: Path) -> tuple[TileContent, ...]:
    listed = tile.list_of_fields("contents") if tile.has("contents") else []
    listed += [tile.fields("content")] if tile.has("content") else []
    found = []
    for content in listed:
        if content.has("extensions") and content.fields("extensions").has(EXTENSION):
            extension = content.fields("extensions").fields(EXTENSION)
            path = resolve_uri(content, root, root)
            found.append(TileContent(path, extension.integer("contentId"), extension.integer("level")))
    return tuple(found)
