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
    """(8, 3) fine units."""
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


def _tables(proofs: list[Proofs], first: int, last: int) -> CertificateTables:
    parsed = [_parse(p.words) for p in proofs]
    counts = np.array([len(p.target_counts) for p in parsed], np.int64)
    cell_offsets, uses = _uses(proofs, counts, (first, last))
    regions = np.array([p.region[[0, -1]].ravel() for p in proofs], np.int64).reshape(-1, 6)
    leaves, offsets, occluders = _distinct(parsed)
    return CertificateTables(
        cell_offsets,
        uses,
        np.repeat(regions, counts, axis=0),
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
