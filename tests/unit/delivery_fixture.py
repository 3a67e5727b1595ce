"""A map in levels whose face maps are made up, and what is delivered of it by the plain definition."""

from __future__ import annotations

import hashlib
import json
import struct
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from test_tileset_small_map import small_cells, small_map

from tilesnav_ref.cells import planes
from tilesnav_ref.levels import CoarseLevel
from tilesnav_ref.lod.model import LodTable
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.stream.reader import NavTileset, open_tileset
from tilesnav_ref.tileset.delta import make_deltas
from tilesnav_ref.tileset.model import NavMap, TilesetSettings
from tilesnav_ref.tileset.write import write_tileset
from tilesnav_ref.visibility.model import PvsTable

Parts = list[tuple[int, int, int, list[int], list[list[list[int]]]]]
"""Object, level, flags, faces and corners of each part that is held."""


@dataclass(frozen=True)
class Sizes:
    """How large a map is made."""

    objects: int = 4
    faces: int = 6
    """Faces an object has at most."""


def random_map(seed: int, sizes: Sizes | None = None, levels: tuple[int, ...] = (1, 2)) -> NavMap:
    """Faces, sets, codes and face maps at random; every object has a face, some are porous or one-sided."""
    rng = np.random.default_rng(seed)
    sizes = sizes or Sizes()
    scene = random_scene(rng, rng.integers(1, sizes.faces + 1, sizes.objects))
    cells = small_cells()
    sets = [np.flatnonzero(rng.random(scene.face_count) < share) for share in (0.0, 0.3, 0.8)]
    seen = [np.unique(scene.face_object[faces]) for faces in sets]
    pvs = PvsTable(
        pvs_offsets=np.cumsum([0, *map(len, sets)]),
        pvs_faces=np.concatenate(sets).astype(np.uint32),
        pvs_proven=np.zeros(sum(map(len, sets)), np.bool_),
    )
    lod = LodTable(
        settings=small_map().lod.settings,
        lod_offsets=np.cumsum([0, *map(len, seen)]),
        lod_objects=np.concatenate(seen).astype(np.uint32),
        lod_codes=rng.integers(0, 16, sum(map(len, seen))).astype(np.uint8),
    )
    one = NavMap(scene, cells, pvs, lod, make_deltas(cells, pvs, lod), small_map().provenance)
    return replace(one, coarse=tuple(random_level(rng, level, scene) for level in levels))


