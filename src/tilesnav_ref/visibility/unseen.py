"""Cells from which some chosen faces may be seen, from either side; from all others they are proven hidden.

Only the chosen faces are decided, so the work grows with their number and not with that of the scene's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from threading import Event

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.processors import thread_count
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.visibility.blocks import Block, make_blocks
from tilesnav_ref.visibility.certify import HIDDEN, Budget, Workspace, decide_face, make_workspace
from tilesnav_ref.visibility.descend import cull
from tilesnav_ref.visibility.geometry import Geometry, build_geometry, fine_frame, to_fine
from tilesnav_ref.visibility.limits import leave_out
from tilesnav_ref.visibility.segments import RANDOM_MODULUS, extremes_see
from tilesnav_ref.visibility.settings import VisibilitySettings


@dataclass(frozen=True)
class Outlook:
    """Cells to ask about, and faces that are likely to be seen from them."""

    lower: NDArray[np.int64]
    """(N, 3) grid coordinates."""
    upper: NDArray[np.int64]
    """(N, 3) grid coordinates."""
    listed: Sequence[NDArray[np.integer]]
    """For each cell numbers of faces that are probably visible; no proof rests on them."""


@dataclass(frozen=True)
class _Run:
    geometry: Geometry
    boxes: NDArray[np.float64]
    listed: Sequence[NDArray[np.integer]]
    settings: VisibilitySettings
    seers: NDArray[np.bool_]
    stop: Event = field(default_factory=Event)

    def workspace(self, block: Block) -> Workspace:
        """Fresh memory: what is found depends on the block alone."""
        work = make_workspace(self.geometry, self.settings.occluder_faces, self.settings.depth)
        words = np.random.SeedSequence([self.settings.seed, block.cells[0], len(block.cells)])
        work.random[0] = 1 + int(words.generate_state(1)[0]) % (RANDOM_MODULUS - 1)
        return work


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
    count = len(outlook.lower)
    seers = np.zeros(count, np.bool_)
    if count == 0 or not faces.any():
        return seers
    two_sided = replace(scene, object_one_sided=np.zeros(0, np.bool_))
    corners = scene.vertices[np.unique(scene.faces)]
    frame = fine_frame(
        np.minimum(corners.min(axis=0), outlook.lower.min(axis=0)),
        np.maximum(corners.max(axis=0), outlook.upper.max(axis=0)),
    )
    geometry = build_geometry(two_sided, frame, settings.max_range)
    boxes = np.stack([to_fine(outlook.lower, frame), to_fine(outlook.upper, frame)], axis=1)
    run = _Run(geometry, boxes, outlook.listed, settings, seers)
    blocks = make_blocks(boxes, np.arange(count), settings.block_cells)
    done = 0
    with ThreadPoolExecutor(thread_count(settings.threads)) as pool:
        try:
            for number in pool.map(lambda block: _ask_block(run, block, faces), blocks):
                done += number
                progress(done, count)
        except BaseException:
            run.stop.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return seers


def _ask_block(run: _Run, block: Block, faces: NDArray[np.bool_]) -> int:
    """Decide all cells of a block; returns their number."""
    if run.stop.is_set():
        raise InterruptedError("visibility was asked to stop")
    alive = faces.copy()
    leave_out(run.geometry, block.box, alive)
    if not alive.any():
        return len(block.cells)
    listed = np.zeros(len(faces), np.bool_)
    for cell in block.cells:
        listed[run.listed[cell]] = True
    listed &= ~faces
    work = run.workspace(block)
    cull(run.geometry, work, block.box, listed, alive)
    if block.halves:
        return sum(_ask_block(run, half, alive) for half in block.halves)
    settings = run.settings
    budget = Budget(settings.attempts, settings.depth, settings.leaf_segments)
    run.seers[block.cells[0]] = _may_see_any(run.geometry, work, run.boxes[block.cells[0]], alive, budget)
    return 1


@kernel
def _may_see_any(geometry, work, cell, alive, budget):  # type: ignore[no-untyped-def]
    """Whether one of the faces `alive` (F,) is not proven hidden from a cell (2, 3).

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
