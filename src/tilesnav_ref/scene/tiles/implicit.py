"""Tiles of implicit tiling (3D Tiles 1.1, section 11): which have content, and under which names."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tilesnav_ref.scene.gltf.files import Files
from tilesnav_ref.scene.gltf.values import Value
from tilesnav_ref.scene.tiles.subtree import NODES_LIMIT, Shape, deinterleave, read_subtree

LEVELS_LIMIT = 40
"""Levels of a tree: tiles of the Earth's size are then of micrometres."""
SUBTREES_LIMIT = 1 << 20
TILES_LIMIT = 1 << 22
"""Tiles with content."""

Address = tuple[int, ...]
"""Level, x, y, and z in an octree."""


@dataclass(frozen=True)
class ImplicitTiles:
    """Tiles with content of one implicit tree."""

    contents: dict[Address, tuple[int, ...]]
    """By address, in the order of levels, then of coordinates: which contents of the template are there."""


def implicit_tiles(files: Files, tile: Value, base: Path, contents: int) -> ImplicitTiles:
    """List the tiles of a tile with implicitTiling that have content.

    Parameters
    ----------
    files : Files
    tile : Value
        The tile.
    base : Path
        Tileset that it is in.
    contents : int
        Contents that the tile has.

    Raises
    ------
    SceneError
        When a subtree is missing or wrong, or there are too many.
    """
    tiling = tile.need("implicitTiling")
    scheme = tiling.need("subdivisionScheme").one_of(("QUADTREE", "OCTREE"))
    levels = tiling.need("availableLevels").integer(1, LEVELS_LIMIT)
    depth = tiling.need("subtreeLevels")
    shape = Shape(2 if scheme == "QUADTREE" else 3, depth.integer(1, LEVELS_LIMIT))
    if shape.roots_below > NODES_LIMIT:
        raise depth.error(f"{depth.raw} levels, room for {shape.nodes} tiles", f"room for {NODES_LIMIT}")
    uri = tiling.need("subtrees").need("uri")
    found: dict[Address, tuple[int, ...]] = {}
    stack: list[Address] = [(0,) * (shape.dimensions + 1)]
    count = 0
    while stack:
        root = stack.pop()
        path = files.at(uri, expand(uri.text(), root), base)
        subtree = read_subtree(files, path, shape, contents)
        found.update(_with_content(subtree.content, root, shape, levels))
        stack += reversed(list(_children(subtree.below, root, shape, levels)))
        count += 1
        if count + len(stack) > SUBTREES_LIMIT or len(found) > TILES_LIMIT:
            many = f"{count + len(stack)} subtrees, {len(found)} tiles with content"
            raise tiling.error(many, f"at most {SUBTREES_LIMIT} and {TILES_LIMIT}")
    return ImplicitTiles(dict(sorted(found.items())))


def _with_content(
    content: np.ndarray, root: Address, shape: Shape, levels: int
) -> Iterator[tuple[Address, tuple[int, ...]]]:
    """Tiles of a subtree with content; levels beyond those of the tree are left out."""
    for level in range(min(shape.levels, levels - root[0])):
        start = shape.first(level)
        here = content[:, start : start + (1 << shape.dimensions * level)]
        index = np.flatnonzero(here.any(axis=0))
        places = deinterleave(index, shape.dimensions, level) + (np.array(root[1:]) << level)
        for k, place in zip(index, places.tolist(), strict=True):
            yield (root[0] + level, *place), tuple(np.flatnonzero(here[:, k]).tolist())


def _children(below: np.ndarray, root: Address, shape: Shape, levels: int) -> Iterator[Address]:
    level = root[0] + shape.levels
    if level < levels:
        places = deinterleave(np.flatnonzero(below), shape.dimensions, shape.levels)
        for place in (places + (np.array(root[1:]) << shape.levels)).tolist():
            yield (level, *place)


def expand(template: str, address: Address) -> str:
    """Put level and coordinates into a template URI."""
    for name, value in zip(("level", "x", "y", "z"), address, strict=False):
        template = template.replace("{" + name + "}", str(value))
    return template


def parents(address: Address) -> Iterator[Address]:
    """Give the addresses above one, the nearest first."""
    level, *place = address
    while level:
        level, place = level - 1, [c >> 1 for c in place]
        yield (level, *place)
