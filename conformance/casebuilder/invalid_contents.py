"""Invalid contents, and facts of contents that do not hold."""

from __future__ import annotations

import base64
import hashlib
import math
import struct

from casebuilder.assemble import Json
from casebuilder.edits import Edits, edits, of_first, setting
from casebuilder.invalid_core import CHILD_0, CHILD_1, FACTS
from casebuilder.valid import STEP, coarse_file, coarse_tile, scaled_world
from casebuilder.worlds import RING

OTHER_DIGEST = hashlib.sha256(b"another file").hexdigest()


def _facts(tileset: Json) -> Json:
    facts: Json = tileset["root"]["children"][0]["content"]["extensions"]["3DTILES_nav"]
    return facts


def _upper(tileset: Json) -> None:
    _facts(tileset)["sha256"] = _facts(tileset)["sha256"].upper()


def _add_face(tileset: Json) -> None:
    _facts(tileset)["faceCount"] += 1
    tileset["extensions"]["3DTILES_nav"]["faceCount"] += 1


def _drop_object(tileset: Json) -> None:
    _facts(tileset)["objectCount"] -= 1
    tileset["extensions"]["3DTILES_nav"]["objectCount"] -= 1


def _shrink(tile: Json) -> None:
    tile["boundingVolume"]["box"][3] -= 2 * STEP


def _move(gltf: Json, parts: list[bytes], offset: int, value: float) -> None:
    parts[0] = parts[0][:offset] + struct.pack("<f", value) + parts[0][offset + 4 :]
    gltf["accessors"][0]["min"][0] = min(gltf["accessors"][0]["min"][0], value)


FACTS_WRONG: dict[str, Edits] = {
    "core/content-ids-dense/gap": edits(tileset=setting(*CHILD_1, *FACTS, "contentId", value=2)),
    "core/content-ids-dense/twice": edits(tileset=setting(*CHILD_1, *FACTS, "contentId", value=0)),
    "core/content-digest/other-file": edits(tileset=setting(*CHILD_0, *FACTS, "sha256", value=OTHER_DIGEST)),
    "core/content-digest/upper-case": edits(tileset=_upper),
    "core/face-count/content-faces": edits(tileset=_add_face),
    "core/face-count/content-objects": edits(tileset=_drop_object),
    "core/face-count/entry-faces": edits(entry=setting("faceCount", value=len(RING.faces) + 1)),
    "core/on-grid/off-the-grid": edits(gltf=lambda g, parts: _move(g, parts, 0, -8 + STEP / 4)),
    "core/on-grid/too-far": edits(world=scaled_world(-10, 1.0, 2**23 * STEP)),
    "core/tile-volume-bounds/tile": edits(tileset=lambda t: _shrink(t["root"]["children"][1])),
    "core/tile-volume-bounds/ancestor": edits(tileset=lambda t: _shrink(t["root"])),
}


def _coarse_faces(tileset: Json) -> None:
    coarse_tile(tileset)
    tileset["root"]["children"][1]["content"]["extensions"]["3DTILES_nav"]["faceCount"] += 1


def _coarse_volume(tileset: Json) -> None:
    coarse_tile(tileset)
    tileset["root"]["children"][1]["content"]["uri"] = "content/0.glb"
    facts = tileset["root"]["children"][0]["content"]["extensions"]["3DTILES_nav"]
    mine = tileset["root"]["children"][1]["content"]["extensions"]["3DTILES_nav"]
    mine.update({name: facts[name] for name in ("faceCount", "objectCount", "sha256")})


def _spare_vertex(gltf: Json, parts: list[bytes]) -> None:
    first = gltf["accessors"][0]
    view = gltf["bufferViews"][first["bufferView"]]
    start, size = view["byteOffset"], view["byteLength"]
    vertices = parts[0][start : start + size] + struct.pack("<3f", STEP / 4, 0.0, 0.0)
    view.update(byteOffset=len(parts[0]), byteLength=len(vertices))
    first["count"] += 1
    parts[0] += vertices
    gltf["buffers"][0]["byteLength"] = len(parts[0])


COARSE_AND_SPARE: dict[str, Edits] = {
    "core/face-count/coarse-faces": edits(tileset=_coarse_faces, files=coarse_file),
    "core/tile-volume-bounds/coarse": edits(tileset=_coarse_volume),
    "core/on-grid/vertex-without-index": edits(gltf=_spare_vertex),
}


def _break_index(gltf: Json, parts: list[bytes]) -> None:
    offset = gltf["bufferViews"][1]["byteOffset"]
    parts[0] = parts[0][:offset] + struct.pack("<H", 4) + parts[0][offset + 2 :]


def _second_node(gltf: Json, _parts: list[bytes]) -> None:
    gltf["nodes"].append({"mesh": 0})
    gltf["scenes"][0]["nodes"].append(1)


def _claim_short(gltf: Json, _parts: list[bytes]) -> None:
    gltf["accessors"][0].update(componentType=5122, normalized=True)


def _morph(gltf: Json, _parts: list[bytes]) -> None:
    gltf["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 0}]


def _no_indices(gltf: Json, _parts: list[bytes]) -> None:
    gltf["accessors"][1]["count"] = 0


def _data_buffer(gltf: Json, parts: list[bytes]) -> None:
    text = base64.b64encode(parts[0]).decode()
    gltf["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{text}"


def _hidden_mesh(gltf: Json, _parts: list[bytes]) -> None:
    gltf["meshes"].append({"primitives": gltf["meshes"][0]["primitives"][:1]})


GLTF: dict[str, Edits] = {
    "core/content-gltf/text-renamed": edits(glb=lambda _: b"This is no binary glTF file.\n"),
    "core/content-gltf/empty-file": edits(glb=lambda _: b""),
    "core/content-gltf/truncated": edits(glb=lambda data: data[: len(data) // 2]),
    "core/content-gltf/node-transform": edits(
        gltf=of_first(setting("nodes", 0, "translation", value=[0, 0, 0.5]))
    ),
    "core/content-gltf/strip": edits(gltf=of_first(setting("meshes", 0, "primitives", 0, "mode", value=5))),
    "core/content-gltf/quantized": edits(gltf=_claim_short),
    "core/content-gltf/index-out-of-range": edits(gltf=_break_index),
    "core/content-gltf/nan-position": edits(gltf=lambda g, parts: _move(g, parts, 0, math.nan)),
    "core/content-gltf/two-instances": edits(gltf=_second_node),
    "core/content-gltf/external-buffer": edits(gltf=of_first(setting("buffers", 0, "uri", value="0.bin"))),
    "core/content-gltf/data-buffer": edits(gltf=_data_buffer),
    "core/content-gltf/no-triangles": edits(gltf=_no_indices),
    "core/content-gltf/not-in-the-scene": edits(gltf=of_first(setting("scenes", 0, "nodes", value=[]))),
    "core/content-gltf/morph-targets": edits(gltf=_morph),
    "core/content-gltf/mesh-not-shown": edits(gltf=_hidden_mesh),
    "core/content-gltf/claims-10-gb": edits(gltf=of_first(setting("accessors", 0, "count", value=10**9))),
}

CASES = FACTS_WRONG | COARSE_AND_SPARE | GLTF
