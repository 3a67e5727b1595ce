"""Settings of the visibility stage."""

from __future__ import annotations

import math
from dataclasses import dataclass

LIMITS = {"rays": 100_000_000, "aimed_rays": 1000, "depth": 1000, "occluder_faces": 1_000_000, "pairs": 2**40}
"""Largest values of settings that memory is taken for."""


@dataclass(frozen=True)
class VisibilitySettings:
    """How much work is spent on each cell; every setting gives a conservative result.

    More rays and larger budgets only make the result tighter.
    """

    rays: int = 10_000
    """Uniform lines through points of a cell that look for visible faces, for all cells that they cross."""
    aimed_rays: int = 8
    """Lines aimed at each face next to what is seen, in each round."""
    aimed_rounds: int = 4
    """Rounds of aimed lines."""
    seed: int = 1
    """Start of all random numbers."""
    threads: int = 0
    """Threads; 0 means one for each processor."""
    attempts: int = 256
    """Pairs of cell part and face part that are tried for one face."""
    depth: int = 20
    """Cuts above such a pair."""
    leaf_segments: int = 256
    """Random segments tried in a pair that could not be decided."""
    occluder_faces: int = 128
    """Faces in one occluder."""
    block_cells: int = 128
    """Cells that are treated together first."""
    pairs: int = 2**28
    """Pairs of a cell and a face under survey at a time; each takes two bytes of memory."""
    max_range: float | None = None
    """Metres; a face is visible only from nearer than this. None: from any distance."""

    certificates: bool = False
    """Whether the proofs that faces are hidden are kept, to be written."""

    def __post_init__(self) -> None:
        """Refuse what no work can be done with: ValueError with setting, found and allowed values."""
        least = {"occluder_faces": 1, "block_cells": 1, "pairs": 1}
        if self.max_range is not None and not 0 < self.max_range < math.inf:
            raise ValueError(
                f"visibility setting max_range: found {self.max_range}; allowed: metres greater than 0"
            )
        for name, value in vars(self).items():
            if name == "max_range":
                continue
            low = least.get(name, 0)
            high = LIMITS.get(name, 2**31 - 1)
            if not low <= value <= high:
                raise ValueError(f"visibility setting {name}: found {value}; allowed: {low} to {high}")
