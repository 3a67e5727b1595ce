"""Conservative potentially visible sets of all cells.

Rays prove faces visible; certificates prove faces hidden, for blocks of cells first, then for each cell,
top-down over the box hierarchy, face by face at its leaves. A face that neither side decides is kept.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import repeat
from queue import SimpleQueue
from threading import Event

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.processors import thread_count
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.visibility.blocks import Block, make_blocks
from tilesnav_ref.visibility.certify import RANDOM_MODULUS, REASONS, Budget, Workspace, make_workspace
from tilesnav_ref.visibility.descend import cull, decide
from tilesnav_ref.visibility.geometry import FineFrame, Geometry, build_geometry, fine_frame, to_fine
from tilesnav_ref.visibility.model import PvsTable
from tilesnav_ref.visibility.sampling import RayCaster, sample_cell
from tilesnav_ref.visibility.settings import VisibilitySettings

logger = logging.getLogger(__name__)

Progress = Callable[[int, int], None]
"""Called with the number of finished cells and of all cells."""


@dataclass(frozen=True)
class _Seen:
    """What was found out about one cell."""

    faces: NDArray[np.uint32]
    proven: NDArray[np.bool_]
    reasons: NDArray[np.int64]


@dataclass(frozen=True)
class _Task:
    """What every thread shares, read only."""

    geometry: Geometry
    caster: RayCaster
    boxes: NDArray[np.float64]
    settings: VisibilitySettings
    stop: Event
    """Set when the run is to end; looked at before every cell."""

    def budget(self) -> Budget:
        return Budget(self.settings.attempts, self.settings.depth, self.settings.leaf_segments)

    def workspace(self) -> Workspace:
        return make_workspace(self.geometry, self.settings.occluder_faces, self.settings.depth)


def compute_pvs(
    scene: Scene,
    cells: CellComplex,
    settings: VisibilitySettings | None = None,
    progress: Progress | None = None,
) -> PvsTable:
    """Potentially visible set of every cell.

    Parameters
    ----------
    scene : the faces that are published.
    cells : box cells whose interiors meet no face.
    settings : amount of work; every choice is conservative.
    progress : called after each finished block of cells.

    Returns
    -------
    PvsTable
        Every face that is visible from a cell (spec, "Visibility") is listed for it.

    Notes
    -----
    The same scene, cells and settings give the same table on any number of threads.
    """
    settings = settings or VisibilitySettings()
    if cells.count == 0:
        return _gather([])
    frame = _common_frame(scene, cells)
    geometry = build_geometry(scene, frame)
    boxes = np.stack([to_fine(cells.lower, frame), to_fine(cells.upper, frame)], axis=1)
    task = _Task(geometry, RayCaster(geometry, frame), boxes, settings, Event())
    blocks = make_blocks(boxes, settings.block_cells)
    logger.info("visibility: %d cells in %d blocks, %d faces", cells.count, len(blocks), scene.face_count)
    return _gather(_run(task, blocks, progress or _no_progress))


def _no_progress(done: int, total: int) -> None:
    """Default progress: nothing."""


def _common_frame(scene: Scene, cells: CellComplex) -> FineFrame:
    corners = scene.vertices[np.unique(scene.faces)]
    low = np.minimum(corners.min(axis=0), cells.lower.min(axis=0))
    high = np.maximum(corners.max(axis=0), cells.upper.max(axis=0))
    return fine_frame(low, high)


def _run(task: _Task, blocks: list[Block], progress: Progress) -> list[_Seen]:
    threads = thread_count(task.settings.threads)
    spare: SimpleQueue[Workspace] = SimpleQueue()
    for _ in range(threads):
        spare.put(task.workspace())
    found: dict[int, _Seen] = {}
    with ThreadPoolExecutor(threads) as pool:
        try:
            for part in pool.map(_see_block, repeat(task), blocks, repeat(spare)):
                found.update(part)
                progress(len(found), len(task.boxes))
        except BaseException:
            task.stop.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return [found[i] for i in range(len(task.boxes))]


def _see_block(task: _Task, block: Block, spare: SimpleQueue[Workspace]) -> dict[int, _Seen]:
    work = spare.get()
    try:
        proven = {cell: _sample(task, cell) for cell in block.cells}
        found: dict[int, _Seen] = {}
        alive = np.ones(len(task.geometry.corners), np.bool_)
        _see(task, work, (block, alive, proven), found)
        return found
    finally:
        spare.put(work)


def _sample(task: _Task, cell: int) -> NDArray[np.bool_]:
    _check_stop(task)
    random = np.random.default_rng([task.settings.seed, cell])
    return sample_cell(task.geometry, task.caster, task.boxes[cell], task.settings.rays, random)


def _check_stop(task: _Task) -> None:
    if task.stop.is_set():
        raise InterruptedError("visibility was asked to stop")


State = tuple[Block, NDArray[np.bool_], dict[int, NDArray[np.bool_]]]


def _see(task: _Task, work: Workspace, state: State, found: dict[int, _Seen]) -> None:
    """Cull the faces hidden from a block, then go on with its halves, and decide each single cell."""
    _check_stop(task)
    block, alive, proven = state
    alive = alive.copy()
    work.random[0] = _random_start(task.settings.seed, block)
    if not block.halves:
        cell = block.cells[0]
        found[cell] = _decide_cell(task, work, cell, alive, proven[cell])
        return
    seen = np.logical_or.reduce([proven[cell] for cell in block.cells])
    cull(task.geometry, work, block.box, seen, alive)
    for half in block.halves:
        _see(task, work, (half, alive, proven), found)


def _random_start(seed: int, block: Block) -> int:
    """A start that depends on the block alone, not on the thread that happens to treat it."""
    words = np.random.SeedSequence([seed, block.cells[0], len(block.cells)]).generate_state(1)
    return 1 + int(words[0]) % (RANDOM_MODULUS - 1)


def _decide_cell(
    task: _Task, work: Workspace, cell: int, alive: NDArray[np.bool_], proven: NDArray[np.bool_]
) -> _Seen:
    reasons = np.zeros(len(REASONS), np.int64)
    decide(task.geometry, work, task.boxes[cell], (proven, alive, reasons), task.budget())
    faces = np.flatnonzero(alive).astype(np.uint32)
    return _Seen(faces, proven[faces], reasons)


def _gather(seen: list[_Seen]) -> PvsTable:
    offsets = np.zeros(len(seen) + 1, np.int64)
    np.cumsum([len(s.faces) for s in seen], out=offsets[1:])
    reasons = np.sum([s.reasons for s in seen], axis=0) if seen else np.zeros(len(REASONS), np.int64)
    return PvsTable(
        offsets,
        np.concatenate([s.faces for s in seen]) if seen else np.zeros(0, np.uint32),
        np.concatenate([s.proven for s in seen]) if seen else np.zeros(0, np.bool_),
        {REASONS[i]: int(reasons[i]) for i in range(1, len(REASONS)) if reasons[i]},
    )
