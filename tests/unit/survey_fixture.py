"""A small site and its survey from the air, as a LAS file."""

from __future__ import annotations

from pathlib import Path

import laspy
import numpy as np
from numpy.typing import NDArray


def site_from_above(seed: int = 0) -> NDArray[np.float64]:
    """Returns of a flat site of 40 m with a house of 10 m and the crown of a tree, 12 a square metre.

    The house stands from 10 to 20 along x and y and is 6 m high, the tree around (30, 30) up to 8 m. Walls
    and the ground under house and tree return nothing.
    """
    rng = np.random.default_rng(seed)
    plan = rng.random((19200, 2)) * 40.0
    height = np.zeros(len(plan))
    house = ((plan > 10.0) & (plan < 20.0)).all(axis=1)
    height[house] = 6.0
    crown = np.linalg.norm(plan - 30.0, axis=1) < 3.0
    height[crown] = 5.0 + 3.0 * rng.random(crown.sum())
    return np.column_stack((plan, height + rng.normal(0.0, 0.02, len(plan))))


def write_las(path: Path, points: NDArray[np.float64]) -> Path:
    """Write points, metres, as LAS 1.4."""
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales = np.full(3, 0.001)
    header.offsets = np.floor(points.min(axis=0))
    las = laspy.LasData(header)
    las.x, las.y, las.z = points.T
    las.write(path)
    return path
