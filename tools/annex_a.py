"""Write Annex A, the abstract test suite, from the registry, or with --check compare the committed one.

Usage: python tools/annex_a.py [--check]
"""

from __future__ import annotations

import json
import sys
import tomllib
from pathlib import Path
from typing import Any

from generated import finish

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "spec" / "annex_a.md"
CASES = ROOT / "conformance" / "cases"
TARGETS = {"packet": "sequence of packets, for a tileset"}
"""Targets of the classes whose target is not a tileset."""
METHODS = {
    "schema": "Validate against the JSON Schemas; an error under the `$comment` of this id fails the test.",
    "check": "Inspect the files as the text says.",
    "sampling": 'Search for a counterexample and decide each candidate exactly. A pass reads "not refuted".',
}
HEAD = """# Annex A: abstract test suite (normative)

Written by `tools/annex_a.py` from `spec/requirements.toml` and the conformance cases.

Every test has the id of its requirement, with `/conf/` instead of `/req/` before it. A test of a later stage
is run only on what the tests of earlier stages have left sound; the stages are io, schema, link, binary,
geometry and visibility. In the stage io the files are read; no requirement is judged in it, and an entry
tileset that cannot be read is not judged at all. A tileset conforms to a class when no test of the class
fails and none was left out. Each test is shown to work by the cases that it refuses, each of which breaks
nothing else.
"""


def cases_of(requirement: str) -> list[str]:
    """Links to the invalid cases of a requirement."""
    folders = sorted(p.parent for p in (CASES / "invalid" / requirement).rglob("case.json"))
    return [f"[{p.name}](../{p.relative_to(ROOT).as_posix()}/case.json)" for p in folders]


def near_misses() -> dict[str, list[str]]:
    """Links to valid cases that only just keep a requirement, by its id."""
    found: dict[str, list[str]] = {}
    for path in sorted((CASES / "valid").rglob("case.json")):
        for requirement in json.loads(path.read_text(encoding="utf-8")).get("nearMissOf", []):
            link = f"[{path.parent.name}](../{path.relative_to(ROOT).as_posix()})"
            found.setdefault(requirement, []).append(link)
    return found


def _test(row: dict[str, Any], near: list[str]) -> list[str]:
    lines = [f"### /conf/{row['id']}", "", f"> {row['text']}", ""]
    lines += [f"* Requirement: `/req/{row['id']}`, since {row['since']}", f"* Stage: {row['stage']}"]
    lines += [f"* Method: {METHODS[row['checked_by']]}", f"* Reason: {row['rationale']}"]
    lines += [f"* Refuses: {', '.join(cases_of(row['id']))}"]
    return [*lines, *([f"* Accepts: {', '.join(near)}"] if near else []), ""]


def annex() -> str:
    """The page."""
    registry = tomllib.loads((ROOT / "spec" / "requirements.toml").read_text(encoding="utf-8"))
    near = near_misses()
    lines = [HEAD, f"Base of all ids: `{registry['base_uri']}`", ""]
    for name in dict.fromkeys(row["class"] for row in registry["requirement"]):
        lines += [
            f"## Conformance class {name}",
            "",
            f"`{registry['base_uri']}/conf/{name}`, target: {TARGETS.get(name, 'tileset')}",
            "",
        ]
        for row in registry["requirement"]:
            if row["class"] == name:
                lines += _test(row, near.get(row["id"], []))
    return "\n".join(lines).rstrip("\n") + "\n"


if __name__ == "__main__":
    sys.exit(finish(TARGET, annex(), sys.argv[1:]))
