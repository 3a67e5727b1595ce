"""ajv, a second implementation of JSON Schema, gives the verdicts of jsonschema on every conformance case."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from referencing import Registry, Resource

pytestmark = pytest.mark.node
ROOT = Path(__file__).resolve().parents[2]
SCHEMAS = sorted((ROOT / "schema").glob("*.schema.json"))
NAV_HEADER = struct.Struct("<4sIQQ")


def load(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def contents_of(tile: Any) -> Iterator[Any]:
    """Content objects of a tile and of its children, where they are objects at all."""
    if isinstance(tile, dict):
        nav = tile.get("content", {}).get("extensions", {}).get("3DTILES_nav")
        if nav is not None:
            yield nav
        for child in tile.get("children", []):
            yield from contents_of(child)


def instances_of(case: Path) -> Iterator[tuple[str, Any]]:
    """(name of the schema, instance) for the JSON of one case that can be read as JSON."""
    for path in sorted(case.rglob("*.json")):
        try:
            value = load(path)
        except ValueError:
            continue  # the case is about bytes that are no JSON
        if path.name == "case.json":
            yield "case.schema.json", value
        elif isinstance(value, dict):
            yield "entry-tileset.schema.json", value
            nav = value.get("extensions", {}).get("3DTILES_nav")
            if nav is not None:
                yield "tileset.3DTILES_nav.schema.json", nav
            yield from (("content.3DTILES_nav.schema.json", one) for one in contents_of(value.get("root")))
    for path in sorted(case.rglob("*.nav")):
        data = path.read_bytes()
        if len(data) < NAV_HEADER.size:
            continue
        json_length = NAV_HEADER.unpack_from(data)[2]
        try:
            yield "nav.schema.json", json.loads(data[NAV_HEADER.size : NAV_HEADER.size + json_length])
        except ValueError:
            continue


@pytest.fixture(scope="module")
def schemas() -> dict[str, Any]:
    assert SCHEMAS, "schema/ holds no schema"
    return {schema["$id"]: schema for schema in map(load, SCHEMAS)}


def test_ajv_and_jsonschema_agree_on_the_conformance_cases(
    judge: Callable[..., str], schemas: dict[str, Any], tmp_path: Path
) -> None:
    cases = sorted(path.parent for path in (ROOT / "conformance").rglob("case.json"))
    if not cases:
        pytest.skip("conformance/ holds no case yet")
    registry: Registry[Any] = Registry().with_resources(
        (name, Resource.from_contents(schema)) for name, schema in schemas.items()
    )
    judged = [(case, name, value) for case in cases for name, value in instances_of(case)]
    request = tmp_path / "request.json"
    instances = [{"schema": name, "instance": value} for _, name, value in judged]
    request.write_text(
        json.dumps({"schemas": list(schemas.values()), "instances": instances}), encoding="utf-8"
    )

    verdicts = json.loads(judge("ajv_verdicts.mjs", request))

    assert len(verdicts) == len(judged)
    assert {verdict["valid"] for verdict in verdicts} == {True, False}, "the cases hold both kinds"
    for (case, name, value), verdict in zip(judged, verdicts, strict=True):
        errors = Draft202012Validator(schemas[name], registry=registry).iter_errors(value)
        ours = sorted(error.json_path for error in errors)
        assert verdict["valid"] == (not ours), (case.name, name, ours, verdict["errors"])
