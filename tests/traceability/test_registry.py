"""One string per rule: the registry, the checks, the schemas and the cases name the same requirements."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from suite import NAMES_NO_REQUIREMENT, cases, registry, schemas

from tilesnav_validator.checks import registered_ids
from tilesnav_validator.registry import REGISTRY

STAGES = ("io", "schema", "link", "binary", "geometry", "visibility")
WAYS = ("check", "schema", "sampling", "inspection")
CLASSES = ("core", "cell", "pvs", "lod", "delta", "provenance", "certificate", "level", "packet")


BY_BOTH = {"certificate/container", "level/container"}
"""Requirements that a schema checks as well as code."""


def comments(node: Any) -> Iterator[str]:
    if isinstance(node, dict):
        if isinstance(node.get("$comment"), str):
            yield node["$comment"]
        for value in node.values():
            yield from comments(value)
    elif isinstance(node, list):
        for value in node:
            yield from comments(value)


def ids(*ways: str) -> set[str]:
    return {name for name, row in registry().items() if row["checked_by"] in ways}


def test_rows_are_well_formed() -> None:
    for name, row in registry().items():
        assert re.fullmatch(r"[a-z]+/[a-z]+(-[a-z]+)*", name), name
        assert row["stage"] in STAGES, name
        assert row["checked_by"] in WAYS, name
        assert row["class"] in CLASSES, name
        verb = row["level"].upper()
        assert verb in {"SHALL", "SHOULD"}, name
        assert re.search(rf"\b{verb}\b", row["text"]), name
        assert row["rationale"].strip(), name
        assert re.fullmatch(r"\d+\.\d+\.\d+", row["since"]), name


def test_every_check_is_a_requirement_and_every_requirement_has_a_check() -> None:
    assert set(registered_ids()) == ids("check", "sampling")


def test_comments_of_the_schemas_are_the_requirements_that_schemas_check() -> None:
    named = {c for name, s in schemas().items() if name not in NAMES_NO_REQUIREMENT for c in comments(s)}
    assert named == ids("schema") | BY_BOTH
    assert ids("check") >= BY_BOTH


def test_the_validator_reads_this_registry() -> None:
    assert {name: row.text for name, row in REGISTRY.items()} == {
        name: row["text"] for name, row in registry().items()
    }


def test_every_requirement_has_an_invalid_case() -> None:
    failed = {case.facts.get("requirement") for case in cases()}
    assert ids("check", "schema", "sampling") - failed == set()


def test_cases_name_requirements_of_the_registry() -> None:
    for case in cases():
        named = [case.facts["requirement"]] if "requirement" in case.facts else []
        assert set(named + case.facts.get("nearMissOf", [])) <= registry().keys(), case.name


def test_cases_lie_in_the_folder_of_their_requirement() -> None:
    for case in cases():
        kind = {0: "valid", 1: "invalid", 2: "unreadable"}[case.status]
        parent = "/".join(part for part in (kind, case.facts.get("requirement")) if part)
        assert case.name.rpartition("/")[0] == parent


LIMIT = re.compile(
    r"\ballowance\b|\bat most\b|\b(?:less|greater) than\b|\bfrom -?\d|\bwithin \S*\d|\bdeep\b|\bminus one\b"
)
EXACT = {
    "lod/code-range": "codes are whole numbers, and the last code is used by most cases",
    "lod/fine-enough": "the code of the largest L is used by most cases",
    "portal/target-exists": "the last cell is a target in most cases",
    "pvs/sorted-faces": "the last face is listed by a cell of most cases",
    "provenance/stated": "both ends of 0 to 1 are values of the tests of the schema",
}
"""Limits that need no case of their own, and why."""


def test_every_numeric_limit_has_a_near_miss() -> None:
    limits = {name for name, row in registry().items() if LIMIT.search(row["text"])}
    near = {name for case in cases() for name in case.facts.get("nearMissOf", [])}
    assert limits - near - EXACT.keys() == set()
    assert near & EXACT.keys() == set()
