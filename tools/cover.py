"""Branch coverage of both distributions with the kernels run as plain Python, and the floors it must keep.

Tests that need compiled kernels, npm or large data are left out (docs/decisions/0006).
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SELECTION = "not slow and not jit and not node and not realdata"

FLOORS = {"tilesnav_validator": 0, "tilesnav_ref": 0}
"""Percent that has been reached, rounded down. The aims are 100 and 95."""


def run(*arguments: str) -> int:
    """Run a module of this environment with the kernels not compiled; return its exit status."""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    return subprocess.run(
        [sys.executable, "-m", *arguments], cwd=ROOT, env=environment, check=False
    ).returncode


def main() -> int:
    """Measure, report each distribution, and fail where one is below its floor."""
    (ROOT / "build" / "coverage").mkdir(parents=True, exist_ok=True)
    if run("pytest", "-m", SELECTION, "--cov", "--cov-report=") != 0:
        return 1
    failed = 0
    for package, floor in FLOORS.items():
        print(f"\n{package}: at least {floor} %", flush=True)
        failed |= run("coverage", "report", f"--include=*/{package}/*", f"--fail-under={floor}")
    return int(failed != 0)


if __name__ == "__main__":
    sys.exit(main())
