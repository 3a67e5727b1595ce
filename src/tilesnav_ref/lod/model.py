"""Level codes as the later stages use them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class LodSettings:
    """The scale of level codes: code = clamp(floor(log(reference / L) / log(base)), 0, level_count - 1)."""

    reference: float = 1.0
    """L of the upper end of code 0, 1/m."""
    base: float = 2.0
    """Ratio of L between two codes."""
    level_count: int = 16
    """Number of codes."""


@dataclass(frozen=True)
class LodTable:
    """Visible objects of every cell with their level codes; objects ascend within a cell."""

    settings: LodSettings
    lod_offsets: NDArray[np.int64]
    """(N + 1,)."""
    lod_objects: NDArray[np.uint32]
    """(Q,) object numbers."""
    lod_codes: NDArray[np.uint8]
    """(Q,) level codes."""
