"""How far positions lie outside a bounding volume of 3D Tiles."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_WGS84_A = 6378137.0
_WGS84_F = 1 / 298.257223563


def box_excess(box: FloatArray, points: FloatArray) -> float:
    """Largest distance in metres by which a point is beyond a side of a box.

    Parameters
    ----------
    box : ndarray of float64, shape (12,)
        Centre and three half-axes, as in 3D Tiles. A half-axis of length zero is a flat box.
    points : ndarray of float64, shape (k, 3)
    """
    half = box[3:].reshape(3, 3)
    lengths = np.linalg.norm(half, axis=1)
    axes = np.where(lengths[:, None] > 0, half / np.where(lengths > 0, lengths, 1)[:, None], 0)
    for index in np.flatnonzero(lengths == 0):
        axes[index] = _third(axes, int(index))
    beyond = np.abs((points - box[:3]) @ axes.T) - lengths
    return float(beyond.max(initial=-np.inf))


def _third(axes: FloatArray, index: int) -> FloatArray:
    """A unit vector orthogonal to the other two axes, as far as those have a direction."""
    first, second = axes[(index + 1) % 3], axes[(index + 2) % 3]
    normal = np.cross(first, second)
    if not normal.any():
        known = first if first.any() else second
        helper = np.eye(3)[int(np.argmin(np.abs(known)))]
        normal = helper - known * (helper @ known)
    return np.asarray(normal / np.linalg.norm(normal))


def sphere_excess(sphere: FloatArray, points: FloatArray) -> float:
    """Largest distance in metres by which a point is outside a sphere (centre, radius)."""
    beyond = np.linalg.norm(points - sphere[:3], axis=1) - sphere[3]
    return float(beyond.max(initial=-np.inf))


def geodetic(ecef: FloatArray) -> FloatArray:
    """Longitude, latitude (radians) and ellipsoidal height (metres) of ECEF positions, shape (k, 3).

    Notes
    -----
    Bowring's start and fixed-point steps on the reduced latitude; below 1e-9 m from -10 km to 1000 km of
    height.
    """
    x, y, z = ecef.T
    b = _WGS84_A * (1 - _WGS84_F)
    e2, ep2 = _WGS84_F * (2 - _WGS84_F), (_WGS84_A / b) ** 2 - 1
    p = np.hypot(x, y)
    beta = np.arctan2(z * _WGS84_A, p * b)
    for _ in range(4):
        latitude = np.arctan2(z + ep2 * b * np.sin(beta) ** 3, p - e2 * _WGS84_A * np.cos(beta) ** 3)
        beta = np.arctan2((1 - _WGS84_F) * np.sin(latitude), np.cos(latitude))
    radius = _WGS84_A / np.sqrt(1 - e2 * np.sin(latitude) ** 2)
    height = p * np.cos(latitude) + z * np.sin(latitude) - _WGS84_A**2 / radius
    return np.stack([np.arctan2(y, x), latitude, height], axis=1)


def region_excess(region: FloatArray, ecef: FloatArray) -> float:
    """Largest distance in metres by which an ECEF position is outside a region (west, south, east, north,
    low, high)."""
    if not len(ecef):
        return -math.inf
    west, south, east, north, low, high = region
    longitude, latitude, height = geodetic(ecef).T
    width = (east - west) % math.tau if east != west else 0.0
    if east - west >= math.tau:
        width = math.tau
    offset = (longitude - west) % math.tau
    beyond_lon = np.where(offset <= width, 0.0, np.minimum(offset - width, math.tau - offset))
    beyond_lat = np.maximum(south - latitude, latitude - north)
    metres = np.stack(
        [beyond_lon * _WGS84_A * np.cos(latitude), beyond_lat * _WGS84_A, low - height, height - high]
    )
    return float(metres.max())


_KINDS = {"box": 12, "sphere": 4, "region": 6}


def fault(volume: Any, points: FloatArray, root_from_tile: FloatArray, allowance: float) -> str | None:
    """What is wrong with the bounding volume of a tile, if anything.

    Parameters
    ----------
    volume : object
        As it stands in the file. Where there are several kinds, each must bound.
    points : ndarray of float64, shape (k, 3)
        Positions in the frame of the tile.
    root_from_tile : ndarray of float64, shape (4, 4)
        Accumulated transform, which is what a region is measured in.
    allowance : float
        Metres that a position may be outside.
    """
    kinds = [name for name in _KINDS if isinstance(volume, dict) and name in volume]
    if not kinds:
        return "no box, sphere or region"
    for name in kinds:
        numbers = volume[name]
        try:
            values = np.array(numbers, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            return f"malformed {name}"
        if values.shape != (_KINDS[name],) or not np.isfinite(values).all():
            return f"malformed {name}"
        if name == "region":
            excess = region_excess(values, points @ root_from_tile[:3, :3].T + root_from_tile[:3, 3])
        else:
            excess = (box_excess if name == "box" else sphere_excess)(values, points)
        if excess > allowance:
            return f"a position {excess:.6g} m outside the {name}"
    return None
