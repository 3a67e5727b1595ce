"""Text files with a point a row: x, y, z and more columns."""

from __future__ import annotations

from pathlib import Path

from tilesnav_ref.clouds.model import CloudFile
from tilesnav_ref.clouds.records import DIVIDERS, LINE_BYTES, text_chunks
from tilesnav_ref.scene.errors import SceneError

COLUMNS_MAX = 100


def open_text(path: Path, size: int) -> CloudFile:
    """Look at the first row of a text file.

    A first row with the names x, y and z among others names the columns. Without it the first three are x, y
    and z, and a fourth is the intensity.

    Raises
    ------
    SceneError
        When the first row is neither names nor three or more numbers.
    """
    with path.open("rb") as file:
        start = 0
        words: list[str] = []
        numbers = None
        for line in iter(lambda: file.readline(LINE_BYTES), b""):
            text = line.strip().lstrip(b"/# ").decode("utf-8", "replace")
            words = [word.strip('"') for word in text.encode().translate(DIVIDERS).decode().split()]
            numbers = _numbers(words)
            if {"x", "y", "z"} <= {word.lower() for word in words} and len(words) <= COLUMNS_MAX:
                return CloudFile(str(path), None, text_chunks(path, (file.tell(), None), words, size))
            if words and not line.lstrip().startswith((b"#", b"//")):
                break
            start = file.tell()
    if numbers is None or not 3 <= len(numbers) <= COLUMNS_MAX:
        raise SceneError(str(path), "first row", repr(" ".join(words)[:60]), "x y z, as names or numbers")
    names = ["x", "y", "z", "intensity", *(f"column {k}" for k in range(4, len(numbers)))]
    return CloudFile(str(path), None, text_chunks(path, (start, None), names[: len(numbers)], size))


def _numbers(words: list[str]) -> list[float] | None:
    try:
        return [float(word) for word in words]
    except ValueError:
        return None
