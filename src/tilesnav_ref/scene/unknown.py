"""Space of which a survey says nothing: neither free nor occupied."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class UnknownSpace:
    """Blocks of space between cuts along the axes, each known to be free or not.

    Notes
    -----
    Whatever lies beside the cuts or below them is unknown. "Known" means that nothing was found there that
    the survey could have found; where faces are says the scene.
    """

    cuts: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]
    """Ascending grid coordinates along x, y and z; two or more of each."""
    unknown: NDArray[np.bool_]
    """(nx, ny, nz) one less than there are cuts."""
    open_above: bool
    """Whether all space above the cuts is known to be free, as for a survey from the air."""

    def __post_init__(self) -> None:
        """Check that cuts and blocks fit: ValueError."""
        if self.unknown.shape != tuple(len(cut) - 1 for cut in self.cuts):
            raise ValueError(f"{self.unknown.shape} blocks between {[len(cut) for cut in self.cuts]} cuts")

    def holds(self, points: NDArray[np.int64], parts: int = 1) -> NDArray[np.bool_]:
        """Whether points (N, 3), in grid steps divided by `parts`, are in unknown space; (N,)."""
        places = [self._blocks(points[:, k], k, parts) for k in range(3)]
        return np.asarray(self._bordered[places[0], places[1], places[2]])

    def holds_lattice(self, axes: tuple[NDArray[np.int64], ...], parts: int = 1) -> NDArray[np.bool_]:
        """The same for all points of a lattice, given by its coordinates along x, y and z."""
        places = [self._blocks(axes[k], k, parts) for k in range(3)]
        return np.asarray(self._bordered[np.ix_(*places)])

    @cached_property
    def _bordered(self) -> NDArray[np.bool_]:
        """The blocks with what is around them."""
        bordered = np.pad(self.unknown, 1, constant_values=True)
        if self.open_above:
            bordered[1:-1, 1:-1, -1] = False
        return bordered

    def _blocks(self, values: NDArray[np.int64], axis: int, parts: int) -> NDArray[np.int64]:
        return np.searchsorted(self.cuts[axis] * parts, values, side="right")

    def border(self) -> NDArray[np.int64]:
        """Triangles (T, 3, 3) between what is known and what is not, in grid coordinates.

        Notes
        -----
        An open convex set that meets none of them is in known space as a whole, or in unknown space. The
        unbounded sides of what is around the blocks are not among them: above an open roof the blocks end at
        the topmost cut, and beside them nothing is known.
        """
        rectangles = []
        bordered = self._bordered
        for axis in range(3):
            layers = np.moveaxis(bordered, axis, 0)
            i, j = (k for k in range(3) if k != axis)
            for place in range(len(self.cuts[axis])):
                mask = layers[place] != layers[place + 1]
                rectangles += [
                    self._rectangle(axis, place, (i, j), spans) for spans in _rectangles(mask[1:-1, 1:-1])
                ]
        corners = np.array(rectangles, np.int64).reshape(-1, 4, 3)
        return np.concatenate((corners[:, :3], corners[:, [0, 2, 3]]))

    def _rectangle(
        self, axis: int, place: int, others: tuple[int, int], spans: tuple[int, int, int, int]
    ) -> list[list[int]]:
        (i, j), (a, b, c, d) = others, spans
        first, second = (self.cuts[i][a], self.cuts[i][b]), (self.cuts[j][c], self.cuts[j][d])
        corners = np.zeros((4, 3), np.int64)
        corners[:, axis] = self.cuts[axis][place]
        corners[:, i] = (first[0], first[1], first[1], first[0])
        corners[:, j] = (second[0], second[0], second[1], second[1])
        return corners.tolist()

    def share(self) -> float:
        """Part of the volume between the cuts, without the sky, that is unknown."""
        sizes = [np.diff(cut).astype(np.float64) for cut in self.cuts]
        if self.open_above:
            sizes[2][-1] = 0.0  # the sky
        volumes = sizes[0][:, None, None] * sizes[1][:, None] * sizes[2]
        return float(volumes[self.unknown].sum() / volumes.sum())


def _rectangles(mask: NDArray[np.bool_]) -> list[tuple[int, int, int, int]]:
    """Disjoint rectangles (i0, i1, j0, j1) that cover a mask: runs along j, joined along i where alike."""
    found: list[tuple[int, int, int, int]] = []
    pending: dict[tuple[int, int], int] = {}
    for i in range(len(mask) + 1):
        row = mask[i] if i < len(mask) else np.zeros(mask.shape[1], np.bool_)
        if not row.any() and not pending:
            continue
        changes = np.flatnonzero(np.diff(np.pad(row.astype(np.int8), 1)))
        runs = {(int(j0), int(j1)) for j0, j1 in changes.reshape(-1, 2)}
        for run in [run for run in pending if run not in runs]:
            found.append((pending.pop(run), i, *run))
        for run in sorted(runs - pending.keys()):
            pending[run] = i
    return found
