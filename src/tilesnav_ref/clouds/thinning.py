"""One point of each cube, while a cloud is being read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.clouds.model import Chunk

BITS = 21
"""Of a cube number along each axis: 2 million cubes from the origin to either side of a file, which is 20 km
with cubes of 1 cm. Farther cubes share numbers, so that of two such points one may be lost."""


class Thinning:
    """Keeps the first point of each cube; its memory grows with the points kept, not with those read."""

    def __init__(self, edge: float) -> None:
        self._edge = edge
        self._seen: NDArray[np.int64] = np.empty(0, np.int64)

    def kept(self, chunk: Chunk) -> Chunk:
        """The points of a chunk whose cube had none; all for an edge of 0."""
        if self._edge == 0.0:
            return chunk
        cubes: NDArray[np.int64] = np.floor(chunk.points / self._edge).astype(np.int64)
        cubes &= (1 << BITS) - 1
        keys = cubes @ np.array((1 << 2 * BITS, 1 << BITS, 1), np.int64)
        fresh, first = np.unique(keys, return_index=True)
        place = np.searchsorted(self._seen, fresh)
        inside = place < len(self._seen)
        known = np.zeros(len(fresh), np.bool_)
        known[inside] = self._seen[place[inside]] == fresh[inside]
        self._seen = np.insert(self._seen, place[~known], fresh[~known])
        return chunk.kept(np.sort(first[~known]))