def random_scene(rng: np.random.Generator, counts: np.ndarray) -> Scene:
    """Faces between random grid points, those without area included; half of the objects in each content."""
    vertices = np.unique(rng.integers(-9, 9, (40, 3)), axis=0).astype(np.int64) * 512
    objects = len(counts)
    flags = rng.random((2, objects)) < 0.4
    return Scene(
        vertices=vertices,
        faces=rng.integers(0, len(vertices), (int(counts.sum()), 3)).astype(np.int32),
        face_object=np.repeat(np.arange(objects), counts).astype(np.int32),
        object_content=(np.arange(objects) * 2 // objects).astype(np.int32),
        object_names=tuple(f"object {k}" for k in range(objects)),
        object_porous=flags[0],
        object_one_sided=flags[1],
    )


def random_level(rng: np.random.Generator, level: int, fine: Scene) -> CoarseLevel:
    """As many faces or fewer for every object; each stands for some faces of it, and all are stood for."""
    fine_counts = np.bincount(fine.face_object)
    counts = rng.integers(1, fine_counts + 1)
    scene = replace(random_scene(rng, counts), vertices=fine.vertices)
    scene = replace(scene, faces=rng.integers(0, len(fine.vertices), (int(counts.sum()), 3)).astype(np.int32))
    lists: list[list[int]] = []
    for number, (count, fine_count) in enumerate(zip(counts, fine_counts, strict=True)):
        first = int(np.searchsorted(fine.face_object, number))
        of_object = [set(rng.integers(0, fine_count, 2).tolist()) for _ in range(count)]
        for face in range(fine_count):
            of_object[int(rng.integers(count))].add(face)
        lists.extend(sorted(first + face for face in faces) for faces in of_object)
    return CoarseLevel(
        level,
        scene,
        rng.uniform(0.0, 2.0**level, len(counts)),
        np.cumsum([0, *map(len, lists)]),
        np.concatenate(lists).astype(np.uint32),
    )


def plain_held(one: NavMap, cell: int, chosen: dict[int, int]) -> Parts:
    """What is delivered, straight from the definition.

    Parameters
    ----------
    one : NavMap
        The map as it was before it was written.
    cell : int
    chosen : dict of int
        Place of the level that is taken of each object: 0 for level 0, i + 1 for ``one.coarse[i]``.
    """
    pvs = set(one.pvs.faces_of(cell).tolist())
    parts: Parts = []
    for number in range(one.scene.object_count):
        if not pvs & set(np.flatnonzero(one.scene.face_object == number).tolist()):
            continue
        place = chosen[number]
        scene = one.coarse[place - 1].scene if place else one.scene
        faces = np.flatnonzero(scene.face_object == number)
        held = []
        for index, face in enumerate(faces.tolist()):
            stands_for = {face}
            if place:
                level = one.coarse[place - 1]
                stands_for = set(level.fine_faces[level.offsets[face] : level.offsets[face + 1]].tolist())
            if stands_for & pvs:
                held.append((index, turned(scene.vertices[scene.faces[face]].tolist())))
        flags = int(one.scene.object_porous[number]) + 2 * int(one.scene.object_one_sided[number])
        level_number = one.coarse[place - 1].level if place else 0
        parts.append((number, level_number, flags, [i for i, _ in held], [c for _, c in held]))
    return parts


def turned(corners: list[list[int]]) -> list[list[int]]:
    """The least of the three rotations."""
    return min(corners[k:] + corners[:k] for k in range(3))


def written(folder: Path, one: NavMap) -> NavTileset:
    """Write a map and open it."""
    folder.mkdir(exist_ok=True)
    write_tileset(folder, one, planes(one.cells, one.scene.step), TilesetSettings())
    return open_tileset(folder)


def edit_json(path: Path, edit: Any) -> None:
    """Change a JSON file."""
    document = json.loads(path.read_text())
    edit(document)
    path.write_text(json.dumps(document))


def edit_map(folder: Path, name: str, edit: Any, keep_digest: bool = True) -> None:
    """Change JSON part and tables of a face map, and its digest in tileset.json unless told otherwise.

    Parameters
    ----------
    edit : callable
        Takes the JSON part and a dict of the bytes of its tables by name, and changes either.
    """
    path = folder / "contents" / name
    members, tables = map_parts(path.read_bytes())
    edit(members, tables)
    path.write_bytes(map_bytes(members, tables))
    if keep_digest:
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        edit_json(folder / "tileset.json", lambda d: set_digest(d["root"], name, digest))


def map_parts(data: bytes) -> tuple[dict[str, Any], dict[str, bytes]]:
    """JSON part of a face map, and the bytes of its tables."""
    length = struct.unpack_from("<Q", data, 8)[0]
    members = json.loads(data[24 : 24 + length])
    tables = {}
    for name in ("objects", "errors", "offsets", "faces"):
        view = members["bufferViews"][members["faceMap"][name]]
        start = 24 + length + view["byteOffset"]
        tables[name] = data[start : start + view["byteLength"]]
    return members, tables


def map_bytes(members: dict[str, Any], tables: dict[str, bytes]) -> bytes:
    """A face map of these tables; the JSON part keeps what else it says."""
    views, binary = [], b""
    for data in tables.values():
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        binary += data + b"\0" * (-len(data) % 8)
    used = views[-1]["byteOffset"] + views[-1]["byteLength"]
    text = json.dumps({**members, "buffers": [{"byteLength": used}], "bufferViews": views}).encode()
    text += b" " * (-len(text) % 8)
    return struct.pack("<4sIQQ", b"fmap", 1, len(text), len(binary)) + text + binary


def set_digest(tile: dict[str, Any], name: str, digest: str) -> None:
    """State another digest for a face map."""
    stated = tile.get("content", {}).get("extensions", {}).get("3DTILES_nav", {})
    if stated.get("faceMap", {}).get("uri", "").endswith(name):
        stated["faceMap"]["sha256"] = digest
    for child in tile.get("children", []):
        set_digest(child, name, digest)
