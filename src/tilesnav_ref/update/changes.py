"""Which cells see something of a change, and the sets of all others.

Let C be a cell of both maps, and let no face that is gone be visible from C in the earlier scene, nor a face
that is new in the new one, from either side. Then of the faces in both scenes exactly the same are visible
from C (docs/decisions/0019): the earlier set stays right.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.cells.planes import planes
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.update.matching import cell_rows, face_rows, match_rows
from tilesnav_ref.update.previous import Previous
from tilesnav_ref.visibility import PvsTable, VisibilitySettings
from tilesnav_ref.visibility.unseen import Outlook, may_see

logger = logging.getLogger(__name__)

Progress = Callable[[int, int], None]

KEPT = "kept"
"""Reason that is stated for undecided faces of sets that are taken over; the file does not hold others."""


@dataclass(frozen=True)
class UpdateParameters:
    """What an update depends on beside the scene and the settings of the stages."""

    previous_sha256: str
    """Digest of the earlier entry tileset."""


@dataclass(frozen=True)
class Kept:
    """A set that is taken over."""

    faces: NDArray[np.uint32]
    """Numbers in the new scene, ascending."""
    proven: int
    """How many of them are proven visible."""


@dataclass(frozen=True)
class Update:
    """What is taken over, and what is left to do."""

    parameters: UpdateParameters
    kept: dict[int, Kept]
    """By the number of the cell."""
    anew: NDArray[np.int64]
    """Ascending numbers of all other cells."""
    todo: CellComplex
    """Those cells, with the portals between them."""
    findings: dict[str, int]
    """Counts for the provenance."""

    def merge(self, table: PvsTable) -> PvsTable:
        """Put the sets of the cells to be done, in their order, among those that are kept."""
        count = len(self.kept) + len(self.anew)
        faces: list[NDArray[np.uint32]] = [np.zeros(0, np.uint32)] * count
        flags: list[NDArray[np.bool_]] = [np.zeros(0, np.bool_)] * count
        counts = np.zeros(count, np.int64)
        for row, cell in enumerate(self.anew.tolist()):
            faces[cell] = table.faces_of(row)
            flags[cell] = table.pvs_proven[table.pvs_offsets[row] : table.pvs_offsets[row + 1]]
        for cell, kept in self.kept.items():
            faces[cell], counts[cell] = kept.faces, kept.proven
            flags[cell] = np.zeros(len(kept.faces), np.bool_)
        offsets = np.zeros(count + 1, np.int64)
        np.cumsum([len(of_cell) for of_cell in faces], out=offsets[1:])
        open_pairs = sum(len(kept.faces) - kept.proven for kept in self.kept.values())
        undecided = {**table.undecided, KEPT: open_pairs} if open_pairs else table.undecided
        return PvsTable(offsets, np.concatenate(faces), np.concatenate(flags), undecided, None, counts)


def find_changes(
    previous: Previous,
    scene: Scene,
    cells: CellComplex,
    settings: VisibilitySettings,
    progress: Progress | None = None,
) -> Update:
    """Find the cells whose sets can be taken over from an earlier tileset.

    Parameters
    ----------
    previous : the earlier tileset.
    scene : the new scene, on the same grid and in the same frame.
    cells : cells of the new scene.
    settings : amount of work on proofs that faces are hidden, and the range, that of the earlier run.
    progress : called with finished and all steps.

    Raises
    ------
    UpdateError
        When grid or frame differ.
    TilesetError
        When a set does not fit its digest.
    """
    previous.check_frame(scene)
    progress = progress or _no_progress
    new_number = match_rows(face_rows(previous.scene), face_rows(scene))
    gone, added = new_number < 0, np.ones(scene.face_count, np.bool_)
    added[new_number[~gone]] = False
    old_cell = match_rows(cell_rows(planes(cells, scene.step)), cell_rows(previous.planes))
    sets = _sets_without(previous, gone, old_cell)
    # A one-sided face hides from behind as well, and is listed for its front only.
    backs = gone & previous.scene.one_sided & ~previous.scene.porous
    sets = _unseeing(Change(previous.scene, backs), cells, sets, settings, _part(progress, 0))
    sets = {cell: np.sort(new_number[faces]).astype(np.uint32) for cell, faces in sets.items()}
    sets = _unseeing(Change(scene, added), cells, sets, settings, _part(progress, 1))
    kept = {cell: Kept(faces, int(previous.proven[old_cell[cell]])) for cell, faces in sets.items()}
    anew = np.setdiff1d(np.arange(cells.count), np.array(list(kept), np.int64))
    findings = {
        "facesRemoved": int(gone.sum()),
        "facesAdded": int(added.sum()),
        "cellsMatched": int((old_cell >= 0).sum()),
        "cellsKept": len(kept),
    }
    logger.info("update: %s", findings)
    return Update(UpdateParameters(previous.sha256), kept, anew, cells.select(anew), findings)


@dataclass(frozen=True)
class Change:
    """Faces of a scene that the other scene does not have."""

    scene: Scene
    faces: NDArray[np.bool_]
    """(F,)."""


Sets = dict[int, NDArray[np.uint32]]
"""Listed faces by the number of the cell in the new complex."""


def _sets_without(previous: Previous, gone: NDArray[np.bool_], old_cell: NDArray[np.int64]) -> Sets:
    """Earlier sets, with their numbers, of the cells of the new complex that list no face that is gone."""
    sets: Sets = {}
    for cell in np.flatnonzero(old_cell >= 0).tolist():
        faces = previous.faces_of(int(old_cell[cell]))
        if not gone[faces].any():
            sets[cell] = faces
    return sets


def _unseeing(
    change: Change, cells: CellComplex, sets: Sets, settings: VisibilitySettings, progress: Progress
) -> Sets:
    """The sets, as numbered in the scene of the change, of cells from which the change is proven hidden."""
    numbers = np.array(list(sets), np.int64)
    outlook = Outlook(cells.select(numbers), list(sets.values()))
    seers = may_see(change.scene, outlook, change.faces, settings, progress)
    return {cell: sets[cell] for cell in numbers[~seers].tolist()}


def _part(progress: Progress, part: int) -> Progress:
    """Progress of one of the two parts of the work."""
    return lambda done, total: progress(part * total + done, 2 * total)


def _no_progress(done: int, total: int) -> None:
    """Default progress: nothing."""
