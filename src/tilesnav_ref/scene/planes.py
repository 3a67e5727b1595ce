"""The table of planes that faces of a surveyed scene lie on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class PlaneTable:
    """Planes in the nav frame, metres, and the plane of every face."""

    normals: NDArray[np.float64]
    """(K, 3) unit normals."""
    offsets: NDArray[np.float64]
    """(K,) ``normals[k] @ x + offsets[k] = 0`` on plane k."""
    centres: NDArray[np.float64]
    """(K, 3) middles of the extent rectangles."""
    axes: NDArray[np.float64]
    """(K, 2, 3) unit vectors along the longer and the shorter side of these."""
    half_sizes: NDArray[np.float64]
    """(K, 2) half of both sides."""
    areas: NDArray[np.float64]
    """(K,) area of the faces, square metres."""
    rms: NDArray[np.float64]
    """(K,) root mean square distance of the inliers."""
    counts: NDArray[np.int64]
    """(K,) inliers."""
    covariances: NDArray[np.float64]
    """(K, 3, 3) covariance of the inliers, square metres."""
    face_plane: NDArray[np.int32]
    """(F,) plane of each face; -1 of those on none, between planes of the ground."""

    def __len__(self) -> int:
        """Count of planes."""
        return len(self.offsets)
