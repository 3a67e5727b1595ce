"""Encoder, validator and builder of the cases share data and no code."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest
from suite import ROOT

PRINT_MODULES = """
import pkgutil, sys
import tilesnav_validator
for found in pkgutil.walk_packages(tilesnav_validator.__path__, "tilesnav_validator."):
    if not found.name.endswith("__main__"):
        __import__(found.name)
print("\\n".join(sorted(sys.modules)))
"""


def test_the_validator_loads_no_code_of_the_encoder() -> None:
    run = subprocess.run([sys.executable, "-c", PRINT_MODULES], check=True, capture_output=True, text=True)
    modules = run.stdout.split()
    assert "tilesnav_validator.runner" in modules
    assert [name for name in modules if name.partition(".")[0] == "tilesnav_ref"] == []


def imports(path: Path) -> set[str]:
    """Top-level names of what a module imports."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found.add(node.module or "")
    return {name.partition(".")[0] for name in found}


@pytest.mark.parametrize(
    ("folder", "forbidden"),
    [
        ("src/tilesnav_ref", {"tilesnav_validator", "casebuilder"}),
        ("validator/tilesnav_validator", {"tilesnav_ref", "casebuilder"}),
        (
            "conformance/casebuilder",
            {"tilesnav_ref", "tilesnav_validator", "numba", "scipy", "trimesh", "pygltflib"},
        ),
    ],
)
def test_nobody_imports_code_of_another(folder: str, forbidden: set[str]) -> None:
    modules = sorted((ROOT / folder).rglob("*.py"))
    assert modules
    assert {path.name: imports(path) & forbidden for path in modules if imports(path) & forbidden} == {}
