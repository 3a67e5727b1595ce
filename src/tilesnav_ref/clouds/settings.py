"""Settings of point cloud input."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.settings import METRES_PER_UNIT

NOISE_CLASSES = (7, 18)
"""Low and high noise of the ASPRS LAS 1.4 classes."""


@dataclass(frozen=True)
class CloudSettings:
    """How files become a point cloud."""

    units: str = "auto"
    """Length unit of the file, a key of METRES_PER_UNIT; auto: as its coordinate system says, else metres."""
    classes: tuple[int, ...] = ()
    """ASPRS classes to keep, where the file has classes; none: all but `NOISE_CLASSES`."""
    region: tuple[float, float, float, float] | None = None
    """x0, y0, x1, y1 in the coordinates and units of the file; None keeps everything."""
    thin: float = 0.0
    """Edge of cubes of which the first point is kept, m; 0 keeps all points."""
    max_points: int = 100_000_000
    """Points that may be kept, about 60 bytes each; more are an error."""
    chunk_points: int = 1_000_000
    """Points that are read at once."""

    def __post_init__(self) -> None:
        """Check every setting: SceneError naming it."""
        units = ("auto", *METRES_PER_UNIT)
        _require(self.units in units, "units", self.units, ", ".join(units))
        _require(all(0 <= c <= 255 for c in self.classes), "classes", self.classes, "0 to 255 each")
        _require(0 <= self.thin < math.inf, "thin", self.thin, "0 or more metres")
        _require(1 <= self.max_points < 2**31, "max_points", self.max_points, "1 to 2^31 - 1")
        _require(1 <= self.chunk_points <= 10**8, "chunk_points", self.chunk_points, "1 to 10^8")
        if self.region is not None:
            x0, y0, x1, y1 = self.region
            ordered = all(map(math.isfinite, self.region)) and x0 < x1 and y0 < y1
            _require(ordered, "region", self.region, "finite x0,y0,x1,y1, x0 < x1, y0 < y1")


def _require(holds: bool, name: str, found: object, allowed: str) -> None:
    if not holds:
        raise SceneError("settings", name, repr(found), allowed)
