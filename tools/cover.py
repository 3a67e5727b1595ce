"""Branch coverage of both distributions, and the floors that it must keep.

The validator has no compiled kernels. Those of the encoder run as plain Python (docs/decisions/0006). That
is slow: tests with the markers slow, jit, node and realdata are left out.
"""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SELECTION = "not slow and not jit and not node and not realdata"


@dataclass(frozen=True)
class Measure:
    """One distribution, the tests that are its measure, and the least percent that is accepted."""

    package: str
    tests: tuple[str, ...]
    floor: int


JUDGE_TESTS = sorted(str(path) for path in ROOT.glob("tests/unit/test_validator_*.py"))
MEASURES = (
    Measure("tilesnav_validator", (*JUDGE_TESTS, "tests/traceability"), 100),
    # The aim is 95. No floor is kept until a whole run without compiled code has been measured.
    Measure("tilesnav_ref", ("tests/unit",), 0),
)


def run(*arguments: str) -> int:
    """Run a module of this environment with the kernels not compiled; return its exit status."""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    return subprocess.run(
        [sys.executable, "-m", *arguments], cwd=ROOT, env=environment, check=False
    ).returncode


def measure(one: Measure) -> bool:
    """Run the tests of a measure and report; True when they pass and the floor is kept."""
    print(f"\n{one.package}: at least {one.floor} %", flush=True)
    if (
        run("pytest", *one.tests, "-m", SELECTION, f"--cov={one.package}", "--cov-branch", "--cov-report=")
        != 0
    ):
        return False
    return run("coverage", "report", f"--include=*/{one.package}/*", f"--fail-under={one.floor}") == 0


def main() -> int:
    """Measure both; with the name of a distribution, that one only."""
    (ROOT / "build" / "coverage").mkdir(parents=True, exist_ok=True)
    chosen = [one for one in MEASURES if one.package in sys.argv[1:]] or list(MEASURES)
    verdicts = [measure(one) for one in chosen]  # all of them, also after one that failed
    return 0 if all(verdicts) else 1


if __name__ == "__main__":
    sys.exit(main())
