"""How many threads a stage runs on."""

from __future__ import annotations

import os


def usable_processors() -> int:
    """Processors that this process may use; all of them where the system does not say."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def thread_count(threads: int) -> int:
    """Return the number of threads that a setting stands for.

    Parameters
    ----------
    threads
        0: one for each usable processor.

    Raises
    ------
    ValueError
        When it is negative.
    """
    if threads < 0:
        raise ValueError(f"threads is {threads}; allowed: 0 or greater")
    return threads or usable_processors()
