"""What is found out about the cells of a block, and the same as arrays to be kept."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.visibility.certificates import Proofs
from tilesnav_ref.visibility.journal import Arrays


@dataclass(frozen=True)
class Seen:
    """What was found out about one cell."""

    faces: NDArray[np.uint32]
    """Faces that are listed, ascending."""
    proven: NDArray[np.bool_]
    """For each of them whether it is proven visible."""
    reasons: NDArray[np.int64]
    """(len(REASONS),) numbers of undecided faces."""


@dataclass
class Sight:
    """What was found out about the cells of a block, and the proofs that were kept."""

    cells: dict[int, Seen] = field(default_factory=dict)
    proofs: list[Proofs] = field(default_factory=list)


def to_arrays(sight: Sight) -> Arrays:
    """Everything as arrays by name."""
    arrays: dict[str, NDArray[np.generic]] = {"cells": np.array(list(sight.cells), np.int64)}
    for cell, seen in sight.cells.items():
        arrays |= {f"{cell} {name}": value for name, value in vars(seen).items()}
    arrays["proofs"] = np.array(len(sight.proofs))
    for number, proofs in enumerate(sight.proofs):
        arrays[f"proofs {number} cells"] = np.array(proofs.cells, np.int64)
        arrays[f"proofs {number} region"] = proofs.region
        arrays[f"proofs {number} words"] = proofs.words
    return arrays


def from_arrays(arrays: Arrays) -> Sight:
    """The reverse of `to_arrays`."""
    cells = {
        int(cell): Seen(arrays[f"{cell} faces"], arrays[f"{cell} proven"], arrays[f"{cell} reasons"])  # type: ignore[arg-type]
        for cell in arrays["cells"].tolist()
    }
    proofs = [
        Proofs(
            tuple(arrays[f"proofs {number} cells"].tolist()),
            arrays[f"proofs {number} region"],  # type: ignore[arg-type]
            arrays[f"proofs {number} words"],  # type: ignore[arg-type]
        )
        for number in range(int(arrays["proofs"].item()))
    ]
    return Sight(cells, proofs)
