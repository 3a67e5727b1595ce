"""What every program that writes a committed file does at its end."""

from __future__ import annotations

import sys
from pathlib import Path


def finish(target: Path, text: str, arguments: list[str]) -> int:
    """Write a file, or with --check compare it; return the exit status.

    Parameters
    ----------
    target : Path
        The committed file.
    text : str
        What it holds when it is up to date.
    arguments : list of str
        Arguments of the command line.
    """
    if arguments not in ([], ["--check"]):
        sys.stderr.write("usage: [--check]\n")
        return 2
    if not arguments:
        target.write_text(text, encoding="utf-8", newline="\n")
        return 0
    if target.is_file() and target.read_bytes() == text.encode():
        return 0
    sys.stderr.write(f"{target.name} is not what would be written now\n")
    return 1
