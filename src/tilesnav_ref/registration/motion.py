"""Rigid motions as matrices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation


def place(pose: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3) points moved by a pose (4, 4)."""
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])


def unplace(pose: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) points moved back by a pose (4, 4)."""
    return np.asarray((points - pose[:3, 3]) @ pose[:3, :3])


def shift(by: NDArray[np.float64]) -> NDArray[np.float64]:
    """(4, 4) a motion without a turn."""
    moved = np.eye(4)
    moved[:3, 3] = by
    return moved


def inverse(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """(4, 4) the motion back."""
    back = np.eye(4)
    back[:3, :3] = pose[:3, :3].T
    back[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return back


def turned_about(
    pose: NDArray[np.float64], centre: NDArray[np.float64], twist: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(4, 4) a pose after a turn about a centre (3,) and a shift: twist (6,), radians and metres."""
    turn = Rotation.from_rotvec(twist[:3]).as_matrix()
    moved = np.eye(4)
    # Orthogonal again each time, so that rounding does not build up over rounds.
    moved[:3, :3] = Rotation.from_matrix(turn @ pose[:3, :3]).as_matrix()
    moved[:3, 3] = turn @ (pose[:3, 3] - centre) + centre + twist[3:]
    return moved
