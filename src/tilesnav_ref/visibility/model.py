"""Potentially visible sets as the later stages use them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.visibility.certificates import Certificates


@dataclass(frozen=True)
class PvsTable:
    """Potentially visible set of every cell, and how much of it is proven visible.

    Notes
    -----
    Faces of cell i are ``pvs_faces[pvs_offsets[i]:pvs_offsets[i + 1]]``, ascending.
    """

    pvs_offsets: NDArray[np.int64]
    """(N + 1,)."""
    pvs_faces: NDArray[np.uint32]
    """(P,) face numbers."""
    pvs_proven: NDArray[np.bool_]
    """(P,) whether the listed face is proven visible."""
    undecided: dict[str, int] = field(default_factory=dict)
    """Number of kept faces that are neither proven visible nor proven hidden, by the reason why."""
    certificates: Certificates | None = None
    """Proofs for the faces that are not listed, when they were asked for."""
    proven_before: NDArray[np.int64] | None = None
    """(N,) numbers of proven visible faces of sets that were taken over from a file, which does not say which
    faces they are; 0 for other cells. They come on top of those in `pvs_proven`."""

    def faces_of(self, cell: int) -> NDArray[np.uint32]:
        """Face numbers of one cell, ascending."""
        return self.pvs_faces[self.pvs_offsets[cell] : self.pvs_offsets[cell + 1]]

    @property
    def proven_counts(self) -> NDArray[np.int64]:
        """(N,) number of proven visible faces of every cell."""
        total = np.concatenate(([0], np.cumsum(self.pvs_proven, dtype=np.int64)))
        flagged = np.asarray(total[self.pvs_offsets[1:]] - total[self.pvs_offsets[:-1]], dtype=np.int64)
        return flagged if self.proven_before is None else flagged + self.proven_before
