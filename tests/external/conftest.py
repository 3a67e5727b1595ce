"""The programs of others, as a callable: ``judge("script.mjs", argument, ...)`` gives what it printed."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
INSTALLER = ROOT / "tools" / "external_judges.py"
LIMIT_SECONDS = 300

Judge = Callable[..., str]


@pytest.fixture(scope="session")
def judge() -> Judge:
    """Run one of the scripts of this folder where the pinned packages are installed."""
    installed = subprocess.run([sys.executable, INSTALLER], capture_output=True, text=True, check=False)
    if installed.returncode == 2:
        pytest.skip(installed.stderr.strip())
    assert installed.returncode == 0, installed.stderr
    folder = installed.stdout.strip()

    def run(script: str, *arguments: str | Path) -> str:
        command = ["node", script, *map(str, arguments)]
        done = subprocess.run(
            command,
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
            timeout=LIMIT_SECONDS,
            stdin=subprocess.DEVNULL,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run
