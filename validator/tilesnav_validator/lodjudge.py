"""Level codes against bounds of the largest L, for every object of every cell."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator import lodbounds, ragged
from tilesnav_validator.lodbounds import ROUNDING, FloatArray, IntArray, Pairs
from tilesnav_validator.tables import Tables

STEPS = 200
"""Most steps of a bound; of random pairs one in a thousand needs more than 30."""

_PORTION = 100_000


@dataclass(frozen=True)
class Scale:
    """The scale of level codes.

    Attributes
    ----------
    reference : float
        1/m.
    base : float
    level_count : int
    """

    reference: float
    base: float
    level_count: int

    def ceiling(self, codes: NDArray[np.uint8]) -> FloatArray:
        """Largest L, 1/m, for which a code is not too large; infinite for code 0."""
        return np.where(codes == 0, np.inf, self.reference * self.base ** -codes.astype(np.float64))

    def floor(self, codes: NDArray[np.uint8]) -> FloatArray:
        """An L, 1/m, at and below which a code is too small; 0 where no code is."""
        after = codes.astype(np.float64) + 2
        return np.where(after < self.level_count, self.reference * self.base**-after, 0.0)


@dataclass(frozen=True)
class Fault:
    """A code that is certainly wrong; the largest L is from ``low`` to ``high``, and ``limit`` is what it
    crosses."""

    cell: int
    entry: int
    low: float
    high: float
    limit: float


@dataclass(frozen=True)
class Levels:
    """What was found out about the codes.

    Attributes
    ----------
    coarse, wasteful : list of Fault
    cells, of_cells : int
        Cells looked at, and all sound cells.
    open_coarse, open_wasteful : int
        Entries that the bounds could not decide.
    """

    coarse: list[Fault]
    wasteful: list[Fault]
    cells: int
    of_cells: int
    open_coarse: int
    open_wasteful: int


@dataclass(frozen=True)
class Scene:
    """What the codes are judged by: vertices of cells (n, v, 3), faces (f, 3, 3), objects (f,), sound faces
    (f,)."""

    vertices: FloatArray
    triangles: FloatArray
    objects: IntArray
    sound: NDArray[np.bool_]


def pick_cells(tables: Tables, sound: NDArray[np.bool_], most_pairs: int, seed: int) -> IntArray:
    """Cells to look at: all sound ones, or a seeded choice with at most ``most_pairs`` pairs of cell and
    face."""
    cells = np.flatnonzero(sound).astype(np.int64)
    pairs = np.diff(tables.faces.offsets)
    if pairs[cells].sum() <= most_pairs:
        return cells
    shuffled = np.random.Generator(np.random.SFC64([seed, 2])).permutation(cells)
    return np.sort(shuffled[: max(1, int(np.searchsorted(np.cumsum(pairs[shuffled]), most_pairs)))])


def judge(
    tables: Tables, scene: Scene, scale: Scale, cells: IntArray
) -> tuple[list[Fault], list[Fault], int, int]:
    """Compare the codes of cells with bounds of L.

    Returns
    -------
    coarse, wasteful : list of Fault
    open_coarse, open_wasteful : int
        Numbers of entries that stay undecided.
    """
    coarse: list[Fault] = []
    wasteful: list[Fault] = []
    open_coarse = open_wasteful = 0
    for portion in _portions(tables, cells):
        work = _Portion(tables, scene, scale, portion)
        faults, undecided = work.too_coarse()
        coarse += faults
        open_coarse += undecided
        faults, undecided = work.too_fine()
        wasteful += faults
        open_wasteful += undecided
    return coarse, wasteful, open_coarse, open_wasteful


def _portions(tables: Tables, cells: IntArray) -> Iterator[IntArray]:
    """Runs of cells with a bounded number of pairs."""
    if len(cells):
        total = np.cumsum(np.diff(tables.faces.offsets)[cells])
        yield from np.split(cells, np.flatnonzero(np.diff(total // _PORTION)) + 1)


class _Portion:
    """Pairs of some cells and the faces in their PVS, each side of a face for itself."""

    def __init__(self, tables: Tables, scene: Scene, scale: Scale, cells: IntArray) -> None:
        row, index = ragged.take(tables.faces.offsets, cells)
        face = tables.faces.values[index].astype(np.int64)
        row, face = row[scene.sound[face]], face[scene.sound[face]]
        listed_row, self.entries = ragged.take(tables.objects.offsets, cells)
        self.cells = cells[listed_row]
        width = len(scene.objects) + 1
        listed = listed_row * width + tables.objects.values[self.entries]
        entry = np.searchsorted(listed, row * width + scene.objects[face])
        triangles = scene.triangles[face]
        normals = lodbounds.unit_normals(triangles)
        vertices = scene.vertices[cells[row]]
        sides = [Pairs(vertices, triangles, sign * normals) for sign in (1.0, -1.0)]
        found = [(side, *lodbounds.rough(side)) for side in sides]
        above = [np.flatnonzero(top > 0) for _, _, _, top in found]
        self.pairs = [side.at(keep) for (side, *_), keep in zip(found, above, strict=True)]
        self.low = np.concatenate([low[keep] for (_, low, _, _), keep in zip(found, above, strict=True)])
        self.high = np.concatenate([high[keep] for (_, _, high, _), keep in zip(found, above, strict=True)])
        self.entry = np.concatenate([entry[keep] for keep in above])
        codes = tables.codes.values[self.entries]
        self.ceiling, self.floor = scale.ceiling(codes), scale.floor(codes)

    def _refine(self, chosen: IntArray, threshold: FloatArray) -> None:
        """Tighten the bounds of chosen pairs, numbered over both sides."""
        first = len(self.pairs[0].normals)
        for side, start in ((0, 0), (1, first)):
            mine = chosen[(chosen >= start) & (chosen < start + len(self.pairs[side].normals))]
            if len(mine):
                some = self.pairs[side].at(mine - start)
                low, high = lodbounds.refine(some, threshold[self.entry[mine]], STEPS)
                self.low[mine], self.high[mine] = low, high

    def _bounds(self) -> tuple[FloatArray, FloatArray]:
        """Bounds of the largest L of each entry."""
        low, high = np.zeros(len(self.entries)), np.zeros(len(self.entries))
        np.maximum.at(low, self.entry, self.low)
        np.maximum.at(high, self.entry, self.high)
        return low, high

    def _faults(self, wrong: NDArray[np.bool_], limit: FloatArray) -> list[Fault]:
        low, high = self._bounds()
        return [
            Fault(int(self.cells[i]), int(self.entries[i]), float(low[i]), float(high[i]), float(limit[i]))
            for i in np.flatnonzero(wrong)
        ]

    def too_coarse(self) -> tuple[list[Fault], int]:
        """Entries whose code is certainly too large, and the number that stays undecided."""
        limit = self.ceiling * (1 + 2 * ROUNDING)
        self._refine(np.flatnonzero(self.high > limit[self.entry]), limit)
        low, high = self._bounds()
        return self._faults(low > limit, self.ceiling), int(((high > limit) & (low <= limit)).sum())

    def too_fine(self) -> tuple[list[Fault], int]:
        """Entries whose code is certainly too small, and the number that stays undecided."""
        limit = self.floor * (1 - 2 * ROUNDING)
        low, _ = self._bounds()
        doubtful = low <= limit
        self._refine(np.flatnonzero(doubtful[self.entry] & (self.high > limit[self.entry])), limit)
        low, high = self._bounds()
        return self._faults(high < limit, self.floor), int(
            ((high >= limit) & (low <= limit) & (limit > 0)).sum()
        )
