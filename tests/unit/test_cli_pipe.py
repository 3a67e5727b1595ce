"""A reader of standard output that has seen enough, such as `head`, is no error."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

CASE = Path(__file__).resolve().parents[2] / "conformance" / "cases" / "valid" / "one-cell"


def to_closed_pipe(*arguments: str) -> tuple[int, str]:
    """Exit status and standard error of a command whose standard output nobody reads."""
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "tilesnav_ref.cli", *arguments]
    done = subprocess.run(command, check=False, stdout=writer, stderr=subprocess.PIPE, text=True, timeout=120)
    os.close(writer)
    return done.returncode, done.stderr


@pytest.mark.parametrize("options", [(), ("--json",)], ids=["tables", "json"])
def test_info(options: tuple[str, ...]) -> None:
    assert to_closed_pipe("info", str(CASE), *options) == (0, "")


def test_sample(tmp_path: Path) -> None:
    assert to_closed_pipe("sample", str(tmp_path / "town.ply")) == (0, "")
    assert (tmp_path / "town.ply").stat().st_size > 0
