"""One version, said in many places."""

from __future__ import annotations

import re
import tomllib

from suite import CASES, ROOT, json, registry

import tilesnav_ref
import tilesnav_validator

REGISTRY = tomllib.loads((ROOT / "spec" / "requirements.toml").read_text(encoding="utf-8"))


def first_release(changelog: str) -> str:
    """Newest release of a changelog, the part that is not released yet left out."""
    headings = re.findall(r"^## \[?(\d+\.\d+\.\d+)\]?", changelog, re.MULTILINE)
    return headings[0] if headings else ""


def test_programs_carry_the_version_of_the_registry() -> None:
    for name in ("pyproject.toml", "validator/pyproject.toml"):
        project = tomllib.loads((ROOT / name).read_text(encoding="utf-8"))["project"]
        assert project["version"] == REGISTRY["version"], name
    assert tilesnav_ref.__version__ == REGISTRY["version"]
    assert tilesnav_validator.__version__ == REGISTRY["version"]


def test_the_specification_carries_the_version_of_the_registry() -> None:
    title = (ROOT / "spec" / "README.md").read_text(encoding="utf-8").splitlines()[0]
    assert title == f"# {REGISTRY['extension']} {REGISTRY['version']}"
    changelog = (ROOT / "spec" / "CHANGELOG.md").read_text(encoding="utf-8")
    assert first_release(changelog) == REGISTRY["version"]
    assert REGISTRY["base_uri"] == "urn:3dtiles-nav:" + REGISTRY["version"].rpartition(".")[0]


def test_the_changelog_does_not_run_ahead_of_the_registry() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    released = first_release(changelog)
    assert released in {"", REGISTRY["version"]}
    assert released or "## [Unreleased]" in changelog


def test_no_requirement_is_newer_than_the_registry() -> None:
    version = tuple(map(int, REGISTRY["version"].split(".")))
    assert [
        name for name, row in registry().items() if tuple(map(int, row["since"].split("."))) > version
    ] == []


def test_cases_are_written_for_this_version() -> None:
    tileset = json.loads((CASES / "valid" / "ring" / "tileset.json").read_text(encoding="utf-8"))
    assert tileset["extensions"]["3DTILES_nav"]["version"] == REGISTRY["version"]
