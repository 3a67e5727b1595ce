"""Coarse contents with face maps: copies of contents of level 0 that are moved a little."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casebuilder.container import container_bytes, glb_bytes, glb_parts, padded
from casebuilder.world import Object, Point, Shape, World

Json = dict[str, Any]
Files = dict[str, bytes]


@dataclass
class Coarse:
    """A content of a coarse level: that of level 0, moved upwards, with every face in its place."""

    content: int
    level: int
    content_id: int
    rise: int
    """Grid steps."""
    objects: list[int]
    errors: list[float]
    """Metres."""
    lists: list[list[int]]
    """Faces of level 0 of each face."""
    changes: dict[str, Any] = field(default_factory=dict)
    """Functions that change tables before they are laid out."""
    glb: Callable[[bytes], bytes] | None = None
    """Changes the bytes of the content before its digest is taken."""
    part: Callable[[Json], object] | None = None
    """Changes the JSON part of the face map."""
    data: Callable[[bytes], bytes] | None = None
    """Changes the bytes of the face map before its digest is taken."""
    tile: Callable[[Json], object] | None = None
    """Changes the tile."""

    @property
    def uri(self) -> str:
        """File name of the content, without its ending."""
        return f"content/{self.content}-{self.level}"


Maker = Callable[[World], list[Coarse]]
"""Makes the coarse contents of a case, those of finer levels first."""


def moved(world: World, rise: int, levels: int = 1) -> list[Coarse]:
    """Every content in coarse levels, each higher than the one before it by a number of grid steps."""
    made = []
    for level in range(1, levels + 1):
        for content in sorted({item.content for item in world.objects}):
            objects = [i for i, item in enumerate(world.objects) if item.content == content]
            faces = [face for face, owner in enumerate(world.face_object) if owner in objects]
            errors = [level * rise * float(world.step)] * len(objects)
            lists = [[face] for face in faces]
            made.append(Coarse(content, level, content, level * rise, objects, errors, lists))
    return made


def _raised(item: Object, rise: int) -> Object:
    def up(point: Point) -> Point:
        return (point[0], point[1], point[2] + rise)

    shapes = tuple(
        Shape(tuple((up(a), up(b), up(c)) for a, b, c in shape.triangles), tuple(map(up, shape.outline)))
        for shape in item.shapes
    )
    return replace(item, shapes=shapes)


def _tables(coarse: Coarse) -> dict[str, NDArray[Any]]:
    tables: dict[str, NDArray[Any]] = {
        "objects": np.array(coarse.objects, dtype="<u4"),
        "errors": np.array(coarse.errors, dtype="<f8"),
        "offsets": np.cumsum([0, *map(len, coarse.lists)]).astype("<u4"),
        "faces": np.array([face for faces in coarse.lists for face in faces], dtype="<u4"),
    }
    for name, change in coarse.changes.items():
        tables[name] = change(tables[name])
    return tables


def map_parts(coarse: Coarse) -> tuple[Json, bytes]:
    """JSON part and unpadded binary part of a face map."""
    tables = _tables(coarse)
    views: list[Json] = []
    group: Json = {
        "objectCount": len(coarse.objects),
        "faceCount": len(coarse.lists),
        "count": len(tables["faces"]),
    }
    binary = b""
    for name, table in tables.items():
        binary = padded(binary, b"\0", 8)
        group[name] = len(views)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": table.nbytes})
        binary += table.tobytes()
    return {"buffers": [{"byteLength": len(binary)}], "bufferViews": views, "faceMap": group}, binary


def _files(world: World, coarse: Coarse) -> Files:
    objects = tuple(_raised(item, coarse.rise) for item in world.objects)
    glb = glb_bytes(*glb_parts(replace(world, objects=objects), coarse.content))
    part, binary = map_parts(coarse)
    if coarse.part:
        coarse.part(part)
    data = container_bytes(b"fmap", part, binary)
    return {
        f"{coarse.uri}.glb": coarse.glb(glb) if coarse.glb else glb,
        f"{coarse.uri}.fmap": coarse.data(data) if coarse.data else data,
    }


def _taller(volume: Json, rise: float) -> None:
    volume["box"][2] += rise / 2
    volume["box"][11] += rise / 2


def add_coarse(world: World, made: list[Coarse], tileset: Json) -> Files:
    """Put the tiles of coarse contents above those of finer ones; return their files."""
    files: Files = {}
    root = tileset["root"]
    highest = max((coarse.rise for coarse in made), default=0) * float(world.step)
    if made:
        _taller(root["boundingVolume"], highest)
    for coarse in made:
        mine = _files(world, coarse)
        glb, data = mine.values()
        finer = root["children"][coarse.content]
        facts: Json = {
            "contentId": coarse.content_id,
            "level": coarse.level,
            "faceCount": len(coarse.lists),
            "objectCount": len(coarse.objects),
            "sha256": hashlib.sha256(glb).hexdigest(),
            "faceMap": {"uri": f"{coarse.uri}.fmap", "sha256": hashlib.sha256(data).hexdigest()},
        }
        tile: Json = {
            "boundingVolume": {"box": list(finer["boundingVolume"]["box"])},
            "geometricError": max(coarse.errors),
            "refine": "REPLACE",
            "content": {"uri": f"{coarse.uri}.glb", "extensions": {"3DTILES_nav": facts}},
            "children": [finer],
        }
        _taller(tile["boundingVolume"], highest)
        if coarse.tile:
            coarse.tile(tile)
        root["children"][coarse.content] = tile
        files |= mine
    return files
