"""Some triangles before Embree, which says in float32 what a ray hits first: a suggestion, no verdict."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


class RayScene:
    """A set of triangles, each with a number.

    Parameters
    ----------
    triangles : ndarray of float32, shape (p, 3, 3)
        All triangles there are.
    numbers : ndarray of int, shape (n,)
        Those that rays can hit.
    """

    def __init__(self, triangles: NDArray[np.float32], numbers: NDArray[np.int64]) -> None:
        from embreex.mesh_construction import TriangleMesh  # noqa: PLC0415 - a tenth of a second that broken tilesets save
        from embreex.rtcore_scene import EmbreeScene  # noqa: PLC0415

        self.numbers = np.append(numbers, -1)  # the last is for -1, no hit
        self._embree: Any = EmbreeScene()
        self._mesh = TriangleMesh(self._embree, triangles[numbers]) if len(numbers) else None
        if self._mesh is not None:  # the first query builds the tree: not while threads wait for it
            self.first_hits(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))

    def first_hits(
        self,
        origins: NDArray[np.float32],
        directions: NDArray[np.float32],
        limits: NDArray[np.float32] | None = None,
    ) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        """Number of the triangle that each ray hits first, -1 for none, and where, in lengths of directions.

        Parameters
        ----------
        limits : ndarray of float32, shape (r,), optional
            Where rays end, in lengths of their directions.
        """
        if self._mesh is None:
            return np.full(len(origins), -1, np.int64), np.full(len(origins), np.inf, np.float32)
        found = self._embree.run(origins, directions, dists=limits, query="INTERSECT", output=True)
        return self.numbers[found["primID"]], np.where(found["primID"] < 0, np.inf, found["tfar"])
