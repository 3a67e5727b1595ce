"""Files that a program writes are what it writes now."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from suite import ROOT

GENERATORS = (
    "conformance/build_cases.py",
    "tools/property_reference.py",
    "tools/annex_a.py",
    "tools/bundle_schema.py",
)
WRITES = {
    "conformance/build_cases.py": "conformance/cases/valid/ring/tileset.json",
    "tools/property_reference.py": "spec/property_reference.md",
    "tools/annex_a.py": "spec/annex_a.md",
    "tools/bundle_schema.py": "schema/3DTILES_nav.bundle.json",
}


def run(program: Path, *arguments: str) -> int:
    return subprocess.run([sys.executable, program, *arguments], check=False, capture_output=True).returncode


@pytest.mark.parametrize("program", GENERATORS)
def test_committed_files_are_up_to_date(program: str) -> None:
    assert run(ROOT / program, "--check") == 0


@pytest.mark.parametrize("program", GENERATORS)
def test_check_notices_a_change_and_the_program_mends_it(program: str, tmp_path: Path) -> None:
    for folder in ("conformance", "schema", "spec", "tools"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    written = tmp_path / WRITES[program]
    before = written.read_bytes()
    written.write_bytes(before + b"\n")
    assert run(tmp_path / program, "--check") == 1
    assert run(tmp_path / program) == 0
    assert written.read_bytes() == before
