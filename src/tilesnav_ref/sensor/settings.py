"""What the simulated scanner is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.sensor.errors import require

MOST_BEAMS = 256
"""The number of a beam is a byte in every file."""


@dataclass(frozen=True)
class ScannerSettings:
    """A spinning scanner; the defaults are those of the data sheet of the Velodyne VLP-16.

    References
    ----------
    Velodyne LiDAR, VLP-16 user manual, 63-9243 rev. D: 16 beams 2 degrees apart, 0.1 to 0.4 degrees of
    azimuth a firing, 5 to 20 turns a second, 100 m, typical accuracy 3 cm (1 sigma).
    """

    beams: int = 16
    """Beams, evenly spaced from the lowest to the highest."""
    lowest: float = -15.0
    """Elevation of the lowest beam, degrees."""
    highest: float = 15.0
    """Elevation of the highest beam, degrees."""
    azimuth_step: float = 0.2
    """Degrees from one firing of all beams to the next; it divides 360."""
    rotation_rate: float = 10.0
    """Turns a second; a scan is one turn."""
    min_range: float = 0.5
    """Metres; nothing nearer is returned."""
    max_range: float = 100.0
    """Metres; nothing farther is returned."""
    range_noise: float = 0.03
    """Standard deviation of a range, metres."""
    dropouts: float = 0.02
    """Share of the returns that are lost at random."""
    outliers: float = 0.0
    """Share of the returns that lie anywhere between least and greatest range along their ray."""
    pitch: float = 0.0
    """Degrees by which the mount tilts the scanner forwards and down."""
    roll: float = 0.0
    """Degrees by which the mount tilts the scanner to its right; at 90 the beams sweep the vertical plane
    across the way."""
    every: int = 1
    """Of so many scans the first is kept."""
    seed: int = 0
    """Start of all random numbers; each scan has its own, so that none depends on another."""

    def __post_init__(self) -> None:
        """Check every setting.

        Raises
        ------
        ScanError
            Naming the setting.
        """
        require(1 <= self.beams <= MOST_BEAMS, "beams", self.beams, f"1 to {MOST_BEAMS}")
        low, high = self.lowest, self.highest
        allowed = "-90 < lowest <= highest < 90 degrees"
        require(-90 < low <= high < 90, "lowest, highest", (low, high), allowed)
        require(self.beams > 1 or low == high, "beams", self.beams, "2 or more where lowest is not highest")
        require(self._divides(), "azimuth_step", self.azimuth_step, "0.01 to 360 degrees, a part of 360")
        rate = self.rotation_rate
        require(0 < rate <= 1000, "rotation_rate", rate, "more than 0 to 1000 turns a second")
        reach = (self.min_range, self.max_range)
        require(
            0 <= reach[0] < reach[1] < math.inf, "min_range, max_range", reach, "0 <= min_range < max_range"
        )
        require(0 <= self.range_noise < math.inf, "range_noise", self.range_noise, "0 or more metres")
        require(0 <= self.dropouts < 1, "dropouts", self.dropouts, "0 to less than 1")
        require(0 <= self.outliers < 1, "outliers", self.outliers, "0 to less than 1")
        require(-180 <= self.pitch <= 180, "pitch", self.pitch, "-180 to 180 degrees")
        require(-180 <= self.roll <= 180, "roll", self.roll, "-180 to 180 degrees")
        require(self.every >= 1, "every", self.every, "1 or more")
        require(self.seed >= 0, "seed", self.seed, "0 or more")

    def _divides(self) -> bool:
        if not 0.01 <= self.azimuth_step <= 360.0:
            return False
        parts = 360.0 / self.azimuth_step
        return abs(parts - round(parts)) < 1e-6  # 360 / 0.2 and its like are not whole in binary

    @property
    def firings(self) -> int:
        """Firings of a turn."""
        return round(360.0 / self.azimuth_step)

    def directions(self) -> NDArray[np.float64]:
        """(firings, beams, 3) float64 unit vectors of the rays of a turn in the frame of the scanner.

        Notes
        -----
        x forwards, y left, z up as of REP 103; the first firing looks forwards, the turn goes left.
        """
        azimuth = np.radians(np.arange(self.firings) * 360.0 / self.firings)[:, None]
        height = np.radians(np.linspace(self.lowest, self.highest, self.beams))[None, :]
        level = np.cos(height)
        z = np.broadcast_to(np.sin(height), (self.firings, self.beams))
        return np.stack((np.cos(azimuth) * level, np.sin(azimuth) * level, z), axis=2)
