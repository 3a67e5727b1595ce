"""Binary and text records with named fields, as PLY and PCD have them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.clouds.model import PLACE, Chunk
from tilesnav_ref.scene.errors import SceneError

HEADER_BYTES = 1 << 16
"""Most bytes of a header."""
OPTIONAL = {
    "classes": ("classification", "scalar_classification", "class", "label"),
    "returns": ("return_number", "returnnumber", "scalar_returnnumber"),
    "return_counts": ("number_of_returns", "numberofreturns", "scalar_numberofreturns"),
    "intensities": ("intensity", "scalar_intensity", "reflectance"),
}
"""Names of fields, lower case, as writers spell them."""
TYPES: dict[str, Any] = {
    "classes": np.uint8,
    "returns": np.uint8,
    "return_counts": np.uint8,
    "intensities": np.float32,
}


def missing_library(path: Path, name: str, extra: str) -> SceneError:
    """The error for a file that needs an optional library."""
    return SceneError(str(path), "name", f"no {name}", f"{name} installed (pip install 'tilesnav[{extra}]')")


def header_lines(path: Path, file: IO[bytes], last: str) -> list[str]:
    """Lines of a header up to one that begins with a word.

    Raises
    ------
    SceneError
        When it does not end within `HEADER_BYTES`, or is no text.
    """
    lines: list[str] = []
    left = HEADER_BYTES
    while left > 0:
        line = file.readline(left)
        left -= len(line)
        if not line.endswith(b"\n"):
            break
        try:
            lines.append(line.decode("ascii", "strict" if line.isascii() else "replace").strip())
        except UnicodeDecodeError:
            break
        if lines[-1].split(" ")[0] == last:
            return lines
    raise SceneError(
        str(path), "header", f"no line {last!r} in {HEADER_BYTES - left} bytes", "a whole header"
    )


def chunk_of(fields: dict[str, NDArray[Any]]) -> Chunk:
    """Make a chunk of named columns, x, y and z among them."""
    lower = {name.lower(): column for name, column in fields.items()}
    points = np.stack([lower[axis].astype(np.float64) for axis in "xyz"], axis=1)
    found: dict[str, Any] = {}
    for part, spellings in OPTIONAL.items():
        name = next((name for name in spellings if name in lower), None)
        if name is not None:
            found[part] = as_type(lower[name], TYPES[part])
    return Chunk(points, **found, **scanner_of(lower))


def scanner_of(fields: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """What columns say of the scanner: its place, and the number of the scan; -1 where that is no number."""
    found: dict[str, NDArray[Any]] = {}
    if set(PLACE) <= fields.keys():
        found["places"] = np.stack([np.asarray(fields[name], np.float64) for name in PLACE], axis=1)
    if "scan" in fields:
        column = np.asarray(fields["scan"])
        whole = np.isfinite(column) & (np.abs(column.astype(np.float64)) < 2**53)
        found["ids"] = np.where(whole, column, -1).astype(np.int64)
    return found


def as_type(column: NDArray[Any], wanted: Any) -> NDArray[Any]:
    """Convert a column; whole numbers out of range become the nearest that fits, what is no number 0."""
    if wanted is np.float32:
        with np.errstate(over="ignore"):
            return np.asarray(column, np.float32)
    return np.asarray(np.clip(np.nan_to_num(column, nan=0.0), 0, 255), np.uint8)


def binary_chunks(path: Path, start: int, record: np.dtype[Any], count: int, size: int) -> Iterator[Chunk]:
    """Read records of fixed length from a place in a file.

    Raises
    ------
    SceneError
        When the file ends before the last record.
    """
    with path.open("rb") as file:
        file.seek(start)
        done = 0
        while done < count:
            wanted = min(size, count - done)
            rows = np.frombuffer(file.read(wanted * record.itemsize), np.uint8)
            if len(rows) < wanted * record.itemsize:
                found = f"the end of the file at point {done + len(rows) // record.itemsize} of {count}"
                raise SceneError(str(path), "points", found, "as many points as the header claims")
            table = rows.view(record)
            yield chunk_of({name: table[name] for name in record.names or ()})
            done += wanted


def text_chunks(path: Path, place: tuple[int, int | None], names: list[str], size: int) -> Iterator[Chunk]:
    """Read rows of numbers; `place` is the first byte and the number of rows, None for all there are.

    Raises
    ------
    SceneError
        When a row has another count of numbers, or something else than numbers, or rows are missing.
    """
    start, count = place
    done = 0
    with path.open("rb") as file:
        file.seek(start)
        while count is None or done < count:
            lines = _lines(path, file, size if count is None else min(size, count - done))
            if not lines:
                break
            table = _table(path, lines, len(names), done)
            yield chunk_of({name: table[:, k] for k, name in enumerate(names)})
            done += len(table)
    if count is not None and done < count:
        found = f"the end of the file at point {done} of {count}"
        raise SceneError(str(path), "points", found, "as many points as the header claims")


LINE_BYTES = 4096
"""Most bytes of a row; a file without line ends is none of points."""


def _lines(path: Path, file: IO[bytes], count: int) -> list[bytes]:
    """At most `count` rows that are neither empty nor a comment."""
    lines: list[bytes] = []
    while len(lines) < count:
        line = file.readline(LINE_BYTES)
        if not line:
            break
        if len(line) == LINE_BYTES and not line.endswith(b"\n"):
            raise SceneError(str(path), "rows", f"a row longer than {LINE_BYTES} bytes", "rows of numbers")
        text = line.strip()
        if text and not text.startswith((b"#", b"//")):
            lines.append(text)
    return lines


def _table(path: Path, lines: list[bytes], columns: int, done: int) -> NDArray[np.float64]:
    """(rows, columns) float64; commas, semicolons, tabs and blanks divide numbers."""
    clean = [line.translate(DIVIDERS) for line in lines]
    try:
        table = np.loadtxt([line.decode("ascii") for line in clean], ndmin=2, comments=None)
        if table.shape[1] == columns:
            return table
    except (ValueError, UnicodeDecodeError):
        pass
    raise _bad_row(path, clean, columns, done)


DIVIDERS = bytes.maketrans(b",;\t", b"   ")


def _bad_row(path: Path, lines: list[bytes], columns: int, done: int) -> SceneError:
    """The error that names the first row at fault."""
    for number, line in enumerate(lines):
        parts = line.split()
        try:
            sound = len([float(part) for part in parts]) == columns
        except ValueError:
            sound = False
        if not sound:
            shown = line[:60].decode("ascii", "replace")
            return SceneError(str(path), f"point {done + number}", repr(shown), f"{columns} numbers")
    return SceneError(str(path), f"points from {done}", "rows of several lengths", f"{columns} numbers each")
