"""What a vehicle holds of an object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class ObjectFaces:
    """Some faces of an object at one level."""

    object: int
    level: int
    flags: int
    """Bit 0: porous; bit 1: one-sided."""
    faces: NDArray[np.uint32]
    """(F,) ascending indices within the object at that level."""
    corners: NDArray[np.int32]
    """(F, 3, 3) in grid steps, nav frame; the lexicographically smallest corner of a face comes first."""
