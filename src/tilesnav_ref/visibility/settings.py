"""Settings of the visibility stage."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class VisibilitySettings:
    """How much work is spent on each cell; every setting gives a conservative result.

    More rays and larger budgets only make the result tighter.
    """

    rays: int = 100_000
    """Uniform rays of a cell that look for visible faces."""
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
    block_cells: int = 4
    """Cells that are treated together first."""
