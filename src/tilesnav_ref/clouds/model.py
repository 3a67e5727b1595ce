"""Point clouds, whole and in pieces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

PLACE = ("scanner_x", "scanner_y", "scanner_z")
"""Fields that say where the scanner was for a point, in the coordinates of the points."""


class Chunk(NamedTuple):
    """Some points of a file, in its coordinates and units; None for what the file does not have."""

    points: NDArray[np.float64]
    """(n, 3)."""
    classes: NDArray[np.uint8] | None = None
    returns: NDArray[np.uint8] | None = None
    return_counts: NDArray[np.uint8] | None = None
    intensities: NDArray[np.float32] | None = None
    scans: NDArray[np.int32] | None = None
    """Place of each point's scan in the scan origins."""
    places: NDArray[np.float64] | None = None
    """(n, 3) where the scanner was for each point."""
    ids: NDArray[np.int64] | None = None
    """Number of the scan that a file gives a point, whatever it counts."""

    def kept(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> Chunk:
        """Some of the points."""
        parts: list[Any] = [None if part is None else part[chosen] for part in self]
        return Chunk(*parts)

    def moved(self, scale: float, by: NDArray[np.float64]) -> Chunk:
        """The same with all coordinates scaled, then shifted by a vector (3,)."""
        places = None if self.places is None else self.places * scale + by
        return self._replace(points=self.points * scale + by, places=places)


@dataclass(frozen=True)
class CloudFile:
    """A file whose header has been read.

    Attributes
    ----------
    source : str
        Named in errors.
    claimed : int | None
        Points that the header claims.
    chunks : iterator of Chunk
        Reads the points, once.
    crs : str | None
        Coordinate system as WKT or a name that pyproj knows.
    metres_per_unit : float | None
        As the coordinate system says; not a number where there is one that could not be read.
    scan_origins : (S, 3) float64 | None
        In the coordinates and units of the file.
    """

    source: str
    claimed: int | None
    chunks: Iterator[Chunk]
    crs: str | None = None
    metres_per_unit: float | None = None
    scan_origins: NDArray[np.float64] | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class PointCloud:
    """Points in metres around a local origin; None for what no file has.

    Attributes
    ----------
    points : (N, 3) float64
        Metres, z up, finite: coordinates of the file times `metres_per_unit`, less `origin`.
    origin : (3,) float64
        Metres; a multiple of 100 m, so that no digit of the coordinates is lost.
    classes, returns, return_counts : (N,) uint8 | None
        ASPRS class, number of the return and returns of the pulse; 0 where one of several files has none.
    intensities : (N,) float32 | None
        In the unit of the file.
    scan_origins : (S, 3) float64 | None
        Where the scanner stood, metres, in the frame of `points`.
    scans : (N,) int32 | None
        Scan of each point, where there are scan origins.
    places : (N, 3) float64 | None
        Where the scanner was for each point, metres, in the frame of `points`.
    ids : (N,) int64 | None
        Number of the scan that the file gives each point.
    crs : str | None
        Coordinate system of the file.
    notes : tuple[str, ...]
        What was left out or assumed.
    """

    points: NDArray[np.float64]
    origin: NDArray[np.float64]
    metres_per_unit: float
    classes: NDArray[np.uint8] | None = None
    returns: NDArray[np.uint8] | None = None
    return_counts: NDArray[np.uint8] | None = None
    intensities: NDArray[np.float32] | None = None
    scan_origins: NDArray[np.float64] | None = None
    scans: NDArray[np.int32] | None = None
    places: NDArray[np.float64] | None = None
    ids: NDArray[np.int64] | None = None
    crs: str | None = None
    notes: tuple[str, ...] = field(default=())
