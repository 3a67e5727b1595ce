"""Cases for single keywords of the schemas: values that fit, and values that one keyword refuses.

A file conformance/schema/NAME.json holds the tests of schema/NAME.schema.json. Each test has `data`, whether
it is `valid`, and for an invalid one the `requirement` that the nearest `$comment` names; schemas without
such comments have tests without it.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

from casebuilder.assemble import Case, Json, content_json, entry_object, entry_tileset
from casebuilder.coarse import map_parts, moved
from casebuilder.container import dumps, nav_parts
from casebuilder.packets import KEY, Step
from casebuilder.proofs import proof_parts
from casebuilder.state import sector_tables, world_states
from casebuilder.valid_proofs import in_a_box
from casebuilder.world import World
from casebuilder.worlds import HIDING, SINGLE

Path = tuple[str | int, ...]
ABSENT = object()
BIG = 2**31 + 1
COUNT: tuple[object, ...] = ("1", 0.5, -1, BIG)
LIMITS: tuple[tuple[Path, object], ...] = (
    (("version",), "0.1.99"),
    (("grid", "exponent"), -20),
    (("grid", "exponent"), 0),
    (("clearance",), 0),
    (("faceCount",), 2**31),
    (("lod", "levelCount"), 1),
    (("lod", "levelCount"), 256),
    (("provenance", "coverage"), 0),
    (("provenance", "coverage"), 1),
    (("sectors", 0, "certificates"), {"uri": "nav/0.cert", "sha256": ""}),
)
"""Values that a limit of the entry object only just allows."""
INDEX: tuple[object, ...] = ("1", 0.5, -1)


def at(value: Any, path: Path) -> Any:
    """Member of a JSON value."""
    for key in path:
        value = value[key]
    return value


def changed(base: Json, path: Path, value: object) -> Any:
    """Copy of a JSON value with one member set, or removed when the value is ABSENT."""
    if not path:
        return value
    result = copy.deepcopy(base)
    owner = at(result, path[:-1])
    if value is ABSENT:
        del owner[path[-1]]
    else:
        owner[path[-1]] = value
    return result


class Tests:
    """Collects the tests of one schema."""

    def __init__(self, base: Json) -> None:
        self.base = base
        self.tests: list[Json] = []

    def valid(self, description: str, data: object) -> None:
        """Add a value that fits."""
        self.tests.append({"description": description, "valid": True, "data": data})

    def bad(self, requirement: str, path: Path, *values: object) -> None:
        """Add one refused value for each value of a member."""
        name = ".".join(map(str, path)) or "the whole"
        for value in values:
            said = "is absent" if value is ABSENT else f"is {_short(value)}"
            test: Json = {"description": f"{name} {said}", "valid": False}
            if requirement:
                test["requirement"] = requirement
            self.tests.append({**test, "data": changed(self.base, path, value)})

    def bad_object(self, requirement: str, path: Path, members: tuple[str, ...], missing: str = "") -> None:
        """Add what every object refuses: another type, a missing member, extensions that are no objects."""
        self.bad(missing or requirement, path, *([] if missing else ["text"]))
        for member in members:
            self.bad(requirement, (*path, member), ABSENT)
        for extensions in (5, {"VENDOR_other": 5}):
            self.bad(requirement, (*path, "extensions"), extensions)


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def _parts(world: World) -> tuple[Json, Json, Json]:
    states = world_states(world)
    content = content_json(world, 0, b"")
    tileset = entry_tileset(world, entry_object(world, states), [content])
    nav, _ = nav_parts(sector_tables(world, states, 0), *world.sectors[0])
    return tileset, content["extensions"]["3DTILES_nav"], nav


def entry_tests(base: Json) -> list[Json]:
    """Tests of the entry object."""
    t = Tests(base)
    e, s = "core/entry-object", "core/sectors-listed"
    t.valid("an entry object", base)
    for path, value in LIMITS:
        t.valid(f"{'.'.join(map(str, path))} is {value}", changed(base, path, value))
    t.bad_object(
        e,
        (),
        (
            "version",
            "grid",
            "transform",
            "clearance",
            "faceCount",
            "objectCount",
            "cellCount",
            "portalCount",
            "sectors",
            "lod",
            "pvs",
            "provenance",
        ),
    )
    t.bad("core/version", ("version",), 1, "0.2.0", "1.0.1.0", "0.1.x", "0.1.0-draft")
    t.bad_object("core/grid-exponent", ("grid",), ("exponent",))
    t.bad("core/grid-exponent", ("grid", "exponent"), "-10", -10.5, -21, 1)
    _numbers(t, e, ("transform",), 16)
    t.bad(e, ("clearance",), "0.25", -0.001)
    for member in ("faceCount", "objectCount", "portalCount"):
        t.bad(e, (member,), *COUNT)
    t.bad(e, ("cellCount",), "1", 1.5, 0, BIG)
    t.bad(s, ("sectors",), "text", [], ["text"])
    t.bad_object(s, ("sectors", 0), ("uri", "firstCell", "cellCount", "boundingVolume"))
    t.bad(s, ("sectors", 0, "uri"), 5, "")
    t.bad(s, ("sectors", 0, "firstCell"), *COUNT)
    t.bad(s, ("sectors", 0, "cellCount"), "1", 1.5, 0, BIG)
    t.bad_object(s, ("sectors", 0, "boundingVolume"), ("box",))
    _numbers(t, s, ("sectors", 0, "boundingVolume", "box"), 12)
    _certificates(t)
    _scales(t)
    t.bad_object(e, ("pvs",), ("listed", "provenVisible"))
    for member in ("listed", "provenVisible"):
        t.bad(e, ("pvs", member), *INDEX)
    t.base = {**base, "visibility": {"maxRange": 120.5}}
    t.valid("a range", t.base)
    t.bad_object("pvs/max-range", ("visibility",), ("maxRange",))
    t.bad("pvs/max-range", ("visibility", "maxRange"), "120", 0)
    return t.tests


def _numbers(t: Tests, requirement: str, path: Path, count: int) -> None:
    values = at(t.base, path)
    t.bad(requirement, path, "text", values[1:], [*values, 0], ["0", *values[1:]])
    assert len(values) == count


def _scales(t: Tests) -> None:
    lod, provenance = "lod/parameters", "provenance/stated"
    t.bad_object(lod, ("lod",), ("reference", "base", "levelCount"))
    t.bad(lod, ("lod", "reference"), "1", 0)
    t.bad(lod, ("lod", "base"), "2", 1)
    t.bad(lod, ("lod", "levelCount"), "16", 1.5, 0, 257)
    t.bad_object(provenance, ("provenance",), ("encoder", "parameters", "coverage"))
    t.bad(provenance, ("provenance", "encoder"), 5, "")
    t.bad(provenance, ("provenance", "parameters"), "text")
    t.bad(provenance, ("provenance", "coverage"), "1", -0.01, 1.01)


def _certificates(t: Tests) -> None:
    # The sector of the base has no such member, so a text in its place is told apart from a missing one.
    e, path = "core/entry-object", ("sectors", 0, "certificates")
    whole = {"uri": "nav/0.cert", "sha256": ""}
    t.bad(e, path, "text")
    for member in whole:
        t.bad(e, path, {name: value for name, value in whole.items() if name != member})
        t.bad(e, path, {**whole, member: 5})
    for more in ({"uri": ""}, {"extensions": 5}, {"extensions": {"VENDOR_other": 5}}):
        t.bad(e, path, {**whole, **more})


def content_tests(base: Json) -> list[Json]:
    """Tests of the content object."""
    t = Tests(base)
    c = "core/content-object"
    t.valid("a content object", base)
    t.bad_object(c, (), ("contentId", "level", "faceCount", "objectCount", "sha256"))
    for member in ("contentId", "level", "faceCount", "objectCount"):
        t.bad(c, (member,), *COUNT)
    t.bad(c, ("sha256",), 5)
    t.base = {**base, "porous": [0, 2], "oneSided": [1]}
    t.valid("porous and one-sided objects", t.base)
    for member in ("porous", "oneSided"):
        t.bad(c, (member,), "0", *([index] for index in COUNT))
    t.base = {**base, "level": 1, "faceMap": {"uri": "content/0.fmap", "sha256": ""}}
    t.valid("a face map", t.base)
    t.bad_object(c, ("faceMap",), ("uri", "sha256"))
    t.bad(c, ("faceMap", "uri"), 5, "")
    t.bad(c, ("faceMap", "sha256"), 5)
    return t.tests


def tileset_tests(base: Json) -> list[Json]:
    """Tests of the entry tileset."""
    t = Tests(base)
    a, used, optional, e = (
        "core/asset-version",
        "core/extension-used",
        "core/extension-optional",
        "core/entry-object",
    )
    t.valid("an entry tileset", base)
    t.valid("another extension is required", {**base, "extensionsRequired": ["VENDOR_other"]})
    t.bad(a, (), "text")
    for member in ("asset", "geometricError", "root"):
        t.bad(a, (member,), ABSENT, "text")
    t.bad(a, ("asset", "version"), ABSENT, "1.0", 1.1)
    t.bad(a, ("geometricError",), -1)
    t.bad(used, ("extensionsUsed",), ABSENT, "3DTILES_nav", [], ["VENDOR_other"])
    t.bad(optional, ("extensionsRequired",), ["3DTILES_nav"], ["VENDOR_other", "3DTILES_nav"])
    t.bad(e, ("extensions",), ABSENT, "text")
    t.bad(e, ("extensions", "3DTILES_nav"), ABSENT, "text")
    return t.tests


def nav_tests(base: Json) -> list[Json]:
    """Tests of the JSON part of a nav file."""
    t = Tests(base)
    groups = ("sector", "cells", "portals", "pvs", "lod", "deltas")
    _container(t, "container/json", groups, groups[1:])
    return t.tests


def certificate_tests(base: Json) -> list[Json]:
    """Tests of the JSON part of a certificate file."""
    t = Tests(base)
    j = "certificate/container"
    _container(t, j, ("sector", "frame", "certificates"), ("certificates",))
    limit = 2**23 - 1
    for value in (-limit, limit):
        t.valid(f"frame.origin.0 is {value}", changed(base, ("frame", "origin", 0), value))
    for value in (0, 29):
        t.valid(f"frame.subdivision is {value}", changed(base, ("frame", "subdivision"), value))
    t.bad(j, ("frame", "origin"), "text", [0, 0], [0, 0, 0, 0])
    t.bad(j, ("frame", "origin", 0), "0", 0.5, limit + 1, -limit - 1)
    t.bad(j, ("frame", "subdivision"), "0", 0.5, -1, 30)
    return t.tests


def face_map_tests(base: Json) -> list[Json]:
    """Tests of the JSON part of a face map."""
    t = Tests(base)
    _container(t, "level/container", ("faceMap",), ("faceMap",))
    return t.tests


def _container(t: Tests, j: str, groups: tuple[str, ...], tables: tuple[str, ...]) -> None:
    """What the JSON parts of all containers refuse."""
    base = t.base
    t.valid("a JSON part", base)
    t.bad_object(j, (), ("buffers", "bufferViews", *groups))
    t.bad(j, ("buffers",), "text", [], base["buffers"] * 2)
    t.bad_object(j, ("buffers", 0), ("byteLength",))
    t.bad(j, ("buffers", 0, "byteLength"), *INDEX)
    t.bad(j, ("buffers", 0, "uri"), "other.bin")
    t.bad(j, ("bufferViews",), "text")
    t.bad_object(j, ("bufferViews", 0), ("buffer", "byteOffset", "byteLength"))
    t.bad(j, ("bufferViews", 0, "buffer"), 1)
    t.bad(j, ("bufferViews", 0, "byteOffset"), *INDEX)
    t.bad(j, ("bufferViews", 0, "byteLength"), *INDEX)
    for group in groups:
        t.bad_object(j, (group,), tuple(base[group]))
    for group, members in ((g, base[g]) for g in tables):
        for member in members:
            t.bad(j, (group, member), *(COUNT if "ount" in member else INDEX))
    if "sector" in groups:
        t.bad(j, ("sector", "firstCell"), *COUNT)
        t.bad(j, ("sector", "cellCount"), "1", 1.5, 0, BIG)


def case_tests(valid: Json, invalid: Json) -> list[Json]:
    """Tests of case.json."""
    t = Tests(valid)
    t.valid("a valid case", valid)
    t.valid("an invalid case", invalid)
    t.bad("", (), "text")
    for member in ("tileset", "exitStatus", "made", "catches"):
        t.bad("", (member,), ABSENT)
    for member in ("tileset", "made", "catches"):
        t.bad("", (member,), 5, "")
    t.bad("", ("exitStatus",), 3)
    t.bad("", ("packets",), "walk.vep", [], [""], [5])
    t.bad("", ("nearMissOf",), "core/version", [], ["CORE"], [5])
    t.bad("", ("requirement",), "core/version")
    t.base = invalid
    t.bad("", ("exitStatus",), ABSENT)
    t.bad("", ("requirement",), ABSENT, 5, "Core/Version", "core/version/")
    return t.tests


def schema_files() -> dict[str, bytes]:
    """Test files by name."""
    tileset, content, nav = _parts(SINGLE)
    certificates, _ = proof_parts(in_a_box(HIDING, [])[0])
    walk = {"walk.vep": (Step(0, base=KEY),)}
    fits = Case("", SINGLE, "made", "catches", near=("core/version",), packets=walk).description()
    fails = Case("", SINGLE, "made", "catches", "core/version").description()
    tests: Iterator[tuple[str, list[Json]]] = iter(
        (
            ("tileset.3DTILES_nav", entry_tests(tileset["extensions"]["3DTILES_nav"])),
            ("content.3DTILES_nav", content_tests(content)),
            ("entry-tileset", tileset_tests(tileset)),
            ("nav", nav_tests(nav)),
            ("certificates", certificate_tests(certificates)),
            ("facemap", face_map_tests(map_parts(moved(SINGLE, 1)[0])[0])),
            ("case", case_tests(fits, fails)),
        )
    )
    return {f"{name}.json": _one_line_each(name, found) for name, found in tests}


def _one_line_each(name: str, tests: list[Json]) -> bytes:
    lines = b",\n".join(b"    " + dumps(test) for test in tests)
    return b'{\n  "schema": "%s.schema.json",\n  "tests": [\n%s\n  ]\n}\n' % (name.encode(), lines)
