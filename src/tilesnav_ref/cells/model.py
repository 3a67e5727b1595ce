"""Navigation cells and the portals between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

KIND_AERIAL = 0
KIND_GROUND = 1


@dataclass(frozen=True)
class CellComplex:
    """Box cells on the grid and their portal graph.

    Notes
    -----
    Directed portals of cell i are ``portal_offsets[i]:portal_offsets[i + 1]``, with ascending targets. Both
    directions of a portal have the same polygon index. Polygons are rectangles of four vertices in order.
    """

    lower: NDArray[np.int64]
    """(N, 3) grid coordinates, nav frame."""
    upper: NDArray[np.int64]
    """(N, 3) grid coordinates, greater than lower in every component."""
    kinds: NDArray[np.uint8]
    """(N,) KIND_AERIAL or KIND_GROUND."""
    portal_offsets: NDArray[np.int64]
    """(N + 1,) CSR offsets of the directed portals."""
    portal_targets: NDArray[np.int64]
    """(M,) cell behind each directed portal."""
    portal_polygons: NDArray[np.int64]
    """(M,) index into polygons."""
    polygons: NDArray[np.int64]
    """(Q, 4, 3) grid coordinates."""
    clearance: int
    """Grid steps by which every plane can move outwards without meeting a face."""
    coverage: float
    """Share of the reachable free volume beyond the clearance that the cells cover, 0 to 1, measured by
    random points."""

    @property
    def count(self) -> int:
        """Number of cells."""
        return len(self.lower)

    @property
    def portal_count(self) -> int:
        """Number of directed portals."""
        return len(self.portal_targets)
