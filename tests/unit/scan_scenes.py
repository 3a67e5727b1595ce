"""Scenes whose scans are known by other means."""

from __future__ import annotations

import numpy as np
from mission_scenes import box_faces, rectangle, scene_of

from tilesnav_ref.scene import Scene

ROOM = (np.array((-4.0, -6.0, -2.0)), np.array((8.0, 10.0, 3.0)))


def room() -> Scene:
    """A closed box seen from within, m."""
    low, high = ROOM
    return scene_of(box_faces(tuple(low), tuple(high)))


def yard() -> Scene:
    """Ground, two houses, a wall and a pillar: corners enough to fix all six numbers of a pose."""
    return scene_of(
        rectangle((-30, 30), (-30, 30), (0, 0)),
        box_faces((6, 4, 0), (14, 11, 7)),
        box_faces((-12, -16, 0), (-5, -6, 5)),
        box_faces((-20, 8, 0), (-19.5, 22, 4)),
        box_faces((12, -14, 0), (15, -11, 9)),
    )


def wall_ranges(
    points: np.ndarray, directions: np.ndarray, box: tuple[np.ndarray, np.ndarray] = ROOM
) -> np.ndarray:
    """(R,) distances from points within a box to its walls along directions (R, 3), by slabs."""
    low, high = box
    with np.errstate(divide="ignore"):
        away = np.maximum((low - points) / directions, (high - points) / directions)
    return away.min(axis=1)


def nearest_hits(corners: np.ndarray, origin: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """(R,) distance to the first of all triangles (F, 3, 3), a ray at a time (Moller, Trumbore)."""
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    found = np.full(len(directions), np.inf)
    for k, way in enumerate(directions):
        cross = np.cross(way, v)
        area = (u * cross).sum(axis=1)
        area[np.abs(area) < 1e-12] = np.nan
        first = ((origin - a) * cross).sum(axis=1) / area
        other = np.cross(origin - a, u)
        second = other @ way / area
        along = (v * other).sum(axis=1) / area
        met = (first >= 0) & (second >= 0) & (first + second <= 1) & (along > 0)
        if met.any():
            found[k] = along[met].min()
    return found
