"""From the axes, units and coordinate system of a file to the nav frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.settings import METRES_PER_UNIT, SceneSettings

WGS84_A = 6378137.0
"""Semi-major axis, metres (NIMA TR8350.2)."""
WGS84_F = 1.0 / 298.257223563
"""Flattening (NIMA TR8350.2)."""


@dataclass(frozen=True)
class NavFrame:
    """Positions in the nav frame, and where that frame is."""

    positions: NDArray[np.float64]
    """(V, 3) metres, z up."""
    tileset_from_nav: NDArray[np.float64]
    """(4, 4) rigid."""
    up: str
    """Axis of the file that points up."""
    notes: tuple[str, ...] = ()


def up_axis(up: str, suffix: str) -> str:
    """Axis that points up: as set, else y for glTF by its definition and z for everything else."""
    if up != "auto":
        return up
    return "y" if suffix in (".glb", ".gltf") else "z"


def to_nav(source: str, suffix: str, vertices: NDArray[np.float64], settings: SceneSettings) -> NavFrame:
    """Move file coordinates to the nav frame, in float64.

    Parameters
    ----------
    source : str
        File named in errors.
    suffix : str
        Of the file, lower case, with the dot.
    vertices : (V, 3) float64
        File units and axes, finite.
    settings : SceneSettings

    Raises
    ------
    SceneError
        When the coordinate system is unknown, cannot be had, or does not hold the vertices.
    """
    up = up_axis(settings.up, suffix)
    with np.errstate(over="ignore", invalid="ignore"):  # snapping refuses what is not finite
        return _placed(source, up, vertices, settings)


def _placed(source: str, up: str, vertices: NDArray[np.float64], settings: SceneSettings) -> NavFrame:
    x, y, z = vertices.T
    upright = np.stack({"x": (y, z, x), "y": (x, -z, y), "z": (x, y, z)}[up], axis=1)
    factor = METRES_PER_UNIT[settings.units]
    if settings.crs is None:
        if settings.origin is not None:
            upright = upright - np.array(settings.origin)
        return NavFrame(upright * factor, np.eye(4), up)
    if settings.crs.lower() == "enu":
        assert settings.origin is not None  # SceneSettings requires it
        return NavFrame(upright * factor, ecef_from_enu(settings.origin), up)
    ecef = _ecef(source, upright, settings.crs)
    origin = settings.origin or _default_origin(ecef)
    matrix = ecef_from_enu(origin)
    positions = (ecef - matrix[:3, 3]) @ matrix[:3, :3]
    place = f"longitude {origin[0]:.9f}, latitude {origin[1]:.9f}, height {origin[2]:.3f}"
    note = f"nav frame: east, north, up around {place}"
    return NavFrame(positions, matrix, up, (note,))


def ecef_from_enu(origin: tuple[float, float, float]) -> NDArray[np.float64]:
    """Matrix from local east, north, up to Earth-centred, Earth-fixed WGS 84.

    Parameters
    ----------
    origin : (longitude, latitude, height)
        Degrees, degrees, metres above the ellipsoid.

    Returns
    -------
    (4, 4) float64
        Columns east, north, up, origin; metres.
    """
    lon, lat = np.radians(origin[:2])
    sin_lon, cos_lon, sin_lat, cos_lat = np.sin(lon), np.cos(lon), np.sin(lat), np.cos(lat)
    eccentricity2 = WGS84_F * (2.0 - WGS84_F)
    normal = WGS84_A / np.sqrt(1.0 - eccentricity2 * sin_lat**2)
    matrix = np.eye(4)
    matrix[:3, 0] = (-sin_lon, cos_lon, 0.0)
    matrix[:3, 1] = (-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat)
    up = np.array((cos_lat * cos_lon, cos_lat * sin_lon, sin_lat))
    matrix[:3, 2] = up
    radii = np.array((normal, normal, normal * (1.0 - eccentricity2)))
    matrix[:3, 3] = (radii + origin[2]) * up
    return matrix


def _default_origin(ecef: NDArray[np.float64]) -> tuple[float, float, float]:
    """Longitude and latitude of the middle of the box in east and north, and the least height there.

    Notes
    -----
    The box in Earth-centred axes has another middle: half a kilometre off for a town of 15 km. So east and
    north are taken there first.
    """
    longitude, latitude = _geodetic((ecef.min(axis=0) + ecef.max(axis=0)) / 2)
    near = ecef_from_enu((longitude, latitude, 0.0))
    local = (ecef - near[:3, 3]) @ near[:3, :2]
    middle = (local.min(axis=0) + local.max(axis=0)) / 2
    longitude, latitude = _geodetic(near[:3, 3] + near[:3, :2] @ middle)
    at_zero = ecef_from_enu((longitude, latitude, 0.0))
    heights = (ecef - at_zero[:3, 3]) @ at_zero[:3, 2]
    return longitude, latitude, float(heights.min())


def _geodetic(position: NDArray[np.float64]) -> tuple[float, float]:
    """Longitude and latitude in degrees, by Bowring's formula (1976; under 1 mm near the ground)."""
    eccentricity2 = WGS84_F * (2.0 - WGS84_F)
    polar = WGS84_A * (1.0 - WGS84_F)
    flat = float(np.hypot(position[0], position[1]))
    theta = np.arctan2(position[2] * WGS84_A, flat * polar)
    second2 = eccentricity2 / (1.0 - eccentricity2)
    lat = np.arctan2(
        position[2] + second2 * polar * np.sin(theta) ** 3,
        flat - eccentricity2 * WGS84_A * np.cos(theta) ** 3,
    )
    return float(np.degrees(np.arctan2(position[1], position[0]))), float(np.degrees(lat))


def _ecef(source: str, positions: NDArray[np.float64], crs: str) -> NDArray[np.float64]:
    """Earth-centred coordinates of positions in a coordinate system of pyproj; heights without datum are
    ellipsoidal."""
    if crs.upper() == "EPSG:4978":
        return positions
    try:
        import pyproj  # noqa: PLC0415 - optional: only files with a coordinate system need it
    except ImportError as error:
        raise SceneError(
            source,
            f"crs {crs}",
            "no pyproj",
            "pyproj installed (pip install 'tilesnav[crs]'), or crs enu or EPSG:4978",
        ) from error
    try:
        system = pyproj.CRS.from_user_input(crs).to_3d()
        transformer = pyproj.Transformer.from_crs(system, "EPSG:4978", always_xy=True)
        ecef = np.stack(transformer.transform(*positions.T), axis=1)
    except pyproj.exceptions.ProjError as error:
        raise SceneError(
            source, f"crs {crs}", str(error)[:200], "a coordinate system that pyproj knows"
        ) from error
    bad = np.flatnonzero(~np.isfinite(ecef).all(axis=1))
    if len(bad):
        where = positions[bad[0]].tolist()
        raise SceneError(
            source, f"vertex {bad[0]}", f"{where} outside {crs}", "positions within the coordinate system"
        )
    return np.asarray(ecef, np.float64)
