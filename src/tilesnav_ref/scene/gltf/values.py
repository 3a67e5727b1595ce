"""Values of a JSON document that are checked when they are taken."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError

JSON_LIMIT = 256 << 20
"""Bytes of JSON; a tree of a million tiles has less."""
LAST_ROW_ERROR = 1e-6
"""Last rows of matrices that were multiplied in float32 are this near to 0, 0, 0, 1."""


@dataclass(frozen=True)
class Value:
    """A JSON value, where it is, and the errors that name the place."""

    source: str
    """File named in errors."""
    place: str
    """Where in the file."""
    raw: Any

    def error(self, found: str, allowed: str) -> SceneError:
        """Make the error about this value."""
        return SceneError(self.source, self.place or "file", found[:200], allowed)

    def member(self, name: str) -> Value | None:
        """Give a member of this object; None when it has none of that name.

        Raises
        ------
        SceneError
            When this is no object.
        """
        if not isinstance(self.raw, dict):
            raise self.error(_shown(self.raw), "an object")
        if name not in self.raw:
            return None
        return Value(self.source, f"{self.place}.{name}" if self.place else name, self.raw[name])

    def need(self, name: str) -> Value:
        """Give a member that has to be there."""
        found = self.member(name)
        if found is None:
            raise self.error(f"no member {name!r}", f"an object with {name!r}")
        return found

    def has(self, name: str) -> bool:
        """Whether this object has a member of that name."""
        return self.member(name) is not None

    def items(self, name: str) -> list[Value]:
        """Give the elements of an array that is a member; none when it is not there."""
        found = self.member(name)
        return [] if found is None else found.elements()

    def elements(self) -> list[Value]:
        """Give the elements of this array."""
        if not isinstance(self.raw, list):
            raise self.error(_shown(self.raw), "an array")
        return [Value(self.source, f"{self.place}[{i}]", raw) for i, raw in enumerate(self.raw)]

    def integer(self, low: int, high: int) -> int:
        """Give this integer when it lies from low to high."""
        raw = self.raw
        if isinstance(raw, float) and raw.is_integer():  # 3.0 is an integer in JSON
            raw = int(raw)
        if isinstance(raw, bool) or not isinstance(raw, int) or not low <= raw <= high:
            raise self.error(_shown(self.raw), f"an integer from {low} to {high}")
        return raw

    def numbers(self, count: int) -> NDArray[np.float64]:
        """Give (count,) finite numbers."""
        raw = self.raw
        if not isinstance(raw, list) or len(raw) != count or not all(map(_is_finite, raw)):
            raise self.error(_shown(raw), f"{count} finite numbers")
        return np.array(raw, np.float64)

    def matrix(self) -> NDArray[np.float64]:
        """Give a (4, 4) affine matrix of 16 numbers by columns."""
        matrix = self.numbers(16).reshape(4, 4).T
        if np.abs(matrix[3] - (0.0, 0.0, 0.0, 1.0)).max() > LAST_ROW_ERROR:
            raise self.error(f"last row {matrix[3].tolist()}", "an affine matrix by columns, with 0, 0, 0, 1")
        matrix[3] = (0.0, 0.0, 0.0, 1.0)
        return matrix

    def text(self) -> str:
        """Give this string."""
        if not isinstance(self.raw, str):
            raise self.error(_shown(self.raw), "a string")
        return self.raw

    def one_of(self, allowed: tuple[str, ...]) -> str:
        """Give this string in upper case when it is one of those allowed; 1.0 files write lower case too."""
        found = self.text().upper()
        if found not in allowed:
            raise self.error(_shown(self.raw), ", ".join(allowed))
        return found


def integer_or(value: Value | None, default: int, high: int) -> int:
    """Give an integer from 0 to high, or the default when there is none."""
    return default if value is None else value.integer(0, high)


def parse(source: str, place: str, text: bytes) -> Value:
    """Parse a JSON object.

    Raises
    ------
    SceneError
        When the text is too long, is no JSON or no object.
    """
    if len(text) > JSON_LIMIT:
        raise SceneError(source, place or "file", f"{len(text)} bytes of JSON", f"at most {JSON_LIMIT}")
    try:
        raw = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise SceneError(source, place or "file", f"no JSON: {error}"[:200], "a JSON object") from error
    if not isinstance(raw, dict):
        raise SceneError(source, place or "file", _shown(raw), "a JSON object")
    return Value(source, place, raw)


def _is_finite(raw: Any) -> bool:
    if isinstance(raw, bool) or not isinstance(raw, int | float):
        return False
    try:
        return math.isfinite(float(raw))
    except OverflowError:
        return False


def _shown(raw: Any) -> str:
    """A value of an error message; of long ones the beginning."""
    if isinstance(raw, dict):
        return "an object"
    return repr(raw if not isinstance(raw, list) else raw[:20])[:80]
