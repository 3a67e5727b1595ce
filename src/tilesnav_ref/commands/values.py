"""Values of options: numbers, lists of numbers, lines."""

from __future__ import annotations

import argparse
import csv
import json
import math
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

LINE_BYTES = 1 << 24
"""Most bytes of a file with the points of a line."""


def given_of(kind: type[Any], values: dict[str, Any]) -> dict[str, Any]:
    """Those of the values that were given for fields of a dataclass."""
    return {one.name: values[one.name] for one in fields(kind) if values.get(one.name) is not None}


def number(text: str) -> float:
    """A finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"found {text!r}; allowed: a finite number")
    return value


def numbers(count: int | None) -> Callable[[str], tuple[float, ...]]:
    """A given count of numbers with commas between them; None for any count."""

    def convert(text: str) -> tuple[float, ...]:
        parts = text.split(",")
        if count is not None and len(parts) != count:
            raise argparse.ArgumentTypeError(
                f"found {text!r}; allowed: {count} numbers with commas between them"
            )
        return tuple(number(part) for part in parts)

    return convert


def integer(low: int | None = None, high: int = 2**31 - 1) -> Callable[[str], int]:
    """An integer in a range."""

    def convert(text: str) -> int:
        allowed = f"an integer up to {high}" if low is None else f"an integer from {low} to {high}"
        try:
            value = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"found {text!r}; allowed: {allowed}") from None
        if value > high or (low is not None and value < low):
            raise argparse.ArgumentTypeError(f"found {text}; allowed: {allowed}")
        return value

    return convert


def sector(text: str) -> tuple[int, int]:
    """Column and row of a sector."""
    parts = text.split(",")
    if len(parts) != 2:
        raise argparse.ArgumentTypeError(f"found {text!r}; allowed: two integers with a comma between them")
    column, row = (integer(-(2**23), 2**23)(part) for part in parts)
    return column, row


def line(text: str) -> tuple[tuple[float, ...], ...]:
    """Points of a line: X,Y,Z;X,Y,Z;..., or a .json list of triples, or a .csv of three columns."""
    path = Path(text)
    if ";" in text or path.suffix.lower() not in (".json", ".csv"):
        return tuple(numbers(3)(point) for point in text.split(";") if point.strip())
    try:
        if path.stat().st_size > LINE_BYTES:
            raise argparse.ArgumentTypeError(f"{path} is larger than {LINE_BYTES} bytes")
        written = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise argparse.ArgumentTypeError(f"{path} cannot be read: {error}") from None
    rows = _json_rows(path, written) if path.suffix.lower() == ".json" else _csv_rows(written)
    for number_of, row in enumerate(rows, start=1):
        if not isinstance(row, list) or len(row) != 3:
            raise argparse.ArgumentTypeError(f"{path}, point {number_of}: found {row!r}; allowed: x, y, z")
    return tuple(numbers(3)(",".join(str(value) for value in row)) for row in rows)


def _json_rows(path: Path, written: str) -> list[Any]:
    try:
        rows = json.loads(written)
    except (json.JSONDecodeError, RecursionError) as error:
        raise argparse.ArgumentTypeError(f"{path} is no JSON: {error}") from None
    if not isinstance(rows, list):
        raise argparse.ArgumentTypeError(f"{path}: found {type(rows).__name__}; allowed: a list of points")
    return rows


def _csv_rows(written: str) -> list[Any]:
    rows = [[value.strip() for value in row] for row in csv.reader(written.splitlines()) if row]
    return rows[1:] if rows and [value.lower() for value in rows[0]] == ["x", "y", "z"] else rows
