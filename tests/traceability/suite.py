"""The registry, the schemas and the conformance cases, as the tests of this folder read them."""

from __future__ import annotations

import json
import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator
from jsonschema.exceptions import ValidationError
from referencing import Registry, Resource

from tilesnav_validator.findings import Settings, UnreadableInputError
from tilesnav_validator.runner import Result, judge

ROOT = Path(__file__).resolve().parents[2]
CASES = ROOT / "conformance" / "cases"
NAMES_NO_REQUIREMENT = {"case.schema.json", "report.schema.json"}
RAYS = 20_000

Schemas = dict[str, Any]
SchemaPath = tuple[str | int, ...]


@cache
def registry() -> dict[str, dict[str, str]]:
    """Rows of spec/requirements.toml by id."""
    rows = tomllib.loads((ROOT / "spec" / "requirements.toml").read_text(encoding="utf-8"))["requirement"]
    assert len(rows) == len({row["id"] for row in rows}), "an id stands twice in the registry"
    return {row["id"]: row for row in rows}


@cache
def schemas() -> Schemas:
    """Schemas by file name."""
    return {
        p.name: json.loads(p.read_text(encoding="utf-8")) for p in (ROOT / "schema").glob("*.schema.json")
    }


def validator(all_schemas: Schemas, name: str) -> Draft202012Validator:
    """Validator of one schema that finds the others."""
    resources = ((key, Resource.from_contents(value)) for key, value in all_schemas.items())
    return Draft202012Validator(all_schemas[name], registry=Registry().with_resources(resources))


def nearest_comment(all_schemas: Schemas, name: str, error: ValidationError) -> str:
    """Requirement of an error: the $comment nearest above the failing keyword on the schema path."""
    found = _comment_on_path(all_schemas, name, all_schemas[name], tuple(error.absolute_schema_path), "")
    assert found is not None, error
    return found


def _comment_on_path(all_schemas: Schemas, name: str, node: Any, path: SchemaPath, above: str) -> str | None:
    """Last $comment on a path, or None where the path leads nowhere; jsonschema leaves $ref out of paths."""
    found = node.get("$comment", above) if isinstance(node, dict) else above
    if not path:
        return found
    if isinstance(node, list) or path[0] in node:
        direct = _comment_on_path(all_schemas, name, node[path[0]], path[1:], found)
        if direct is not None:
            return direct
    if "$ref" not in node:
        return None
    document, _, pointer = node["$ref"].partition("#")
    target = all_schemas[document or name]
    for part in pointer.split("/")[1:]:
        target = target[part]
    return _comment_on_path(all_schemas, document or name, target, path, found)


def failed_requirements(all_schemas: Schemas, name: str, data: object) -> set[str]:
    """Requirements that a schema finds broken; an empty name for an error without one."""
    errors = validator(all_schemas, name).iter_errors(data)
    if name in NAMES_NO_REQUIREMENT:
        return {"" for _ in errors}
    return {nearest_comment(all_schemas, name, error) for error in errors}


@dataclass(frozen=True)
class Case:
    """A conformance case."""

    folder: Path
    facts: dict[str, Any]

    @property
    def name(self) -> str:
        """Path below conformance/cases."""
        return self.folder.relative_to(CASES).as_posix()

    @property
    def status(self) -> int:
        """Expected exit status."""
        return int(self.facts["exitStatus"])


@cache
def cases() -> tuple[Case, ...]:
    """All conformance cases."""
    files = sorted(CASES.rglob("case.json"))
    return tuple(Case(p.parent, json.loads(p.read_text(encoding="utf-8"))) for p in files)


def judged(case: Case) -> list[str]:
    """Requirements that a case is judged by, in the order of the registry."""
    return [name for name, row in registry().items() if row["class"] != "packet" or "packets" in case.facts]


@cache
def verdict(case: Case) -> Result | None:
    """What the validator says about a case; None when it could not read it."""
    packets = tuple(case.folder / name for name in case.facts.get("packets", []))
    try:
        return judge(case.folder / case.facts["tileset"], Settings(RAYS, seed=1, threads=1, packets=packets))
    except UnreadableInputError:
        return None


Case.__hash__ = lambda self: hash(self.folder)  # type: ignore[method-assign]
