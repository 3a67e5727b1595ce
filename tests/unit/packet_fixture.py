"""Small held states for the tests of packets."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from tilesnav_ref.packet.model import ObjectFaces
from tilesnav_ref.packet.state import HeldState

MAP = bytes(range(8))
POOL = 12
"""Faces of each object of the small world."""


def world_corners(number: int, level: int, faces: Sequence[int]) -> np.ndarray:
    """(F, 3, 3) corners that depend on object, level and face alone, the least corner first."""
    places = np.array(faces, np.int64)[:, None, None]
    base = np.array([[0, 0, 0], [3, 1, 0], [1, 4, 2]]) * (1 + level)
    shift = np.array([5, -3, 2]) * places + np.array([1000 * number, 17 * level, -40 * number])
    return (base + shift).astype(np.int32)


def part(number: int, faces: Iterable[int], level: int = 0, flags: int = 0) -> ObjectFaces:
    numbers = sorted(faces)
    return ObjectFaces(
        number, level, flags, np.array(numbers, np.uint32), world_corners(number, level, numbers)
    )


def state(cell: int, *parts: ObjectFaces, exact: bool = True, name: bytes = MAP) -> HeldState:
    return HeldState(name, cell, exact, tuple(parts))
