"""JSON that others wrote: every value is taken out with its type and range checked."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from tilesnav_ref.stream.errors import TilesetError

JSON_LIMIT = 64 << 20
"""Bytes of a JSON part or file that is parsed: the contract's bound on what a reader must accept."""

COUNT_LIMIT = 1 << 31


@dataclass(frozen=True)
class Fields:
    """A JSON object together with the place where it stands."""

    source: str
    place: str
    members: dict[str, Any]

    def error(self, name: str, found: object, allowed: str) -> TilesetError:
        """Make the error for a member."""
        return TilesetError(self.source, self._path(name), _brief(found), allowed)

    def has(self, name: str) -> bool:
        """Whether there is a member of that name."""
        return name in self.members

    def integer(self, name: str, low: int = 0, high: int = COUNT_LIMIT) -> int:
        """Return an integer from low to high, which may be written as 5.0; raises TilesetError otherwise."""
        value = self._value(name)
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise self.error(name, value, f"an integer from {low} to {high}")
        return value

    def ascending(self, name: str, below: int) -> tuple[int, ...]:
        """Return a list of ascending integers from 0 to below - 1; raises TilesetError for anything else."""
        value = self._value(name)
        if not isinstance(value, list):
            raise self.error(name, value, "an array of integers")
        items = Fields(self.source, self._path(name), {str(i): v for i, v in enumerate(value)})
        found = tuple(items.integer(str(i), 0, below - 1) for i in range(len(value)))
        if any(a >= b for a, b in pairwise(found)):
            raise self.error(name, value, "integers in strictly ascending order")
        return found

    def number(self, name: str) -> float:
        """Return a finite number; raises TilesetError for anything else."""
        return self._finite(name, self._value(name))

    def numbers(self, name: str, count: int) -> tuple[float, ...]:
        """Return a list of that many finite numbers; raises TilesetError for anything else."""
        value = self._value(name)
        if not isinstance(value, list) or len(value) != count:
            raise self.error(name, value, f"an array of {count} numbers")
        return tuple(self._finite(f"{name}[{i}]", v) for i, v in enumerate(value))

    def text(self, name: str) -> str:
        """Return a string; raises TilesetError for anything else."""
        value = self._value(name)
        if not isinstance(value, str):
            raise self.error(name, value, "a string")
        return value

    def fields(self, name: str) -> Fields:
        """Return an object; raises TilesetError for anything else."""
        return self._object(name, self._value(name))

    def list_of_fields(self, name: str) -> list[Fields]:
        """Return an array of objects; raises TilesetError for anything else."""
        value = self._value(name)
        if not isinstance(value, list):
            raise self.error(name, value, "an array")
        return [self._object(f"{name}[{i}]", v) for i, v in enumerate(value)]

    def _value(self, name: str) -> Any:
        if name not in self.members:
            raise self.error(name, "nothing", "this member is required")
        return self.members[name]

    def _finite(self, name: str, value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not _is_finite(value):
            raise self.error(name, value, "a finite number")
        return float(value)

    def _object(self, name: str, value: object) -> Fields:
        if not isinstance(value, dict):
            raise self.error(name, value, "an object")
        return Fields(self.source, self._path(name), value)

    def _path(self, name: str) -> str:
        return f"{self.place}.{name}" if self.place else name


def parse_object(data: bytes, source: str, place: str = "") -> Fields:
    """Parse a JSON object.

    Raises
    ------
    TilesetError
        When the bytes are too many, no UTF-8, no JSON (NaN and Infinity are none), nested too deep or no
        object.
    """
    where = place or "JSON"
    if len(data) > JSON_LIMIT:
        raise TilesetError(source, where, f"{len(data)} bytes", f"at most {JSON_LIMIT}")
    try:
        value = json.loads(data.decode("utf-8"), parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise TilesetError(source, where, f"no JSON ({error})", "a JSON object in UTF-8") from error
    if not isinstance(value, dict):
        raise TilesetError(source, where, _brief(value), "a JSON object")
    return Fields(source, place, value)


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is not a JSON number")


def _is_finite(value: int | float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:
        # An integer beyond the range of float64.
        return False


def _brief(value: object) -> str:
    if isinstance(value, str) and value == "nothing":
        return value
    text = json.dumps(value, ensure_ascii=True, default=str)
    return text if len(text) <= 60 else f"{text[:57]}..."
