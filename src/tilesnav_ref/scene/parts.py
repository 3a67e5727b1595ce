"""What reading a file gives: placed geometries with their names."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Part:
    """One placed geometry of a file."""

    name: str
    vertices: NDArray[np.float64]
    """(V, 3) file units, axes of the file, node transforms applied."""
    faces: NDArray[np.int64]
    """(F, 3), within range."""
    labels: tuple[str, ...] = ()
    """Names by which it can be chosen: its own, that of its mesh, that of its material if asked for."""


@dataclass(frozen=True)
class MeshFile:
    """All placed geometries of a file."""

    parts: tuple[Part, ...]
    skipped: int
    """Geometries without faces: points and lines."""
    notes: tuple[str, ...] = ()
    """Remarks for people."""
