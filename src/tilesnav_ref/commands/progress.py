"""Progress of each stage: bars on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    TaskID,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from tilesnav_ref.tileset.run_report import StageProgress

LABELS = {
    "scene": "read the scene",
    "cells": "cover the navigable space",
    "changes": "find what sees the changes",
    "visibility": "see from every cell",
    "levels": "choose levels",
    "deltas": "make deltas",
    "cloud": "read the cloud",
    "planes": "find planes",
    "scan": "scan the scene",
    "thin": "read the scans",
    "grow": "align each to the map so far",
    "adjust": "adjust all poses",
    "merge": "write the merged cloud",
    "write": "write",
    "path": "drive the route",
}

LINE_SECONDS = 30.0
"""Between two lines of a stage where the console is no terminal; a stage that takes less has none."""


@contextmanager
def stage_lines(console: Console, quiet: bool) -> Iterator[StageProgress]:
    """Show stages while they run, with the time that each will still take."""
    if quiet:
        yield lambda *_: None
    elif console.is_terminal:
        with _bars(console) as show:
            yield show
    else:
        yield PlainLines(console)


@contextmanager
def _bars(console: Console) -> Iterator[StageProgress]:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(show_speed=True),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as lines:
        tasks: dict[str, TaskID] = {}

        def show(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                tasks[stage] = lines.add_task(LABELS.get(stage, stage))
            lines.update(tasks[stage], completed=done, total=max(total, 1))

        yield show


class PlainLines:
    """Lines for a file or a pipe: share of the steps, seconds so far and seconds that the rest may take."""

    def __init__(self, console: Console, clock: Callable[[], float] = time.monotonic) -> None:
        self._console = console
        self._clock = clock
        self._stage = ""
        self._begin = self._last = 0.0

    def __call__(self, stage: str, done: int, total: int) -> None:
        """Take the progress of a stage; stages come one after the other."""
        now = self._clock()
        if stage != self._stage:
            self._stage, self._begin, self._last = stage, now, now
        if now - self._last < LINE_SECONDS or not 0 < done < total:
            return
        self._last = now
        spent = now - self._begin
        rest = spent * (total - done) / done
        text = f"{LABELS.get(stage, stage)}: {done / total:.0%}, {spent:.0f} s, about {rest:.0f} s more"
        self._console.print(text, highlight=False)
