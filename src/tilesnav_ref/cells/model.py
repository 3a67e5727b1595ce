"""Navigation cells and the portals between them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

KIND_AERIAL = 0
KIND_GROUND = 1


def box_corners(lower: NDArray[np.int64], upper: NDArray[np.int64]) -> NDArray[np.int64]:
    """Corners of boxes (N, 3), (N, 3) as (N, 8, 3); corner i is on the upper side of axis k where bit k of i
    is set.

    Examples
    --------
    >>> box_corners(np.zeros((1, 3), np.int64), np.array([[1, 2, 3]]))[0, 5].tolist()
    [1, 0, 3]
    """
    upper_side = (np.arange(8)[:, None] >> np.arange(3)) & 1 > 0
    return np.where(upper_side, upper[:, None], lower[:, None])


@dataclass(frozen=True)
class HeightBand:
    """Coverage of a band of heights above the ground."""

    lower: float
    """m."""
    upper: float
    """m; infinity for the last."""
    points: int
    """Random points that were free, reachable and in the band."""
    covered: int
    """Those of them that lie in a cell."""


@dataclass(frozen=True)
class CellComplex:
    """Cells with corners on the grid, and their portal graph.

    Notes
    -----
    A cell is a prism over a trapezoid, or a box: there are axes u, v and w such that the coordinates u and w
    of a corner depend on nothing but its side of that axis, and v on its sides of u and of v. So the sides
    across u and w are normal to them, and the two sides across v may slant along u.

    Directed portals of cell i are ``portal_offsets[i]:portal_offsets[i + 1]``, with ascending targets. Both
    directions of a portal have the same polygon index. Vertices of polygon i are
    ``polygon_vertices[polygon_offsets[i]:polygon_offsets[i + 1]]``, three to eight in order; a polygon is
    convex and lies in the facets of both cells.
    """

    lower: NDArray[np.int64]
    """(N, 3) least grid coordinates, nav frame."""
    upper: NDArray[np.int64]
    """(N, 3) greatest grid coordinates, greater than lower in every component."""
    kinds: NDArray[np.uint8]
    """(N,) KIND_AERIAL or KIND_GROUND."""
    portal_offsets: NDArray[np.int64]
    """(N + 1,) CSR offsets of the directed portals."""
    portal_targets: NDArray[np.int64]
    """(M,) cell behind each directed portal."""
    portal_polygons: NDArray[np.int64]
    """(M,) polygon of each directed portal."""
    clearance: int
    """Grid steps by which every plane can move outwards without meeting a face."""
    coverage: float
    """Share of the reachable free volume beyond the clearance that the cells cover, 0 to 1, measured by
    random points."""
    polygon_offsets: NDArray[np.int64] = field(default_factory=lambda: np.zeros(1, np.int64))
    """(Q + 1,) CSR offsets of the vertices of the portals' polygons."""
    polygon_vertices: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    """(K, 3) in grid steps; whole numbers but where the side of a cell slants."""
    corners: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 8, 3), np.int64))
    """(N, 8, 3) grid coordinates; corner i is on the upper side of axis k where bit k of i is set. Without
    them the cells are boxes."""

    sector_offsets: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    """(S + 1,) cells of sector s are ``sector_offsets[s]:sector_offsets[s + 1]``; empty: one sector."""
    bands: tuple[HeightBand, ...] = ()
    """Coverage by heights above the ground."""

    def __post_init__(self) -> None:
        """Corners of boxes where none were given; ValueError when there are others than of these cells."""
        if len(self.corners) == 0:
            object.__setattr__(self, "corners", box_corners(self.lower, self.upper))
        if len(self.corners) != len(self.lower) or not (
            np.array_equal(self.corners.min(axis=1), self.lower)
            and np.array_equal(self.corners.max(axis=1), self.upper)
        ):
            raise ValueError("cells: found corners whose bounds are not lower and upper; allowed: no others")

    @property
    def count(self) -> int:
        """Number of cells."""
        return len(self.lower)

    @property
    def polygon_count(self) -> int:
        """Number of polygons."""
        return len(self.polygon_offsets) - 1

    @property
    def portal_count(self) -> int:
        """Number of directed portals."""
        return len(self.portal_targets)

    def select(self, numbers: NDArray[np.int64]) -> CellComplex:
        """Some cells (ascending numbers) and the portals between them; one sector, all polygons."""
        row = np.full(self.count, -1, np.int64)
        row[numbers] = np.arange(len(numbers))
        source = row[np.repeat(np.arange(self.count), np.diff(self.portal_offsets))]
        inside = (source >= 0) & (row[self.portal_targets] >= 0)
        offsets = np.zeros(len(numbers) + 1, np.int64)
        np.cumsum(np.bincount(source[inside], minlength=len(numbers)), out=offsets[1:])
        return replace(
            self,
            lower=self.lower[numbers],
            upper=self.upper[numbers],
            corners=self.corners[numbers],
            kinds=self.kinds[numbers],
            portal_offsets=offsets,
            portal_targets=row[self.portal_targets[inside]],
            portal_polygons=self.portal_polygons[inside],
            sector_offsets=np.zeros(0, np.int64),
        )
