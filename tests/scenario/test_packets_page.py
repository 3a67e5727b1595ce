"""The program on the page about packets runs and does what the page says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def test_the_program_of_the_page_runs(capsys: pytest.CaptureFixture[str]) -> None:
    page = (ROOT / "docs" / "packets.md").read_text(encoding="utf-8")
    (program,) = re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    assert "out/demo" in program
    case = ROOT / "conformance" / "cases" / "valid" / "ring"
    exec(program.replace("out/demo", str(case)), {})
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(",")[0] for line in lines] == ["cell 0: applied", "cell 1: applied", "cell 0: applied"]
