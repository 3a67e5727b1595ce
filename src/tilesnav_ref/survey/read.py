"""Point clouds as a survey needs them: in the nav frame, with what is known about their beams."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.clouds import OPENERS, CloudSettings, PointCloud
from tilesnav_ref.scene.frame import NavFrame, to_nav
from tilesnav_ref.scene.model import COORDINATE_LIMIT
from tilesnav_ref.scene.settings import SceneSettings
from tilesnav_ref.survey.scans import read_scans

_HEADER_BYTES = 1 << 16


@dataclass(frozen=True)
class Survey:
    """Returns of a survey in the nav frame."""

    points: NDArray[np.float64]
    """(N, 3) metres."""
    frame: NavFrame
    """Where the nav frame is; its positions are the points."""
    origin: tuple[float, float, float] | None
    """What was taken off the coordinates of the file, metres, z up; None for nothing or by a coordinate
    system."""
    origins: NDArray[np.float64] | None = None
    """(N, 3) where the scanner was for each return, metres; None where the file does not say."""
    classes: NDArray[np.uint8] | None = None
    """(N,) ASPRS classes; None where the file has none."""

    def only(self, chosen: NDArray[np.bool_]) -> Survey:
        """The chosen returns (N,)."""
        origins = None if self.origins is None else self.origins[chosen]
        classes = None if self.classes is None else self.classes[chosen]
        return replace(self, points=self.points[chosen], origins=origins, classes=classes)


def is_cloud(path: Path) -> bool:
    """Whether a file is a point cloud, by its name; a PLY file is one when its header claims no face."""
    suffix = path.suffix.lower()
    if suffix != ".ply":
        return suffix in OPENERS
    try:
        with path.open("rb") as file:
            header = file.read(_HEADER_BYTES).partition(b"end_header")[0]
    except OSError:
        return False  # the reader of meshes says what is wrong
    words = [line.split() for line in header.splitlines()]
    faces = [line[2] for line in words if line[:2] == [b"element", b"face"] and len(line) > 2]
    return header.startswith(b"ply") and b"vertex" in header and faces in ([], [b"0"])


def read_survey(path: Path, settings: SceneSettings, poses: Path | None = None) -> Survey:
    """Read a point cloud and place it.

    Parameters
    ----------
    path : Path
    settings : SceneSettings
        Units other than metres replace those that the file states. Without a coordinate system or an origin,
        whole hundreds of metres are taken off where coordinates are beyond the grid.
    poses : Path or None
        Where the scans were made; see :func:`tilesnav_ref.survey.scans.read_scans`.

    Raises
    ------
    SceneError
        When the file cannot be read or placed.
    """
    units = "auto" if settings.units == "m" else settings.units
    cloud = read_scans(path, CloudSettings(units=units), poses)
    source, suffix = str(path), path.suffix.lower()
    if settings.crs is not None and settings.crs.lower() != "enu":
        frame = to_nav(source, suffix, _in_file(cloud, cloud.points), settings)
        origins = _placed_origins(cloud)
        if origins is not None:
            origins = to_nav(source, suffix, _in_file(cloud, origins), settings).positions
        return Survey(frame.positions, frame, None, origins, cloud.classes)
    metres, origin = _local(cloud, settings)
    frame = to_nav(source, suffix, cloud.points + cloud.origin, metres)
    origins = _placed_origins(cloud)
    if origins is not None:
        origins = to_nav(source, suffix, origins + cloud.origin, metres).positions
    return Survey(frame.positions, frame, origin, origins, cloud.classes)


def _in_file(cloud: PointCloud, points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray((points + cloud.origin) / cloud.metres_per_unit)


def _placed_origins(cloud: PointCloud) -> NDArray[np.float64] | None:
    """(N, 3) position of the scanner for each point."""
    if cloud.places is not None:
        return cloud.places
    if cloud.scan_origins is None or cloud.scans is None:
        return None
    return np.asarray(cloud.scan_origins[cloud.scans])


def _local(
    cloud: PointCloud, settings: SceneSettings
) -> tuple[SceneSettings, tuple[float, float, float] | None]:
    """Settings that place points in metres, and the origin in metres."""
    if settings.crs is not None:  # enu: coordinates are local
        return replace(settings, units="m"), None
    given = settings.origin
    if given is not None:
        x, y, z = (value * cloud.metres_per_unit for value in given)
        return replace(settings, units="m", origin=(x, y, z)), (x, y, z)
    reach = np.abs(cloud.points + cloud.origin).max(initial=0.0)
    if reach < COORDINATE_LIMIT * settings.step:
        return replace(settings, units="m"), None
    far = abs(float(cloud.origin[2])) >= COORDINATE_LIMIT * settings.step / 2
    origin = (float(cloud.origin[0]), float(cloud.origin[1]), float(cloud.origin[2]) if far else 0.0)
    return replace(settings, units="m", origin=origin), origin
