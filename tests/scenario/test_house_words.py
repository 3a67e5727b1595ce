"""What the pages say about the repository is so."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted(
    path
    for path in (
        *ROOT.glob("*.md"),
        *ROOT.glob("*/README.md"),
        *ROOT.glob("docs/**/*.md"),
        *ROOT.glob("spec/*.md"),
    )
    if "site" not in path.relative_to(ROOT).parts
)
VERBS = ("setup", "demo", "test", "check", "lint", "types", "cover", "bless", "bench", "site")
DECISION_HEADINGS = ("## Context", "## Choice", "## Consequences")


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def without_code(text: str) -> str:
    return re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.DOTALL)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_relative_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)\s]+)\)", without_code(page.read_text(encoding="utf-8")))
    targets = [link.partition("#")[0] for link in links if not re.match(r"[a-z]+:|#", link)]
    assert [target for target in targets if not (page.parent / target).exists()] == []


def test_verbs_of_the_makefile_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert [verb for verb in VERBS if not re.search(rf"^{verb}:", makefile, re.MULTILINE)] == []


@pytest.mark.parametrize("page", [ROOT / "README.md", ROOT / "CONTRIBUTING.md"], ids=name_of)
def test_named_verbs_are_in_the_makefile(page: Path) -> None:
    named = set(re.findall(r"(?:^|`|\s{4})make ([a-z]+)", page.read_text(encoding="utf-8"), re.MULTILINE))
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    assert named, "the page names no verb; has its form changed?"
    assert named <= targets


def test_folders_of_the_readme_exist() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    layout = readme.partition("## Layout")[2].partition("\n## ")[0]
    folders = re.findall(r"^\| \[?`?([\w./]+)/`?", layout, re.MULTILINE)
    assert len(folders) >= 7
    assert [folder for folder in folders if not (ROOT / folder).is_dir()] == []


def test_decisions_are_numbered_without_gaps() -> None:
    pages = sorted(ROOT.glob("docs/decisions/[0-9]*.md"))
    numbers = [int(page.name[:4]) for page in pages]
    assert numbers == list(range(1, len(pages) + 1))
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert text.startswith(f"# {page.name[:4]} "), page.name
        assert [heading for heading in DECISION_HEADINGS if heading not in text] == [], page.name


def test_the_npm_lock_holds_for_any_registry() -> None:
    lock = json.loads((ROOT / "tests/external/package-lock.json").read_text(encoding="utf-8"))
    packages = {name: package for name, package in lock["packages"].items() if name}
    assert packages
    assert [name for name, package in packages.items() if "resolved" in package] == []
    assert [name for name, package in packages.items() if "integrity" not in package] == []


def test_direct_npm_packages_are_pinned_exactly() -> None:
    package = json.loads((ROOT / "tests/external/package.json").read_text(encoding="utf-8"))
    loose = {
        name: version
        for name, version in package["dependencies"].items()
        if not re.match(r"\d+\.\d+\.\d+", version)
    }
    assert loose == {}


@pytest.mark.parametrize("script", [".ci/run", ".ci/wheels_alone"])
def test_shell_scripts_parse(script: str) -> None:
    done = subprocess.run(["bash", "-n", ROOT / script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
