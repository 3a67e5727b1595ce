"""The bundled schema judges as the single schemas do, without any other file."""

from __future__ import annotations

import json

import pytest
from jsonschema import Draft202012Validator
from referencing import Registry, Resource
from suite import ROOT

BUNDLE = json.loads((ROOT / "schema" / "3DTILES_nav.bundle.json").read_text(encoding="utf-8"))
TESTS = {
    value["schema"]: value["tests"]
    for value in (
        json.loads(p.read_text(encoding="utf-8")) for p in (ROOT / "conformance" / "schema").glob("*.json")
    )
}


def judge(name: str) -> Draft202012Validator:
    """Validator of one of the schemas in the bundle, found by its $id there."""
    registry = Registry().with_resource(BUNDLE["$id"], Resource.from_contents(BUNDLE)).crawl()
    return Draft202012Validator({"$ref": name}, registry=registry)


@pytest.mark.parametrize("name", sorted(TESTS.keys() - {"case.schema.json"}))
def test_the_bundle_gives_the_stated_verdicts(name: str) -> None:
    validator = judge(name)
    wrong = [t["description"] for t in TESTS[name] if validator.is_valid(t["data"]) != t["valid"]]
    assert wrong == []


def test_the_bundle_itself_judges_an_entry_tileset() -> None:
    validator = judge(BUNDLE["$id"])
    tests = TESTS["entry-tileset.schema.json"]
    assert [t["description"] for t in tests if validator.is_valid(t["data"]) != t["valid"]] == []
