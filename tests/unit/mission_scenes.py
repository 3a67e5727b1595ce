"""Hand-made grounds for tests of missions: flat, slope, terrace, hill, bridge, hole."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tilesnav_ref.cells import CellComplex
from tilesnav_ref.scene.model import Scene

EXPONENT = -4
STEP = 2.0**EXPONENT
QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def box_faces(low: tuple[float, float, float], high: tuple[float, float, float]) -> np.ndarray:
    """(12, 3, 3) triangles of a closed box, m."""
    corner = np.array([[(low, high)[(c >> k) & 1][k] for k in range(3)] for c in range(8)])
    return np.array([corner[list(t)] for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])


def surface(height: Callable[[float, float], float], size: float, pitch: float = 4.0) -> np.ndarray:
    """Triangles of a height field over the square from 0 to size, m."""
    places = np.arange(0.0, size, pitch)
    faces = []
    for x in places:
        for y in places:
            a, b, c, d = ((px, py, height(px, py)) for px, py in _ring(x, y, pitch))
            faces += [(a, b, c), (a, c, d)]
    return np.array(faces)


def _ring(x: float, y: float, pitch: float) -> tuple[tuple[float, float], ...]:
    return (x, y), (x + pitch, y), (x + pitch, y + pitch), (x, y + pitch)


def rectangle(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> np.ndarray:
    """(2, 3, 3) a rectangle whose height goes from z[0] at x[0] to z[1] at x[1], m."""
    a, b, c, d = (x[0], y[0], z[0]), (x[1], y[0], z[1]), (x[1], y[1], z[1]), (x[0], y[1], z[0])
    return np.array([(a, b, c), (a, c, d)])


def wall(x: float, y: tuple[float, float], z: tuple[float, float]) -> np.ndarray:
    """(2, 3, 3) an upright rectangle across x, m."""
    a, b, c, d = (x, y[0], z[0]), (x, y[1], z[0]), (x, y[1], z[1]), (x, y[0], z[1])
    return np.array([(a, b, c), (a, c, d)])


def scene_of(*parts: np.ndarray, terrain: int | None = None) -> Scene:
    """A scene with an object for each part, in metres; ``terrain`` is the part that is named as ground."""
    corners = np.round(np.concatenate(parts) / STEP).astype(np.int64)
    faces = np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
    owner = np.repeat(np.arange(len(parts), dtype=np.int32), [len(part) for part in parts])
    named = np.zeros(0, np.bool_) if terrain is None else np.arange(len(parts)) == terrain
    return Scene(
        corners.reshape(-1, 3),
        faces,
        owner,
        np.zeros(len(parts), np.int32),
        tuple(f"part {k}" for k in range(len(parts))),
        EXPONENT,
        object_terrain=named,
    )


def holders(cells: CellComplex, point: tuple[float, float, float]) -> np.ndarray:
    """Cells whose interior holds a point, m."""
    place = np.array(point) / STEP
    return np.flatnonzero(np.all((cells.lower < place) & (place < cells.upper), axis=1))


def hill(x: float, y: float) -> float:
    """A round hill of 40 m in the middle of 128 m, on the grid at multiples of 4 m."""
    away = ((x - 64.0) ** 2 + (y - 64.0) ** 2) / 64.0**2
    return float(np.round(40.0 * max(0.0, 1.0 - away) / STEP) * STEP)


def mesh_heights(faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Height (m) of a height field of triangles (F, 3, 3) below each point (P, 2), by barycentric weights."""
    result = np.full(len(points), np.inf)
    for a, b, c in faces:
        matrix = np.array([b[:2] - a[:2], c[:2] - a[:2]]).T
        if abs(np.linalg.det(matrix)) < 1e-12:
            continue
        s, t = np.linalg.solve(matrix, (points - a[:2]).T)
        inside = (s >= -1e-9) & (t >= -1e-9) & (s + t <= 1 + 1e-9)
        height = a[2] + s * (b[2] - a[2]) + t * (c[2] - a[2])
        result[inside] = np.minimum(result[inside], height[inside])
    return result
