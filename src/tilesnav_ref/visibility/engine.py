"""Conservative potentially visible sets of all cells.

Rays prove faces visible, for all cells that they cross. Certificates prove faces hidden, for blocks of cells
first, then for each cell; top-down over the box hierarchy, then face by face. A face that neither side
decides is kept.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import repeat
from pathlib import Path
from queue import SimpleQueue
from threading import Event

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.kernels import package_digest
from tilesnav_ref.processors import thread_count
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.visibility.backs import find_inner_sides
from tilesnav_ref.visibility.blocks import Block, make_blocks, make_groups
from tilesnav_ref.visibility.certificates import Certificates, Proofs
from tilesnav_ref.visibility.certify import REASONS, Budget, Workspace, forget, make_workspace
from tilesnav_ref.visibility.descend import cull, cull_backs, cull_faces, decide
from tilesnav_ref.visibility.geometry import FineFrame, build_geometry, fine_frame, to_fine
from tilesnav_ref.visibility.journal import Journal, digest_of
from tilesnav_ref.visibility.limits import leave_out
from tilesnav_ref.visibility.model import PvsTable
from tilesnav_ref.visibility.prisms import check_prisms
from tilesnav_ref.visibility.record import is_full, take
from tilesnav_ref.visibility.results import Seen, Sight, from_arrays, to_arrays
from tilesnav_ref.visibility.sampling import RayCaster
from tilesnav_ref.visibility.segments import RANDOM_MODULUS
from tilesnav_ref.visibility.settings import VisibilitySettings
from tilesnav_ref.visibility.sight import make_crossed
from tilesnav_ref.visibility.survey import make_survey, run_survey
from tilesnav_ref.visibility.units import divide

logger = logging.getLogger(__name__)

Progress = Callable[[int, int], None]
"""Called with finished and all steps of the work."""


FIRST_WORDS = 1 << 20
"""Words for the proofs of one call, to begin with."""
LEVELS = 3
"""Blocks are treated on every such level of their tree, and single cells always."""
DECISION = 8
"""Weight of deciding a cell in the progress, where a round of lines has weight 1."""


class Run:
    """One call: what every thread shares, and memory for the threads."""

    def __init__(
        self, scene: Scene, cells: CellComplex, settings: VisibilitySettings, progress: Progress
    ) -> None:
        self.journal = Journal(None)
        self.frame = frame = _common_frame(scene, cells)
        self.settings = settings
        self.cells = cells
        self.geometry = build_geometry(scene, frame, settings.max_range)
        self.division = divide(self.geometry, scene.faces)
        find_inner_sides(self.geometry, self.division, make_crossed(1))
        self.caster = RayCaster(self.geometry, frame)
        check_prisms(cells.corners)
        self.prisms = to_fine(cells.corners, frame)
        self.budget = Budget(settings.attempts, settings.depth, settings.leaf_segments)
        self.stop = Event()
        self.threads = thread_count(settings.threads)
        self.spare: SimpleQueue[Workspace] = SimpleQueue()
        for _ in range(self.threads):
            self.spare.put(self.workspace(FIRST_WORDS if settings.certificates else 0))
        self._progress = progress
        self._done = 0

    def workspace(self, words: int) -> Workspace:
        """Memory for a thread, with so many words for proofs."""
        return make_workspace(
            (self.geometry, self.division), self.settings.occluder_faces, self.settings.depth, words
        )

    def advance(self, steps: int) -> None:
        """Count finished steps; only one thread calls this."""
        self._done += steps
        self._progress(self._done, self.cells.count * (1 + self.settings.aimed_rounds + DECISION))

    def check_stop(self) -> None:
        """End the work of a thread when the run is to end."""
        if self.stop.is_set():
            raise InterruptedError("visibility was asked to stop")


def compute_pvs(
    scene: Scene,
    cells: CellComplex,
    settings: VisibilitySettings | None = None,
    progress: Progress | None = None,
    work: Path | None = None,
) -> PvsTable:
    """Potentially visible set of every cell.

    Parameters
    ----------
    scene : the faces that are published.
    cells : cells whose interiors meet no face.
    settings : amount of work; every choice is conservative.
    progress : called with finished and all steps.
    work : folder where finished parts are kept until `forget_work`. What a run that was stopped has left
        there is taken over, if scene, cells, settings and program are the same.

    Returns
    -------
    PvsTable
        Every face that is visible from a cell (spec, "Visibility") is listed for it.

    Notes
    -----
    The same scene, cells and settings give the same table on any number of threads.
    """
    settings = settings or VisibilitySettings()
    if settings.certificates and (settings.max_range is not None or scene.one_sided.any()):
        raise ValueError("certificates: found one-sided faces or a range, of which there are no proofs")
    if cells.count == 0:
        return _gather([])
    run = Run(scene, cells, settings, progress or _no_progress)
    if work is not None:
        run.journal = Journal(work, _digest(scene, cells, settings))
    groups = make_groups(run.prisms, np.arange(cells.count), max(1, settings.pairs // scene.face_count))
    logger.info("visibility: %d cells in %d groups, %d faces", cells.count, len(groups), scene.face_count)
    found = Sight()
    with ThreadPoolExecutor(run.threads) as pool:
        try:
            for group in groups:
                _see_group(run, pool, np.sort(group), found)
        except BaseException:
            run.stop.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    table = _gather([found.cells[i] for i in range(cells.count)])
    if not settings.certificates:
        return table
    return replace(table, certificates=Certificates(run.frame, cells.count, found.proofs))


def forget_work(scene: Scene, cells: CellComplex, settings: VisibilitySettings, work: Path) -> None:
    """Remove the parts that `compute_pvs` has kept for these arguments; their results are safe elsewhere."""
    Journal(work, _digest(scene, cells, settings)).forget()


def _digest(scene: Scene, cells: CellComplex, settings: VisibilitySettings) -> str:
    """Digest of all that the table depends on."""
    program = package_digest(Path(__file__).parent)
    texts = (program, repr(replace(settings, threads=0)), str(scene.grid_exponent))
    faces = (scene.vertices, scene.faces, scene.porous, scene.one_sided)
    return digest_of((*texts, *faces, cells.corners, cells.portal_offsets, cells.portal_targets))


def _no_progress(done: int, total: int) -> None:
    """Default progress: nothing."""


def _common_frame(scene: Scene, cells: CellComplex) -> FineFrame:
    corners = scene.vertices[np.unique(scene.faces)]
    low = np.minimum(corners.min(axis=0), cells.lower.min(axis=0))
    high = np.maximum(corners.max(axis=0), cells.upper.max(axis=0))
    return fine_frame(low, high)


def _see_group(run: Run, pool: ThreadPoolExecutor, group: NDArray[np.int64], found: Sight) -> None:
    """Survey a group of cells (ascending numbers), then decide what the survey has not seen."""

    def each(work: Callable[[int], None], numbers: Iterable[int]) -> None:
        def stoppable(number: int) -> None:
            run.check_stop()
            work(number)

        for _ in pool.map(stoppable, numbers):
            run.advance(1)

    survey = make_survey((run.geometry, run.caster), run.cells, run.prisms, group, run.settings)
    kept = run.journal.load(f"survey-{group[0]}")
    if kept is None:
        run_survey(survey, each)
        run.journal.save(f"survey-{group[0]}", {"seen": np.packbits(survey.seen, axis=None)})
    else:
        survey.seen.flat[:] = np.unpackbits(np.asarray(kept["seen"], np.uint8), count=survey.seen.size)
        run.advance(len(group) * (1 + run.settings.aimed_rounds))
    proven = {int(cell): survey.seen[row].view(np.bool_) for row, cell in enumerate(group)}
    blocks = make_blocks(run.prisms, group, run.settings.block_cells)
    for part in pool.map(_see_block, repeat(run), blocks, repeat(proven)):
        found.cells.update(part.cells)
        found.proofs.extend(part.proofs)
        run.advance(DECISION * len(part.cells))


def _see_block(run: Run, block: Block, proven: dict[int, NDArray[np.bool_]]) -> Sight:
    name = f"block-{block.cells[0]}"
    kept = run.journal.load(name)
    if kept is not None:
        return from_arrays(kept)
    found = _work_on_block(run, block, proven)
    run.journal.save(name, to_arrays(found))
    return found


def _work_on_block(run: Run, block: Block, proven: dict[int, NDArray[np.bool_]]) -> Sight:
    work = run.spare.get()
    try:
        while True:
            found = Sight()
            alive = np.ones(len(run.geometry.corners), np.bool_)
            forget(work)
            _see(run, work, (block, alive, proven, 0), found)
            if not is_full(work.record):
                return found
            # The block is done anew with more room: the same random numbers lead to the same proofs.
            work = run.workspace(2 * len(work.record.words))
    finally:
        run.spare.put(work)


State = tuple[Block, NDArray[np.bool_], dict[int, NDArray[np.bool_]], int]
"""Block, faces that are not known to be hidden from it, faces seen from cells, level in the tree."""


def _see(run: Run, work: Workspace, state: State, found: Sight) -> None:
    """Cull the faces hidden from a block, then go on with its halves, and decide each single cell."""
    run.check_stop()
    block, alive, proven, level = state
    alive = alive.copy()
    leave_out(run.geometry, block.region, alive)
    work.random[0] = random_start(run.settings.seed, block)
    if not block.halves:
        cell = block.cells[0]
        found.cells[cell] = _decide_cell(run, work, cell, alive, proven[cell].copy())
        _keep_proofs(work, block, found)
        return
    if level % LEVELS == 0:
        seen = np.logical_or.reduce([proven[cell] for cell in block.cells])
        cull_backs(run.geometry, work, block.region, seen, alive)
        cull(run.geometry, work, block.region, seen, alive)
        cull_faces(run.geometry, work, block.region, seen, alive)
        _keep_proofs(work, block, found)
    for half in block.halves:
        _see(run, work, (half, alive, proven, level + 1), found)


def _keep_proofs(work: Workspace, block: Block, found: Sight) -> None:
    if len(work.record.words) and not is_full(work.record):
        found.proofs.append(Proofs(block.cells, block.region, take(work.record)))


def random_start(seed: int, block: Block) -> int:
    """A start that depends on the block alone, not on the thread that happens to treat it."""
    words = np.random.SeedSequence([seed, block.cells[0], len(block.cells)]).generate_state(1)
    return 1 + int(words[0]) % (RANDOM_MODULUS - 1)


def _decide_cell(
    run: Run, work: Workspace, cell: int, alive: NDArray[np.bool_], proven: NDArray[np.bool_]
) -> Seen:
    reasons = np.zeros(len(REASONS), np.int64)
    decide(run.geometry, work, run.prisms[cell], (proven, alive, reasons), run.budget)
    faces = np.flatnonzero(alive).astype(np.uint32)
    return Seen(faces, proven[faces], reasons)


def _gather(seen: list[Seen]) -> PvsTable:
    offsets = np.zeros(len(seen) + 1, np.int64)
    np.cumsum([len(s.faces) for s in seen], out=offsets[1:])
    reasons = np.sum([s.reasons for s in seen], axis=0) if seen else np.zeros(len(REASONS), np.int64)
    return PvsTable(
        offsets,
        np.concatenate([s.faces for s in seen]) if seen else np.zeros(0, np.uint32),
        np.concatenate([s.proven for s in seen]) if seen else np.zeros(0, np.bool_),
        {REASONS[i]: int(reasons[i]) for i in range(1, len(REASONS)) if reasons[i]},
    )
