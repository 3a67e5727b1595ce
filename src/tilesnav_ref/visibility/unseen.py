"""Cells from which some chosen faces may be seen, from either side; from all others they are proven hidden.

Only the chosen faces are decided, so the work grows with their number and not with that of the scene's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.kernels import kernel
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.visibility.blocks import Block, make_blocks
from tilesnav_ref.visibility.certify import HIDDEN, Workspace, decide_face
from tilesnav_ref.visibility.descend import cull
from tilesnav_ref.visibility.engine import Run, random_start
from tilesnav_ref.visibility.limits import leave_out
from tilesnav_ref.visibility.segments import extremes_see
from tilesnav_ref.visibility.settings import VisibilitySettings


@dataclass(frozen=True)
class Outlook:
    """Cells to ask about, and faces that are likely to be seen from them."""

    cells: CellComplex
    listed: Sequence[NDArray[np.integer]]
    """For each cell numbers of faces that are probably visible; no proof rests on them."""


@dataclass(frozen=True)
class _Question:
    """What every thread shares."""

    run: Run
    outlook: Outlook
    seers: NDArray[np.bool_]
    """(N,) the answer."""


def may_see(
    scene: Scene,
    outlook: Outlook,
    faces: NDArray[np.bool_],
    settings: VisibilitySettings,
    progress: Callable[[int, int], None],
) -> NDArray[np.bool_]:
    """Cells from which some of the faces are not proven hidden.

    Parameters
    ----------
    scene : the faces that hide and are hidden; every face counts as seen from both sides.
    outlook : the cells.
    faces : (F,) which faces to decide.
    settings : amount of work, and the range: hidden is also what is seen from beyond it only.
    progress : called with finished and all cells.

    Returns
    -------
    ndarray
        (N,) bool. Where it is False, no segment that is shorter than the range and meets no opaque face
        before its end leads from the open cell to the relative interior of one of the faces.

    Notes
    -----
    The result does not depend on the number of threads.
    """
    count = outlook.cells.count
    seers = np.zeros(count, np.bool_)
    if count == 0 or not faces.any():
        return seers
    two_sided = replace(scene, object_one_sided=np.zeros(0, np.bool_))
    run = Run(two_sided, outlook.cells, settings, progress)
    question = _Question(run, outlook, seers)
    blocks = make_blocks(run.prisms, np.arange(count), settings.block_cells)
    done = 0
    with ThreadPoolExecutor(run.threads) as pool:
        try:
            for number in pool.map(lambda block: _ask(question, block, faces), blocks):
                done += number
                progress(done, count)
        except BaseException:
            run.stop.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return seers


def _ask(question: _Question, block: Block, faces: NDArray[np.bool_]) -> int:
    """Decide all cells of a block for the faces that are not known to be hidden from it; their number."""
    run, outlook, seers = question.run, question.outlook, question.seers
    run.check_stop()
    alive = faces.copy()
    leave_out(run.geometry, block.region, alive)
    if not alive.any():
        return len(block.cells)
    listed = np.zeros(len(faces), np.bool_)
    for cell in block.cells:
        listed[outlook.listed[cell]] = True
    listed &= ~faces
    work = _fresh(run, block)
    cull(run.geometry, work, block.region, listed, alive)
    if block.halves:
        return sum(_ask(question, half, alive) for half in block.halves)
    cell = block.cells[0]
    seers[cell] = _may_see_any(run.geometry, work, run.prisms[cell], alive, run.budget)
    return 1


def _fresh(run: Run, block: Block) -> Workspace:
    """Memory in which nothing is remembered: what is found depends on the block alone."""
    work = run.workspace(0)
    work.random[0] = random_start(run.settings.seed, block)
    return work


@kernel
def _may_see_any(geometry, work, cell, alive, budget):  # type: ignore[no-untyped-def]
    """Whether one of the faces `alive` (F,) is not proven hidden from a cell (8, 3).

    Segments between extreme points come first: one of them that sees a face spares all proofs.
    """
    for k in range(len(geometry.face_order)):
        face = geometry.face_order[k]
        if alive[face] and extremes_see(geometry, cell, geometry.corners[face], face):
            return True
    for k in range(len(geometry.face_order)):
        face = geometry.face_order[k]
        if alive[face] and decide_face(geometry, work, cell, face, budget) != HIDDEN:
            return True
    return False
