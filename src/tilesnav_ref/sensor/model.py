"""What the simulated scanner gives: scans with the truth about each point."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NO_FACE = -1
"""Face and object of a point that no face gave: an outlier."""


@dataclass(frozen=True)
class Returns:
    """Points of one or more scans, in the order in which they were measured.

    Attributes
    ----------
    points : (N, 3) float64
        As measured, with the true pose of the scanner at the time of each; metres, nav frame.
    raw : (N, 3) float32
        The same in the frame of the scanner at the time of each; metres.
    times : (N,) float64
        Seconds since the route began.
    scans : (N,) int32
        Number of the turn.
    beams : (N,) uint8
        Number of the beam, the lowest first.
    faces : (N,) int32
        Face of the scene that returned the ray; `NO_FACE` for an outlier.
    objects : (N,) int32
        Its object; `NO_FACE` for an outlier.
    true_ranges : (N,) float64
        Distance of that face along the ray without noise, metres; for an outlier that of the face that the
        ray met.
    places : (N, 3) float64
        Where the scanner was when it measured each; metres, nav frame.
    """

    points: NDArray[np.float64]
    raw: NDArray[np.float32]
    times: NDArray[np.float64]
    scans: NDArray[np.int32]
    beams: NDArray[np.uint8]
    faces: NDArray[np.int32]
    objects: NDArray[np.int32]
    true_ranges: NDArray[np.float64]
    places: NDArray[np.float64]

    def __len__(self) -> int:
        """Count of points."""
        return len(self.points)


@dataclass(frozen=True)
class Scan:
    """One turn of the scanner."""

    number: int
    """Turns since the route began."""
    time: float
    """Seconds since the route began, of its first firing."""
    nav_from_scanner: NDArray[np.float64]
    """(4, 4) true pose at that time."""
    returns: Returns

    def points_in_scanner(self) -> NDArray[np.float64]:
        """(N, 3) float64 points in the frame of the scanner at the first firing, as if it had stood still."""
        return self.in_scanner(self.returns.points)

    def in_scanner(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) float64 places of the nav frame in the frame of the scanner at the first firing."""
        rotation, place = self.nav_from_scanner[:3, :3], self.nav_from_scanner[:3, 3]
        return np.asarray((points - place) @ rotation)


def join(scans: Iterable[Scan]) -> Returns:
    """Put the points of scans one after the other."""
    parts = [scan.returns for scan in scans]
    names = tuple(Returns.__dataclass_fields__)
    return Returns(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in names})
