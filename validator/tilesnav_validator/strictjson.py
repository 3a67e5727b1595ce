"""JSON from files that nobody vouches for."""

from __future__ import annotations

import json
import math
from typing import Any

MAX_BYTES = 64 * 2**20
"""Largest JSON text that is parsed; the specification allows readers this bound."""


MAX_DIGITS = 300
"""Longest integer in characters; longer ones overflow float64 wherever they are used."""


class JsonError(ValueError):
    """The text is not JSON that every reader understands alike."""


def _refuse_constant(name: str) -> float:
    raise JsonError(f"{name} is not a JSON number")


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise JsonError(f"the number {text[:40]} does not fit a float64")
    return value


def _bounded(text: str) -> int:
    if len(text) > MAX_DIGITS:
        raise JsonError(f"an integer of {len(text)} digits")
    return int(text)


def _unique(members: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object; of two members with one name, readers disagree about which one counts."""
    found = dict(members)
    if len(found) < len(members):
        names = [name for name, _ in members]
        twice = next(name for name in names if names.count(name) > 1)
        raise JsonError(f"the member name {twice[:100]!r} stands twice in an object")
    return found


def parse(data: bytes) -> Any:
    """Parse UTF-8 JSON; refuse NaN, infinities, overflow, names given twice, excessive depth and length.

    Raises
    ------
    JsonError
        With the reason, and the position where there is one.
    """
    if len(data) > MAX_BYTES:
        raise JsonError(f"{len(data)} bytes of JSON, more than {MAX_BYTES}")
    try:
        return json.loads(
            data.decode("utf-8"),
            object_pairs_hook=_unique,
            parse_constant=_refuse_constant,
            parse_float=_finite,
            parse_int=_bounded,
        )
    except RecursionError:
        raise JsonError("nested too deep") from None
    except JsonError:
        raise
    except ValueError as error:  # includes UnicodeDecodeError
        raise JsonError(str(error)) from None


def parse_view(data: memoryview, start: int, stop: int) -> Any:
    """``parse`` of a part of a memory-mapped file; the length is checked before anything is copied."""
    if stop - start > MAX_BYTES:
        raise JsonError(f"{stop - start} bytes of JSON, more than {MAX_BYTES}")
    return parse(bytes(data[start:stop]))
