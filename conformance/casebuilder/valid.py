"""Valid cases: the base scenes, and for every numeric limit a case that only just keeps it."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator
from dataclasses import replace

from casebuilder.assemble import Case, Files, Json, json_bytes
from casebuilder.edits import of_first
from casebuilder.prism_proofs import prism_cases
from casebuilder.state import State, object_codes
from casebuilder.valid_forms import form_cases
from casebuilder.valid_proofs import proof_cases
from casebuilder.world import World, box_cell, quad
from casebuilder.worlds import (
    COARSE_LOD,
    FINE_LOD,
    GROUND,
    RING,
    SINGLE,
    SLANTED,
    TOUCHING,
    TWO_SECTORS,
    WALL,
    WEST,
    prism_with_tip,
    small_window,
    spare_box,
    with_degenerate_face,
    with_spare,
)

STEP = 2.0**-10


def base_cases() -> Iterator[Case]:
    """Scenes that show each part of the format."""
    yield Case(
        "one-cell",
        SINGLE,
        "One cell before a wall on a ground; no portals, so every delta table is empty.",
        "A reader that cannot take tables of length 0.",
    )
    yield Case(
        "ring",
        RING,
        "Five cells around a wall, a cycle in the portal graph, two contents, faces hidden from some cells.",
        "A validator that refuses what is right.",
    )
    yield Case(
        "two-sectors",
        TWO_SECTORS,
        "The ring in two nav files, with portals from one to the other.",
        "Cell numbers that are local to a nav file; polygons that are stored in one file only.",
    )
    yield Case(
        "slanted-cells",
        SLANTED,
        "The ring with its upper cell cut by a slanted plane.",
        "Code that takes every cell for a box.",
    )
    yield Case(
        "degenerate-face",
        with_degenerate_face(),
        "The ring with a triangle without area in the middle of the numbering.",
        "A loader that drops degenerate triangles and so shifts every face number behind them.",
    )


def _overestimate(states: list[State]) -> None:
    states[WEST].faces = sorted([*states[WEST].faces, 4])
    states[WEST].codes = object_codes(RING, RING.cells[WEST], states[WEST].faces)


def _one_finer(states: list[State]) -> None:
    states[WEST].codes[3] -= 1


def _external(tileset: Json, files: Files, depth: int) -> None:
    child = tileset["root"]["children"][1]
    inner: Json = {
        "asset": {"version": "1.1"},
        "geometricError": 8.0,
        "root": {**copy.deepcopy(child), "refine": "ADD"},
    }
    for level in range(depth, 0, -1):
        target = inner["root"]["content"]["uri"]
        inner["root"]["content"]["uri"] = target if level < depth else f"../{target}"
        files[f"external/{level}.json"] = json_bytes(inner)
        box = child["boundingVolume"]
        link = {"uri": f"{level}.json"}
        inner = {
            "asset": {"version": "1.1"},
            "geometricError": 8.0,
            "root": {"boundingVolume": box, "geometricError": 8.0, "refine": "ADD", "content": link},
        }
    child["content"] = {"uri": "external/1.json"}
    files["tileset.json"] = json_bytes(tileset)


def external_files(depth: int) -> Callable[[Files], None]:
    """Edit after which the second content is reached through a chain of external tilesets."""

    def edit(files: Files) -> None:
        _external(json.loads(files["tileset.json"]), files, depth)

    return edit


def coarse_tile(tileset: Json) -> None:
    """Put a content of level 1, a copy of the second one, above that."""
    fine = tileset["root"]["children"][1]
    facts = {**fine["content"]["extensions"]["3DTILES_nav"], "level": 1, "contentId": 7}
    coarse = {"uri": "content/coarse.glb", "extensions": {"3DTILES_nav": facts}}
    tileset["root"]["children"][1] = {
        "boundingVolume": copy.deepcopy(fine["boundingVolume"]),
        "geometricError": 4.0,
        "refine": "REPLACE",
        "content": coarse,
        "children": [fine],
    }


def coarse_file(files: Files) -> None:
    """Write the file of the content of level 1."""
    files["content/coarse.glb"] = files["content/1.glb"]


def _contents_array(tileset: Json) -> None:
    children = tileset["root"].pop("children")
    tileset["root"]["contents"] = [child["content"] for child in children]


def _foreign(tileset: Json) -> None:
    tileset["extras"] = {"note": "any value"}
    tileset["extensionsUsed"].append("VENDOR_other")
    tileset["extensionsRequired"] = ["VENDOR_other"]
    entry = tileset["extensions"]["3DTILES_nav"]
    entry["extensions"] = {"VENDOR_other": {"x": 1}}
    entry["grid"]["extras"] = 5
    entry["later"] = True


def _fractions(target: Json) -> None:
    """Write every whole number of the objects within an object with a fraction of zero."""
    for key, value in target.items():
        if type(value) is int:
            target[key] = float(value)
        elif isinstance(value, dict) and key != "provenance":
            _fractions(value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for item in value:
                _fractions(item)


def structure_cases() -> Iterator[Case]:
    """Forms that 3D Tiles allows."""
    yield Case(
        "external-tilesets-32-deep",
        RING,
        "A content that is reached through 32 external tilesets inside each other.",
        "A reader that stops too early, or resolves a uri against the folder of the entry tileset.",
        near=("core/external-tilesets-end",),
        files=external_files(32),
    )
    yield Case(
        "coarse-level",
        RING,
        "A content of level 1 above a content of level 0, refined by REPLACE.",
        "A reader that counts the faces of coarse levels.",
        tileset=coarse_tile,
        files=coarse_file,
    )
    yield Case(
        "contents-array",
        RING,
        "Both contents on the root tile, as `contents`.",
        "A reader that knows `content` only.",
        tileset=_contents_array,
    )
    yield Case(
        "foreign-members",
        RING,
        "Other extensions, extras and a member of a later version.",
        "A reader that refuses what it does not know.",
        tileset=_foreign,
    )
    yield Case(
        "whole-numbers-with-fraction",
        RING,
        "Whole numbers in JSON are written as 5.0, which JSON Schema takes for integers.",
        "A reader that uses a number as an index without making it an integer.",
        entry=_fractions,
        nav_json=of_first(_fractions),
    )
    yield Case(
        "overestimate",
        RING,
        "The west cell lists a face that it cannot see, and does not count it as proven visible.",
        "A validator that asks for the exact visible set.",
        near=("pvs/proven-within-listed", "lod/objects-match"),
        states=_overestimate,
    )


def _scale_entry(factor: float) -> tuple[float, ...]:
    # The scale must stay below 1e-9 in the product with the transpose, so below 5e-10 in an element.
    values = list(RING.transform)
    values[1] *= factor
    values[4] *= factor
    return tuple(values)


def _shift_root(tileset: Json) -> None:
    tileset["root"]["transform"][12] += 5e-7


def _shrink_box(volume: Json, amount: float) -> None:
    for k in (3, 7, 11):
        volume["box"][k] = max(volume["box"][k] - amount, 0.0)


def _shrink_tiles(tileset: Json) -> None:
    _shrink_box(tileset["root"]["boundingVolume"], STEP / 2)
    for child in tileset["root"]["children"]:
        _shrink_box(child["boundingVolume"], STEP / 2)


def _shrink_sector(entry: Json) -> None:
    _shrink_box(entry["sectors"][0]["boundingVolume"], STEP / 2)


def _stretch_normal(world: World) -> World:
    first = world.cells[0].planes[0]
    stretched = (first[0] * (1 + 2.0**-41), 0.0, 0.0, first[3] * (1 + 2.0**-41))
    cell = replace(world.cells[0], planes=(stretched, *world.cells[0].planes[1:]))
    return replace(world, cells=(cell, *world.cells[1:]))


def scaled_world(exponent: int, size: float, far: float = 0.0) -> World:
    """Ground, wall and cell in units of a length; far, when not 0, is where the ground ends, in metres."""
    s, edge = size, far or 8 * size
    ground = quad(
        (-8 * s, -8 * s, 0), (edge, -8 * s, 0), (edge, 8 * s, 0), (-8 * s, 8 * s, 0), exponent=exponent
    )
    wall = quad((0, -2 * s, 0), (0, 2 * s, 0), (0, 2 * s, 4 * s), (0, -2 * s, 4 * s), exponent=exponent)
    objects = (replace(GROUND, shapes=(ground,)), replace(WALL, shapes=(wall,)))
    cell = box_cell((s, -s, s / 2), (3 * s, s, 2 * s))
    lod = replace(RING.lod, reference=5 / s)
    return World(objects, (cell,), exponent=exponent, clearance=s / 4, lod=lod)


def limit_cases() -> Iterator[Case]:
    """Near misses of the numeric limits outside geometry."""
    far = (2**23 - 1) * STEP
    tight = "A limit that is drawn too tight."
    for name, world, made, requirement in (
        (
            "grid-exponent-minus-20",
            scaled_world(-20, 0.5),
            "The finest grid: a step of 2^-20 m.",
            "core/grid-exponent",
        ),
        ("grid-exponent-0", scaled_world(0, 64.0), "The coarsest grid: a step of 1 m.", "core/grid-exponent"),
        ("grid-limit", scaled_world(-10, 1.0, far), "A position of 2^23 - 1 steps.", "core/on-grid"),
        ("one-level", replace(RING, lod=COARSE_LOD), "A scale of one level.", "lod/parameters"),
        ("all-levels", replace(SINGLE, lod=FINE_LOD), "A scale of 256 levels.", "lod/parameters"),
        (
            "transform-rounded",
            replace(RING, transform=_scale_entry(1 + 1e-10)),
            "A rotation that is off by 1e-10.",
            "core/transform-rigid",
        ),
        ("normal-rounded", _stretch_normal(RING), "A normal whose length is 1 + 2^-41.", "cell/unit-normals"),
    ):
        yield Case(name, world, made, tight, near=(requirement,))
    yield Case(
        "content-transform-rounded",
        RING,
        "A tile transform that is off by 5e-7.",
        tight,
        near=("core/content-transform",),
        tileset=_shift_root,
    )
    yield Case(
        "tight-tile-volumes",
        RING,
        "Tile volumes half a grid step smaller than the contents.",
        tight,
        near=("core/tile-volume-bounds",),
        tileset=_shrink_tiles,
    )
    yield Case(
        "tight-sector-volume",
        RING,
        "A sector volume half a grid step smaller than the cells.",
        tight,
        near=("cell/sector-volume-bounds",),
        entry=_shrink_sector,
    )
    yield Case(
        "one-code-finer",
        RING,
        "A level code that is one less than that of the largest L.",
        tight,
        near=("lod/not-wasteful",),
        states=_one_finer,
    )


def geometry_cases() -> Iterator[Case]:
    """Near misses of the limits on cells and portals."""
    tight = "A limit that is drawn too tight."
    contact = "An overlap test that takes contact for intersection."
    beside = Case("", RING, "", "")
    at_clearance = replace(RING, clearance=0.375)
    yield replace(
        beside,
        name="touching-wall",
        world=TOUCHING,
        made="Cells that touch a wall, with clearance 0.",
        catches=contact,
        near=("cell/clear-of-geometry", "cell/disjoint-interiors"),
    )
    yield replace(
        beside,
        name="clearance-reached",
        world=at_clearance,
        made="Cells that are exactly as far from the faces as the clearance says.",
        catches=contact,
        near=("cell/clear-of-geometry",),
    )
    yield replace(
        beside,
        name="small-facet",
        world=with_spare(prism_with_tip(STEP * 0.68)),
        made="A plane whose facet has 1.2 times the area of a squared grid step.",
        catches=tight,
        near=("cell/no-redundant-plane",),
    )
    yield replace(
        beside,
        name="thin-cell",
        world=spare_box((-5 - 2.125 * STEP, -7, 0.5)),
        made="A cell 2.125 grid steps thick.",
        catches=tight,
        near=("cell/non-empty",),
    )
    yield replace(
        beside,
        name="small-portal",
        world=small_window(STEP, 1.25 * STEP),
        made="A portal whose polygon has 1.25 times the area of a squared grid step.",
        catches=tight,
        near=("portal/shared-polygon",),
    )


def valid_cases() -> Iterator[Case]:
    """All valid cases."""
    yield from base_cases()
    yield from structure_cases()
    yield from form_cases()
    yield from limit_cases()
    yield from geometry_cases()
    yield from proof_cases()
    yield from prism_cases()
