"""Time and memory of a run: a side file beside the tileset, because it differs from run to run."""

from __future__ import annotations

import json
import resource
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

REPORT_NAME = "encode-report.json"

Progress = Callable[[int, int], None]
"""Called with the finished and all steps of a stage."""
StageProgress = Callable[[str, int, int], None]
"""The same with the name of the stage first."""


class Stopwatch:
    """Seconds of every stage, in the order in which they ran."""

    def __init__(self, progress: StageProgress | None = None) -> None:
        self.seconds: dict[str, float] = {}
        self._progress = progress or _ignore

    @contextmanager
    def stage(self, name: str) -> Iterator[Progress]:
        """Time a block, announce its begin and end, and yield what takes its progress."""
        started = time.perf_counter()
        self._progress(name, 0, 1)
        yield lambda done, total: self._progress(name, done, total)
        self._progress(name, 1, 1)
        self.seconds[name] = round(time.perf_counter() - started, 3)


def run_report(watch: Stopwatch) -> dict[str, Any]:
    """State what a run has taken so far.

    Returns
    -------
    dict
        ``seconds`` by stage; ``peakMemory`` of this process, ``peakMemoryChild`` of its largest child, bytes.
    """
    return {
        "comment": "Time and memory of the run that made this folder; not part of the tileset.",
        "seconds": watch.seconds,
        "peakMemory": _peak_bytes(resource.RUSAGE_SELF),
        "peakMemoryChild": _peak_bytes(resource.RUSAGE_CHILDREN),
    }


def write_report(folder: Path, report: dict[str, Any]) -> None:
    """Write the side file."""
    (folder / REPORT_NAME).write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")


def _peak_bytes(who: int) -> int:
    # Linux counts in KiB, macOS in bytes.
    return resource.getrusage(who).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def _ignore(name: str, done: int, total: int) -> None:
    """Report to nobody."""
