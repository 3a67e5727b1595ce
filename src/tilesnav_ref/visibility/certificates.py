"""Proofs that faces are hidden from cells, as tables (spec, "Certificates")."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.visibility.geometry import FineFrame


@dataclass(frozen=True)
class Proofs:
    """Proofs that hold for a region and hence for some cells, as recorded (record.py)."""

    cells: tuple[int, ...]
    region: NDArray[np.float64]
    """(8, 3) corners in fine units, whole numbers, of a box or a prism over a trapezoid; corner i is on the
    upper side of axis k where bit k of i is set."""
    words: NDArray[np.int32]


@dataclass(frozen=True)
class Certificates:
    """All proofs of a run."""

    frame: FineFrame
    cell_count: int
    proofs: list[Proofs]

    def tables(self, first: int, last: int) -> CertificateTables:
        """Tables of the proofs that the cells first, ..., last - 1 use."""
        return _tables([p for p in self.proofs if any(first <= c < last for c in p.cells)], first, last)


@dataclass(frozen=True)
class CertificateTables:
    """The tables of a certificate file; names, types and meaning are those of the spec."""

    cell_offsets: NDArray[np.int64]
    uses: NDArray[np.int64]
    regions: NDArray[np.int64]
    shapes: NDArray[np.uint8]
    target_offsets: NDArray[np.int64]
    targets: NDArray[np.int32]
    cut_offsets: NDArray[np.int64]
    cuts: NDArray[np.uint8]
    leaves: NDArray[np.int64]
    occluder_offsets: NDArray[np.int64]
    occluders: NDArray[np.int32]


@dataclass(frozen=True)
class _Parsed:
    """What the words of `Proofs` hold; ragged arrays with their lengths."""

    target_counts: NDArray[np.int32]
    targets: NDArray[np.int32]
    cut_counts: NDArray[np.int32]
    cuts: NDArray[np.int32]
    sizes: NDArray[np.int32]
    faces: NDArray[np.int32]


def _parse(words: NDArray[np.int32]) -> _Parsed:
    return _Parsed(*_split(words))


@kernel
def _split(words):  # type: ignore[no-untyped-def]
    """Numbers of targets, targets, numbers of codes, codes, sizes of occluders, their faces (ascending)."""
    room = len(words)
    target_counts, targets = np.empty(room, np.int32), np.empty(room, np.int32)
    cut_counts, cuts = np.empty(room, np.int32), np.empty(room, np.int32)
    sizes, faces = np.empty(room, np.int32), np.empty(room, np.int32)
    proofs, used_targets, used_cuts, leaves, used_faces = 0, 0, 0, 0, 0
    at = 0
    while at < room:
        number = words[at]
        target_counts[proofs] = number
        targets[used_targets : used_targets + number] = words[at + 1 : at + 1 + number]
        used_targets += number
        end = at + 2 + number + words[at + 1 + number]
        at += 2 + number
        before = used_cuts
        while at < end:
            word = words[at]
            at += 1
            cuts[used_cuts] = max(-word, 0)
            used_cuts += 1
            if word > 0:
                faces[used_faces : used_faces + word] = np.sort(words[at : at + word])
                sizes[leaves] = word
                used_faces += word
                leaves += 1
                at += word
        cut_counts[proofs] = used_cuts - before
        proofs += 1
    return (
        target_counts[:proofs].copy(),
        targets[:used_targets].copy(),
        cut_counts[:proofs].copy(),
        cuts[:used_cuts].copy(),
        sizes[:leaves].copy(),
        faces[:used_faces].copy(),
    )


_SHAPES = {(0, 1): 1, (1, 2): 2, (2, 0): 3, (0, 2): 4, (1, 0): 5, (2, 1): 6}
"""Shape of a region by its run axis u and its slanted axis v."""


def region_form(corners: NDArray[np.float64]) -> tuple[list[int], int]:
    """Numbers and shape of a region as they are written.

    Parameters
    ----------
    corners : ndarray of float64, shape (8, 3)
        As in `Proofs.region`.

    Returns
    -------
    numbers : list of int
        Lower corner, upper corner, p and q; p and q are 0 for a box.
    shape : int
        0 for a box, 1 to 6 by the axes u and v.

    Raises
    ------
    ValueError
        When the corners are those of no box and no prism over a trapezoid.
    """
    points: list[list[int]] = [[int(x) for x in corner] for corner in corners]
    box = [*points[0], *points[7], 0, 0]
    if _corners_of(box, None) == points:
        return box, 0
    for (u, v), shape in _SHAPES.items():
        far, near = 1 << u, 7 - (1 << u)
        row = [*points[0], *points[7], points[far][v], points[7][v]]
        row[3 + v] = points[near][v]
        if _corners_of(row, (u, v)) == points:
            return row, shape
    raise ValueError(f"region {points}: no box and no prism over a trapezoid")


def _corners_of(row: list[int], axes: tuple[int, int] | None) -> list[list[int]]:
    """Corners of a region by its numbers and its axes u and v; a box has none."""
    corners = [[row[k + 3 * (i >> k & 1)] for k in range(3)] for i in range(8)]
    if axes:
        u, v = axes
        for i in range(8):
            if i >> u & 1:
                corners[i][v] = row[6 + (i >> v & 1)]
    return corners


def _tables(proofs: list[Proofs], first: int, last: int) -> CertificateTables:
    parsed = [_parse(p.words) for p in proofs]
    counts = np.array([len(p.target_counts) for p in parsed], np.int64)
    cell_offsets, uses = _uses(proofs, counts, (first, last))
    forms = [region_form(p.region) for p in proofs]
    regions = np.array([row for row, _ in forms], np.int64).reshape(-1, 8)
    leaves, offsets, occluders = _distinct(parsed)
    return CertificateTables(
        cell_offsets,
        uses,
        np.repeat(regions, counts, axis=0),
        np.repeat(np.array([shape for _, shape in forms], np.uint8), counts),
        _offsets(_joined([p.target_counts for p in parsed])),
        _joined([p.targets for p in parsed]),
        _offsets(_joined([p.cut_counts for p in parsed])),
        _joined([p.cuts for p in parsed]).astype(np.uint8),
        leaves,
        offsets,
        occluders,
    )


def _uses(
    proofs: list[Proofs], counts: NDArray[np.int64], cells: tuple[int, int]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Offsets and ascending certificates of each cell; `counts` (P,) is the number in each of the proofs."""
    first, last = cells
    ends = np.cumsum(counts)
    uses: list[list[NDArray[np.int64]]] = [[np.zeros(0, np.int64)] for _ in range(first, last)]
    for proof, begin, end in zip(proofs, ends - counts, ends, strict=True):
        for cell in proof.cells:
            if first <= cell < last:
                uses[cell - first].append(np.arange(begin, end))
    joined = [np.concatenate(of_cell) for of_cell in uses]
    return _offsets(np.array([len(of_cell) for of_cell in joined])), np.concatenate(joined)


def _distinct(
    parsed: list[_Parsed],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int32]]:
    """Occluder of each leaf, and the different occluders in the order in which they come first."""
    numbers: dict[bytes, int] = {}
    leaves: list[int] = []
    for one in parsed:
        ends = np.cumsum(one.sizes, dtype=np.int64)
        data = one.faces.tobytes()
        for begin, end in zip((ends - one.sizes).tolist(), ends.tolist(), strict=True):
            leaves.append(numbers.setdefault(data[4 * begin : 4 * end], len(numbers)))
    sizes = np.array([len(key) // 4 for key in numbers], np.int64)
    return np.array(leaves, np.int64), _offsets(sizes), np.frombuffer(b"".join(numbers), np.int32)


def _offsets(counts: NDArray[np.signedinteger]) -> NDArray[np.int64]:
    return np.concatenate(([0], np.cumsum(counts, dtype=np.int64)))


def _joined(parts: list[NDArray[np.int32]]) -> NDArray[np.int32]:
    return np.concatenate([np.zeros(0, np.int32), *parts])
