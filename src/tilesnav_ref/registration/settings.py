"""Settings of the registration of scans, and the one error that it raises."""

from __future__ import annotations

import math
from dataclasses import dataclass


class RegistrationError(ValueError):
    """Scans that cannot be brought together.

    Parameters
    ----------
    source : str
        Scan, file or setting that is at fault.
    found : str
        What is there.
    allowed : str
        What may be there, and what the user can do.
    """

    def __init__(self, source: str, found: str, allowed: str) -> None:
        self.source = source
        self.found = found
        self.allowed = allowed
        super().__init__(f"{source}: found {found}; allowed: {allowed}")


@dataclass(frozen=True)
class RegistrationSettings:
    """How scans are brought together."""

    voxel: float = 0.25
    """Metres: edge of the voxels of which each gives one point, the mean of its points."""
    reach: float = 2.0
    """Metres between a point and its partner in the map at the start; how wrong a starting pose may be."""
    fine_reach: float = 0.5
    """Metres between partners when the scans lie nearly right."""
    map_scans: int = 5
    """Earlier scans, the nearest ones, that make the map which the next scan is aligned to."""
    links: int = 8
    """Other scans, the nearest ones, that each scan is compared with in the adjustment."""
    link_points: int = 1500
    """Points of a scan that are compared with another scan, evenly chosen."""
    rounds: int = 12
    """Rounds of the adjustment of all poses at once, at most."""
    least_overlap: float = 0.3
    """Share of the points of a scan that must have a partner within `fine_reach` in the map."""

    def __post_init__(self) -> None:
        """Check every setting.

        Raises
        ------
        RegistrationError
            Naming the setting.
        """
        _require(0.001 <= self.voxel < math.inf, "voxel", self.voxel, "0.001 or more metres")
        reach = (self.fine_reach, self.reach)
        _require(
            0 < reach[0] <= reach[1] < math.inf, "fine_reach, reach", reach, "0 < fine_reach <= reach, metres"
        )
        for name in ("map_scans", "links", "link_points"):
            _require(getattr(self, name) >= 1, name, getattr(self, name), "1 or more")
        _require(self.rounds >= 0, "rounds", self.rounds, "0 or more")
        _require(0 <= self.least_overlap <= 1, "least_overlap", self.least_overlap, "0 to 1")


def _require(holds: bool, name: str, found: object, allowed: str) -> None:
    if not holds:
        raise RegistrationError(name, repr(found), allowed)
