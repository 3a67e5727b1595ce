"""Valid cases about what the format leaves free: forms that a reader must take, and parts that it must pass
over."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np

from casebuilder.assemble import Case, Files, Json, json_bytes
from casebuilder.state import Tables
from casebuilder.worlds import RING


def _unused_polygon(sectors: list[Tables]) -> None:
    table = sectors[0]
    triangle = np.array([[9.0, 9.0, 9.0], [10.0, 9.0, 9.0], [9.0, 10.0, 9.0]])
    end = int(table["portals.polygonOffsets"][-1]) + len(triangle)
    table["portals.polygonOffsets"] = np.append(table["portals.polygonOffsets"], np.array([end], dtype="<u4"))
    table["portals.vertices"] = np.concatenate((table["portals.vertices"], triangle.astype("<f8")))


def _unused_views(part: Json, parts: list[bytes]) -> None:
    start = -(-len(parts[0]) // 8) * 8
    parts[0] = parts[0].ljust(start, b"\0") + b"foreign"
    part["buffers"][0]["byteLength"] = len(parts[0])
    part["bufferViews"].append({"buffer": 0, "byteOffset": start, "byteLength": 7})
    part["bufferViews"].append({"buffer": 0, "byteOffset": start + 8, "byteLength": 0})


def _foreign_contents(tileset: Json) -> None:
    small = {"sphere": [0, 0, 0, 0]}
    tileset["root"]["children"] += [
        {"boundingVolume": small, "geometricError": 0.0, "content": {"uri": f"content/{name}"}}
        for name in ("tree.gltf", "tree.b3dm", "shapes.json")
    ]


def _foreign_files(files: Files) -> None:
    files["content/tree.gltf"] = json_bytes({"asset": {"version": "2.0"}, "scenes": [{}]})
    files["content/shapes.json"] = json_bytes({"type": "FeatureCollection", "features": []})
    files["content/tree.b3dm"] = b"b3dm, cut off"


def _content_volume(tileset: Json) -> None:
    tileset["root"]["children"][0]["content"]["boundingVolume"] = {"sphere": [0, 0, 0, 0.5]}


def _other_scene(gltf: Json, _parts: list[bytes]) -> None:
    gltf["nodes"] = [{"children": [1]}, {"mesh": 0}, {"mesh": 0}]
    gltf["scenes"] = [{"nodes": [2, 1]}, {"nodes": [0]}]
    gltf["scene"] = 1


def _image_outside(gltf: Json, _parts: list[bytes]) -> None:
    gltf["images"] = [{"uri": "bricks.png"}]
    gltf["textures"] = [{"source": 0}]
    gltf["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    gltf["meshes"][0]["primitives"][0]["material"] = 0


def _combined(files: Files) -> None:
    tileset = json.loads(files["tileset.json"])
    inner = {
        "asset": {"version": "1.1"},
        "geometricError": 8.0,
        "extensionsUsed": ["3DTILES_nav"],
        "extensions": {"3DTILES_nav": {"version": "9.9.9"}},
        "root": {**tileset["root"]["children"][1], "refine": "ADD"},
    }
    tileset["root"]["children"][1] = {
        **tileset["root"]["children"][1],
        "content": {"uri": "building.tileset"},
    }
    files["building.tileset"] = json_bytes(inner)
    files["tileset.json"] = json_bytes(tileset)


def form_cases() -> Iterator[Case]:
    """All cases of this module."""
    yield Case(
        "unused-polygon",
        RING,
        "A polygon that no portal names, far from every cell.",
        "A validator that judges what nothing refers to.",
        tables=_unused_polygon,
    )
    yield Case(
        "unused-views",
        RING,
        "A buffer view that no table refers to, and an empty one where the padding ends.",
        "A reader that takes the number of views for the number of tables, or refuses empty ones.",
        near=("container/buffer-views", "container/padding"),
        nav_json=_unused_views,
    )
    yield Case(
        "foreign-contents",
        RING,
        "Contents without the object beside the others: a glTF and shapes in the form of JSON, others.",
        "A reader that takes all JSON for tilesets, or all contents for its own.",
        tileset=_foreign_contents,
        files=_foreign_files,
    )
    yield Case(
        "content-volume",
        RING,
        "A content has a `boundingVolume` of its own that is far too small.",
        "A validator that judges the volume of the content in place of that of the tile.",
        tileset=_content_volume,
    )
    yield Case(
        "other-scene",
        RING,
        "A glTF whose `scene` is its second one; a node of the other scene has the same mesh.",
        "A reader that counts nodes which nothing shows.",
        gltf=_other_scene,
    )
    yield Case(
        "image-outside",
        RING,
        "A material with an image in a file of its own, which is not there.",
        "A reader that asks for more of a content than its faces.",
        gltf=_image_outside,
    )
    yield Case(
        "external-entry-object",
        RING,
        "An external tileset with an ending of its own has an entry object, of an unknown version.",
        "A reader that takes the last entry object it meets, or knows tilesets by the ending .json.",
        files=_combined,
    )
