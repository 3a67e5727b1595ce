"""A line of progress for each stage."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from tilesnav_ref.tileset.run_report import StageProgress

LABELS = {
    "scene": "read the scene",
    "cells": "cover the navigable space",
    "visibility": "see from every cell",
    "levels": "choose levels",
    "deltas": "make deltas",
    "write": "write",
}


@contextmanager
def stage_lines(console: Console, quiet: bool) -> Iterator[StageProgress]:
    """Show stages while they run; nothing where the console is no terminal."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, disable=quiet or not console.is_terminal) as lines:
        tasks: dict[str, TaskID] = {}

        def show(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                tasks[stage] = lines.add_task(LABELS.get(stage, stage))
            lines.update(tasks[stage], completed=done, total=max(total, 1))

        yield show
