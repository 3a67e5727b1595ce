"""Settings of planar feature detection."""

from __future__ import annotations

import math
from dataclasses import dataclass

FEWEST_POINTS = 6
"""Three points always have a plane; fewer than this many say nothing about its noise."""


@dataclass(frozen=True)
class PlaneSettings:
    """How planar features are found. A length of 0 is taken from the data."""

    inlier_distance: float = 0.0
    """Greatest distance of an inlier from its plane, m; 0: four standard deviations of the noise that the
    cloud shows."""
    normal_sigmas: float = 4.0
    """Greatest angle between the normal at a point and that of the feature it joins, in standard deviations
    of the former."""
    min_points: int = 30
    """Fewest inliers of a feature; 6 or more."""
    radius: float = 0.0
    """Of the neighbourhood of a point, m, and the gap that a feature grows across; 0: such that half of the
    points have 16 neighbours, or more where the normals would be too noisy."""
    seed: int = 0
    """Of the random samples. The same seed gives the same features, on any number of threads."""
    threads: int = 0
    """0: one for each usable processor."""

    def __post_init__(self) -> None:
        """Check every setting: ValueError naming it."""
        for name in ("inlier_distance", "radius"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise ValueError(f"setting {name}: found {value}; allowed: finite, 0 or greater")
        if not (math.isfinite(self.normal_sigmas) and self.normal_sigmas > 0):
            raise ValueError(f"setting normal_sigmas: found {self.normal_sigmas}; allowed: greater than 0")
        if self.min_points < FEWEST_POINTS:
            raise ValueError(
                f"setting min_points: found {self.min_points}; allowed: {FEWEST_POINTS} or greater"
            )
        if not 0 <= self.seed < 1 << 31:
            raise ValueError(f"setting seed: found {self.seed}; allowed: 0 to {2**31 - 1}")
        if self.threads < 0:
            raise ValueError(f"setting threads: found {self.threads}; allowed: 0 or greater")
