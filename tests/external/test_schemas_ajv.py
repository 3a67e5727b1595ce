"""ajv, a second implementation of JSON Schema, gives the verdicts of jsonschema on every conformance case."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from referencing import Registry, Resource

pytestmark = pytest.mark.node
ROOT = Path(__file__).resolve().parents[2]
SCHEMAS = sorted((ROOT / "schema").glob("*.schema.json"))
NAV_HEADER = struct.Struct("<4sIQQ")


def refuse(constant: str) -> None:
    raise ValueError(f"{constant} is no JSON")


def parse(data: bytes) -> Any:
    """Strict JSON; raises ValueError or RecursionError, as some cases want."""
    return json.loads(data.decode("utf-8"), parse_constant=refuse)


def load(path: Path) -> Any:
    return parse(path.read_bytes())


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
        except (ValueError, RecursionError):
            continue  # the case is about bytes that are no JSON
        if path.name == "case.json":
            yield "case.schema.json", value
        elif isinstance(value, dict):
            yield "entry-tileset.schema.json", value
            nav = value.get("extensions", {}).get("3DTILES_nav")
            if nav is not None:
                yield "tileset.3DTILES_nav.schema.json", nav
            yield from (("content.3DTILES_nav.schema.json", one) for one in contents_of(value.get("root")))
    kinds = {".nav": "nav.schema.json", ".cert": "certificates.schema.json", ".fmap": "facemap.schema.json"}
    for path in sorted(p for p in case.rglob("*") if p.suffix in kinds):
        data = path.read_bytes()
        if len(data) < NAV_HEADER.size:
            continue
        json_length = NAV_HEADER.unpack_from(data)[2]
        try:
            yield kinds[path.suffix], parse(data[NAV_HEADER.size : NAV_HEADER.size + json_length])
        except (ValueError, RecursionError):
            continue


@pytest.fixture(scope="module")
def schemas() -> dict[str, Any]:
    assert SCHEMAS, "schema/ holds no schema"
    return {schema["$id"]: schema for schema in map(load, SCHEMAS)}


@dataclass(frozen=True)
class Question:
    """An instance for a schema, and where it is from."""

    source: str
    schema: str
    instance: Any


def ask_ajv(
    judge: Callable[..., str], schemas: dict[str, Any], questions: list[Question], file: Path
) -> list[Any]:
    instances = [{"schema": one.schema, "instance": one.instance} for one in questions]
    file.write_text(json.dumps({"schemas": list(schemas.values()), "instances": instances}), encoding="utf-8")
    verdicts: list[Any] = json.loads(judge("ajv_verdicts.mjs", file))
    assert len(verdicts) == len(questions)
    assert {verdict["valid"] for verdict in verdicts} == {True, False}, "the questions hold both kinds"
    return verdicts


def test_ajv_and_jsonschema_agree_on_the_conformance_cases(
    judge: Callable[..., str], schemas: dict[str, Any], tmp_path: Path
) -> None:
    cases = sorted(path.parent for path in (ROOT / "conformance" / "cases").rglob("case.json"))
    questions = [Question(case.name, name, value) for case in cases for name, value in instances_of(case)]
    assert len(questions) > len(cases) > 0
    registry: Registry[Any] = Registry().with_resources(
        (name, Resource.from_contents(schema)) for name, schema in schemas.items()
    )
    verdicts = ask_ajv(judge, schemas, questions, tmp_path / "request.json")
    for one, verdict in zip(questions, verdicts, strict=True):
        errors = Draft202012Validator(schemas[one.schema], registry=registry).iter_errors(one.instance)
        ours = sorted(error.json_path for error in errors)
        assert verdict["valid"] == (not ours), (one.source, one.schema, ours, verdict["errors"])


def test_ajv_gives_the_stated_verdicts_on_the_cases_of_single_keywords(
    judge: Callable[..., str], schemas: dict[str, Any], tmp_path: Path
) -> None:
    groups = [load(path) for path in sorted((ROOT / "conformance" / "schema").glob("*.json"))]
    stated = [(group["schema"], one) for group in groups for one in group["tests"]]
    assert stated
    questions = [Question(one["description"], schema, one["data"]) for schema, one in stated]
    verdicts = ask_ajv(judge, schemas, questions, tmp_path / "request.json")
    wrong = [
        (question.schema, question.source, verdict["errors"])
        for question, (_, one), verdict in zip(questions, stated, verdicts, strict=True)
        if verdict["valid"] != one["valid"]
    ]
    assert wrong == []
