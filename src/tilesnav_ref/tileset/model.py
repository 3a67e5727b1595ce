"""What the writer is given: the results of all stages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.levels.model import CoarseLevel
from tilesnav_ref.lod.model import LodTable
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.visibility.model import PvsTable

SPEC_VERSION = "0.1.0"
"""Version of the extension that is written."""

EXTENSION = "3DTILES_nav"


@dataclass(frozen=True)
class TilesetSettings:
    """How the tileset is cut into files."""

    cells_per_sector: int = 65536
    """Most cells in one nav file."""


@dataclass(frozen=True)
class DeltaTable:
    """What changes behind every directed portal, in the order of the portals; every list ascends.

    Notes
    -----
    The delta of portal k from a to b enters the faces of b's set that a's lacks, and leaves those of a's
    that b's lacks. It switches the objects that b lists and a does not, or not with the same code.
    """

    entered_offsets: NDArray[np.int64]
    """(M + 1,)."""
    entered: NDArray[np.uint32]
    """(E,) face numbers."""
    left_offsets: NDArray[np.int64]
    """(M + 1,)."""
    left: NDArray[np.uint32]
    """(L,) face numbers."""
    switch_offsets: NDArray[np.int64]
    """(M + 1,)."""
    switch_objects: NDArray[np.uint32]
    """(S,) object numbers."""
    switch_codes: NDArray[np.uint8]
    """(S,) level codes in the target."""


@dataclass(frozen=True)
class NavMap:
    """Everything that is published, as the stages handed it on."""

    scene: Scene
    cells: CellComplex
    pvs: PvsTable
    lod: LodTable
    deltas: DeltaTable
    provenance: dict[str, Any]
    """The entry object's member of that name; JSON values."""
    max_range: float | None = None
    """Metres within which a face counts as visible; None for any distance."""
    coarse: tuple[CoarseLevel, ...] = ()
    """Coarse levels, from fine to coarse."""
