"""Every keyword of every schema has a reason: a test of conformance/schema notices when it is gone."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import pytest
from suite import ROOT, Schemas, failed_requirements, schemas

ANNOTATIONS = {"$schema", "$id", "$comment", "title", "description", "$defs"}
TESTS: dict[str, list[dict[str, Any]]] = {
    value["schema"]: value["tests"]
    for value in (
        json.loads(p.read_text(encoding="utf-8")) for p in (ROOT / "conformance" / "schema").glob("*.json")
    )
}
Path = tuple[str | int, ...]


def keywords(node: Any, path: Path = ()) -> Iterator[Path]:
    """Place of every keyword, of every member of `properties` and of every name in `required`."""
    for key in node:
        if key in ANNOTATIONS:
            continue
        yield (*path, key)
        value = node[key]
        if key == "required":
            yield from ((*path, key, i) for i in range(len(value)))
        elif key == "properties":
            for name, child in value.items():
                yield from keywords(child, (*path, key, name))
        elif key in {"items", "not", "contains", "if", "then", "else", "additionalProperties"}:
            yield from keywords(value, (*path, key))
        elif key == "allOf":
            for i, child in enumerate(value):
                yield from keywords(child, (*path, key, i))
    for name, child in node.get("$defs", {}).items():
        yield from keywords(child, (*path, "$defs", name))


def without(all_schemas: Schemas, name: str, path: Path) -> Schemas:
    changed = copy.deepcopy(all_schemas[name])
    node: Any = changed
    for key in path[:-1]:
        node = node[key]
    del node[path[-1]]
    return {**all_schemas, name: changed}


def expected(test: dict[str, Any]) -> set[str]:
    return set() if test["valid"] else {test.get("requirement", "")}


def likely_first(name: str, path: Path) -> list[tuple[str, dict[str, Any]]]:
    """Tests, those first whose description names the members on the path."""
    members = [str(b) for a, b in pairwise(path) if a in {"properties", "required"}]
    pool = [(name, t) for name in ([name] if name in TESTS else TESTS) for t in TESTS[name]]
    return sorted(pool, key=lambda one: -sum(member in one[1]["description"] for member in members))


PLACES = [
    (name, path)
    for name, schema in schemas().items()
    if name != "report.schema.json"
    for path in keywords(schema)
]


@pytest.mark.parametrize("name", sorted(TESTS))
def test_schemas_give_the_stated_verdicts(name: str) -> None:
    wrong = {t["description"]: failed_requirements(schemas(), name, t["data"]) for t in TESTS[name]}
    stated = {t["description"]: expected(t) for t in TESTS[name]}
    assert wrong == stated
    assert {t["valid"] for t in TESTS[name]} == {True, False}


@pytest.mark.parametrize(
    ("name", "path"), PLACES, ids=lambda v: v if isinstance(v, str) else "/".join(map(str, v))
)
def test_a_test_notices_when_a_keyword_is_gone(name: str, path: Path) -> None:
    changed = without(schemas(), name, path)
    assert any(
        failed_requirements(changed, schema, test["data"]) != expected(test)
        for schema, test in likely_first(name, path)
    )


@pytest.mark.parametrize("name", sorted(TESTS.keys() - {"case.schema.json"}))
def test_every_constraint_stands_under_a_comment(name: str) -> None:
    def bare(node: Any, path: Path, above: bool) -> Iterator[Path]:
        covered = above or "$comment" in node
        for key in node:
            if key not in ANNOTATIONS and key != "properties" and not covered:
                yield (*path, key)
        for member, child in node.get("properties", {}).items():
            yield from bare(child, (*path, member), covered)

    assert list(bare(schemas()[name], (), False)) == []
