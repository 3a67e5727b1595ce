"""Invalid tilesets: what the schemas refuse, references and frames."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from casebuilder.assemble import Files, Json, json_bytes
from casebuilder.edits import Edits, adding, dropping, edits, setting
from casebuilder.valid import external_files
from casebuilder.world import World
from casebuilder.worlds import RING

FACTS = ("extensions", "3DTILES_nav")
CHILD_0 = ("root", "children", 0, "content")
CHILD_1 = ("root", "children", 1, "content")
SECTOR_URI = ("sectors", 0, "uri")

SCHEMA: dict[str, Edits] = {
    "core/extension-used/not-listed": edits(tileset=setting("extensionsUsed", value=["VENDOR_other"])),
    "core/extension-optional/required": edits(tileset=setting("extensionsRequired", value=["3DTILES_nav"])),
    "core/asset-version/version-1-0": edits(tileset=setting("asset", "version", value="1.0")),
    "core/entry-object/no-entry-object": edits(tileset=dropping("extensions", "3DTILES_nav")),
    "core/version/version-0-2": edits(entry=setting("version", value="0.2.0")),
    "core/grid-exponent/step-of-two-metres": edits(entry=setting("grid", "exponent", value=1)),
    "core/sectors-listed/no-sectors": edits(entry=setting("sectors", value=[])),
    "core/content-object/no-digest": edits(tileset=dropping(*CHILD_0, *FACTS, "sha256")),
    "lod/parameters/base-of-one": edits(entry=setting("lod", "base", value=1)),
    "provenance/stated/no-coverage": edits(entry=dropping("provenance", "coverage")),
}


def _outside_link(tileset: Json) -> None:
    volume = copy.deepcopy(tileset["root"]["boundingVolume"])
    tile = {"boundingVolume": volume, "geometricError": 0.0, "content": {"uri": "../other.json"}}
    tileset["root"]["children"].append(tile)


def _circle(files: Files) -> None:
    for mine, other in (("a", "b"), ("b", "a")):
        box = {"box": [0, 0, 0, 9, 0, 0, 0, 9, 0, 0, 0, 9]}
        root = {
            "boundingVolume": box,
            "geometricError": 1.0,
            "refine": "ADD",
            "content": {"uri": f"../{other}/tileset.json"},
        }
        files[f"{mine}/tileset.json"] = json_bytes(
            {"asset": {"version": "1.1"}, "geometricError": 1.0, "root": root}
        )


def _external_twice(files: Files) -> None:
    tileset = json.loads(files["tileset.json"])
    children = tileset["root"]["children"]
    inner = {"asset": {"version": "1.1"}, "geometricError": 8.0, "root": {**children[1], "refine": "ADD"}}
    files["building.json"] = json_bytes(inner)
    link = {**children[1], "content": {"uri": "building.json"}}
    tileset["root"]["children"] = [children[0], link, link]
    files["tileset.json"] = json_bytes(tileset)


URIS: dict[str, Edits] = {
    "core/uri-inside/sector-parent-folder": edits(entry=setting(*SECTOR_URI, value="../0.nav")),
    "core/uri-inside/sector-absolute-path": edits(entry=setting(*SECTOR_URI, value="/etc/hostname")),
    "core/uri-inside/sector-percent-encoded": edits(entry=setting(*SECTOR_URI, value="%2e%2e/0.nav")),
    "core/uri-inside/sector-backslash": edits(entry=setting(*SECTOR_URI, value="..\\0.nav")),
    "core/uri-inside/sector-back-and-out": edits(entry=setting(*SECTOR_URI, value="nav/../../0.nav")),
    "core/uri-inside/content-file-uri": edits(tileset=setting(*CHILD_0, "uri", value="file:///etc/hostname")),
    "core/uri-inside/content-http": edits(tileset=setting(*CHILD_0, "uri", value="http://example.com/0.glb")),
    "core/uri-inside/content-data-uri": edits(
        tileset=setting(*CHILD_0, "uri", value="data:model/gltf-binary;base64,AAAA")
    ),
    "core/uri-inside/content-other-host": edits(
        tileset=setting(*CHILD_0, "uri", value="//example.com/0.glb")
    ),
    "core/uri-inside/external-parent-folder": edits(tileset=_outside_link),
    "core/sector-resolves/sector-missing": edits(files=dropping("nav/0.nav")),
    "core/content-resolves/content-missing": edits(files=dropping("content/1.glb")),
    "core/content-resolves/external-tileset-missing": edits(
        tileset=setting(*CHILD_1, value={"uri": "more/tileset.json"})
    ),
    "core/content-ids-dense/external-twice": edits(files=_external_twice),
    "core/external-tilesets-end/refers-to-itself": edits(
        tileset=setting(*CHILD_1, value={"uri": "tileset.json"})
    ),
    "core/external-tilesets-end/two-in-a-circle": edits(
        tileset=setting(*CHILD_1, value={"uri": "a/tileset.json"}), files=_circle
    ),
    "core/external-tilesets-end/nested-33-deep": edits(files=external_files(33)),
}


def _transform(change: Callable[[int, float], float]) -> World:
    return replace(RING, transform=tuple(change(i, v) for i, v in enumerate(RING.transform)))


def _row_major(tileset: Json) -> None:
    values: list[Any] = tileset["root"]["transform"]
    tileset["root"]["transform"] = [values[4 * (i % 4) + i // 4] for i in range(16)]


RAISED = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 1]

FRAMES: dict[str, Edits] = {
    "core/transform-rigid/scaled": edits(world=_transform(lambda i, v: v * 1.001 if i in (1, 4, 10) else v)),
    "core/transform-rigid/mirrored": edits(world=_transform(lambda i, v: -v if i == 10 else v)),
    "core/transform-rigid/last-row": edits(world=_transform(lambda i, v: 0.001 if i == 3 else v)),
    "core/transform-rigid/rounded-too-far": edits(
        world=_transform(lambda i, v: v * (1 + 1e-8) if i in (1, 4) else v)
    ),
    "core/content-transform/shifted": edits(tileset=adding("root", "transform", 12, amount=0.001)),
    "core/content-transform/second-transform": edits(
        tileset=setting("root", "children", 1, "transform", value=RAISED)
    ),
    "core/content-transform/row-major": edits(tileset=_row_major),
}

CASES = SCHEMA | URIS | FRAMES
