"""Settings of scene input and the report on what it found."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any

from tilesnav_ref.scene.errors import SceneError

METRES_PER_UNIT = {
    "m": 1.0,
    "cm": 0.01,
    "mm": 0.001,
    "km": 1000.0,
    "in": 0.0254,
    "ft": 0.3048,
    "us-ft": 1200.0 / 3937.0,
}
"""Length units of input files. The U.S. survey foot differs from the foot by 2 parts in a million."""

UP_AXES = ("auto", "x", "y", "z")


@dataclass(frozen=True)
class SceneSettings:
    """How a file becomes a scene."""

    units: str = "m"
    """Length unit of the file: a key of METRES_PER_UNIT."""
    up: str = "auto"
    """Axis of the file that points up; auto is y for glTF, by its definition, and z for everything else."""
    crs: str | None = None
    """None: the file is local. "enu": local east, north, up around `origin`. Else a coordinate system of
    pyproj."""
    origin: tuple[float, float, float] | None = None
    """Without crs: x, y, z in file units (z up) that become zero. With crs: longitude, latitude in degrees
    and ellipsoidal height in metres (WGS 84) of the zero of the nav frame."""
    grid_exponent: int = -10
    """The grid step is 2**grid_exponent metres."""
    region: tuple[float, float, float, float] | None = None
    """x0, y0, x1, y1 in metres in the nav frame; None keeps everything."""
    region_margin: float = 25.0
    """Metres by which the region grows before components that are larger than the region are cut to it."""
    node_junctions: bool = True
    """Whether edges are split at vertices that lie exactly on them."""
    object_faces_min: int = 16
    """Objects with fewer faces are merged with their nearest neighbour."""
    object_faces_max: int = 4096
    """Objects with more faces are divided in space."""
    object_reach: float = 64.0
    """Metres: small objects that are longer than this, or farther than this from any other, stay alone."""
    content_faces: int = 8192
    """Faces that a content holds at most, unless a single object has more."""
    transparent: tuple[str, ...] = ()
    """Shell-style patterns of names of parts or materials that are seen and hide nothing."""
    one_sided: tuple[str, ...] = ()
    """Shell-style patterns of names of parts or materials that are seen from their front only."""
    terrain: tuple[str, ...] = ()
    """Shell-style patterns of names of parts or materials that are the ground; none: it is found by its
    shape."""
    max_faces: int = 20_000_000
    """Faces (and vertices) that a file may hold, instances counted; about 3 GB of memory."""

    def __post_init__(self) -> None:
        """Check every setting.

        Raises
        ------
        SceneError
            Naming the setting.
        """
        _require(self.units in METRES_PER_UNIT, "units", self.units, ", ".join(METRES_PER_UNIT))
        _require(self.up in UP_AXES, "up", self.up, ", ".join(UP_AXES))
        _require(-20 <= self.grid_exponent <= 0, "grid_exponent", self.grid_exponent, "-20 to 0")
        _require(0 <= self.region_margin < math.inf, "region_margin", self.region_margin, "0 or more metres")
        _require(0 <= self.object_reach < math.inf, "object_reach", self.object_reach, "0 or more metres")
        _require(self.object_faces_min >= 1, "object_faces_min", self.object_faces_min, "1 or more")
        least = max(2, self.object_faces_min)
        _require(
            self.object_faces_max >= least, "object_faces_max", self.object_faces_max, f"{least} or more"
        )
        _require(self.content_faces >= 1, "content_faces", self.content_faces, "1 or more")
        _require(1 <= self.max_faces < 2**31, "max_faces", self.max_faces, "1 to 2^31 - 1")
        self._check_places()

    def _check_places(self) -> None:
        if self.region is not None:
            x0, y0, x1, y1 = self.region
            finite = all(map(math.isfinite, self.region))
            _require(
                finite and x0 < x1 and y0 < y1, "region", self.region, "finite x0,y0,x1,y1, x0 < x1, y0 < y1"
            )
        if self.origin is not None:
            _require(all(map(math.isfinite, self.origin)), "origin", self.origin, "three finite numbers")
        if self.crs is not None and self.origin is not None:
            lon, lat, _ = self.origin
            within = -180 <= lon <= 180 and -90 <= lat <= 90
            _require(
                within, "origin", self.origin, "longitude -180 to 180, latitude -90 to 90, height in metres"
            )
        if self.crs is not None and self.crs.lower() == "enu":
            _require(
                self.origin is not None, "origin", None, "lon,lat,h of the zero of the file, as crs is enu"
            )
        elif self.crs is not None:
            _require(self.units == "m", "units", self.units, "m, as the coordinate system names its own unit")

    @property
    def step(self) -> float:
        """Grid step in metres."""
        return float(2.0**self.grid_exponent)


def _require(holds: bool, name: str, found: object, allowed: str) -> None:
    if not holds:
        raise SceneError("settings", name, repr(found), allowed)


@dataclass(frozen=True)
class SceneReport:
    """What was found in a file and what was done with it; lengths in metres."""

    source: str
    parts: int
    """Geometries of the file, instances counted."""
    file_vertices: int
    file_faces: int
    up: str
    """Axis that was taken to point up."""
    metres_per_unit: float
    vertices: int
    faces: int
    objects: int
    contents: int
    lower: tuple[float, float, float]
    """Least coordinates in the nav frame."""
    upper: tuple[float, float, float]
    """Greatest coordinates in the nav frame."""
    moved_max: float
    """Greatest distance by which snapping moved a vertex."""
    vertices_merged: int
    """Used vertices of the file less those after welding, before cropping."""
    degenerate_removed: int
    """Faces of zero area on the grid."""
    components: int
    """Sets of faces connected by vertices, after noding."""
    boundary_edges: int
    """Edges of one face, after noding."""
    non_manifold_edges: int
    """Edges of three or more faces, after noding."""
    doubled_faces: int
    """Faces whose three corners an earlier face has too."""
    junctions: int
    """Pairs of an edge and a vertex exactly on it, before noding."""
    faces_divided: int
    """Faces that noding has divided."""
    faces_before_noding: int
    cropped_faces: int
    """Faces that the region left out."""
    cut_components: int
    """Components larger than the region, of which only the faces near it were kept."""
    notes: tuple[str, ...] = ()
    """Remarks for people."""
    survey: dict[str, Any] | None = None
    """What became of the point cloud that the scene was made from; None where it was made from a mesh."""
    seconds: dict[str, float] = field(default_factory=dict)
    """Time by step."""

    def as_dict(self) -> dict[str, Any]:
        """All members, ready for JSON."""
        return asdict(self)
