"""Where on Earth a tileset is, and the nav frame of its positions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.frame import WGS84_A, WGS84_F, NavFrame, to_nav
from tilesnav_ref.scene.settings import SceneSettings

NEAR_EARTH = 20_000.0
"""Metres from the ellipsoid within which a position is taken as Earth-centred: the deepest trench and the
highest mountain with what flies above it are nearer."""


def place(source: str, positions: NDArray[np.float64], settings: SceneSettings) -> NavFrame:
    """Move positions of a tileset to the nav frame.

    Parameters
    ----------
    source : str
        Entry tileset, named in errors.
    positions : (V, 3) float64
        Axes of the entry tileset, metres.
    settings : SceneSettings

    Returns
    -------
    NavFrame
        With crs as it says. Without: around the middle of the positions, east, north, up when they are
        Earth-centred, and with the axes of the tileset (z up) when they are not, or when `origin` states x, y
        and z of the zero. The frame always says where in the tileset's coordinates it is.

    Raises
    ------
    SceneError
        When only some of the positions are near the Earth, or units are not metres.
    """
    if settings.units != "m":
        raise SceneError(source, "units", settings.units, "m, which 3D Tiles are in")
    upright = replace(settings, up="z")
    if settings.crs is not None:
        return to_nav(source, ".json", positions, upright)
    if settings.origin is None:
        near = near_earth(positions)
        if near.all():
            return to_nav(source, ".json", positions, replace(upright, crs="EPSG:4978"))
        if near.any():
            raise SceneError(
                source,
                "positions",
                f"{int(near.sum())} of {len(near)} within {NEAR_EARTH:g} m of the ellipsoid",
                "all (Earth-centred) or none (local); else say --crs, or --origin for local coordinates",
            )
    return _local(positions, upright)


def near_earth(positions: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(V,) whether positions, taken as Earth-centred, lie near the WGS 84 ellipsoid.

    Notes
    -----
    The height is taken along the ray from the centre: off by less than 0.2 % at such heights.
    """
    distance = np.linalg.norm(positions, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):  # the centre of the Earth is not near
        sine2 = np.where(distance > 0, (positions[:, 2] / distance) ** 2, 0.0)
    shape = 1.0 / (1.0 - WGS84_F) ** 2
    radius = WGS84_A / np.sqrt(1.0 - sine2 + sine2 * shape)
    return np.asarray(np.abs(distance - radius) < NEAR_EARTH)


def _local(positions: NDArray[np.float64], settings: SceneSettings) -> NavFrame:
    """Coordinates of the tileset around a zero, which is at whole metres so that differences stay exact."""
    zero = np.array(settings.origin) if settings.origin is not None else _middle(positions)
    matrix = np.eye(4)
    matrix[:3, 3] = zero
    note = (
        "positions are not Earth-centred: taken as local metres, z up;"
        f" nav frame around x {zero[0]:.3f}, y {zero[1]:.3f}, z {zero[2]:.3f} of the tileset"
    )
    return NavFrame(positions - zero, matrix, settings.up, (note,))


def _middle(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Middle of the box in x and y, and its least z."""
    lower, upper = positions.min(axis=0), positions.max(axis=0)
    middle = (lower + upper) / 2
    return np.rint((middle[0], middle[1], lower[2]))
