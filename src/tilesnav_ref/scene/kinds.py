"""Which parts of a file are porous, one-sided or terrain, chosen by their names."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError

POROUS = 1
"""Bit of a kind: seen, and nothing is hidden by it."""
ONE_SIDED = 2
"""Bit of a kind: seen from its front only."""
TERRAIN = 4
"""Bit of a kind: the ground that altitudes count from."""
NAMES_SHOWN = 40
"""Names that an error lists at most."""


def part_kinds(
    labels: Sequence[tuple[str, ...]],
    transparent: tuple[str, ...],
    one_sided: tuple[str, ...],
    source: str,
    terrain: tuple[str, ...] = (),
) -> NDArray[np.int64]:
    """Kind of every part: a sum of POROUS, ONE_SIDED and TERRAIN.

    Parameters
    ----------
    labels : sequence of tuple of str
        Names of each part: its own, that of its mesh, that of its material.
    transparent, one_sided, terrain : tuple of str
        Shell-style patterns; upper and lower case differ.
    source : str
        File named in errors.

    Returns
    -------
    (P,) int64

    Raises
    ------
    SceneError
        When a pattern matches no name; it lists the names there are.
    """
    kinds = np.zeros(len(labels), np.int64)
    for setting, bit, patterns in (
        ("transparent", POROUS, transparent),
        ("one_sided", ONE_SIDED, one_sided),
        ("terrain", TERRAIN, terrain),
    ):
        for pattern in patterns:
            chosen = [any(fnmatchcase(name, pattern) for name in names) for names in labels]
            if not any(chosen):
                found = f"{pattern!r}, which no name matches"
                raise SceneError(source, setting, found, f"a pattern for one of {_list(labels)}")
            kinds[chosen] |= bit
    return kinds


def _list(labels: Sequence[tuple[str, ...]]) -> str:
    names = sorted({name for part in labels for name in part})
    rest = len(names) - NAMES_SHOWN
    shown = ", ".join(repr(name) for name in names[:NAMES_SHOWN])
    return f"{shown} and {rest} more" if rest > 0 else shown


def object_flags(face_object: NDArray[np.int32], face_kind: NDArray[np.int64], bit: int) -> NDArray[np.bool_]:
    """(K,) whether each object has a bit; empty when none has it. All faces of an object are of one kind."""
    _, first = np.unique(face_object, return_index=True)
    flags = (face_kind[first] & bit) != 0
    return flags if flags.any() else np.zeros(0, np.bool_)
