"""Patches: pieces of the surface that go together as an occluder, such as a front with all its windows.

A flood over patches looks at the edges between them only, so that a finely divided wall costs what a plain
one does. Any division into patches is sound; this one joins what shares much of its border and faces the same
way, then small pieces with what surrounds them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LEAST_SHARE = 0.15
"""Share of the smaller border that two pieces must have in common."""
FLAT = 0.8
"""Least cosine between the normals of pieces that are joined first: about 37 degrees."""
DETAIL_SHARE = 0.4
DETAIL_AREA = 0.25
"""A piece with at most this share of the area of another is joined to it whatever its direction, when they
have DETAIL_SHARE of its border in common."""
LARGEST = 512
"""Faces of a patch: what a flood adds at a time is tested face by face against the target."""

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass
class _Pieces:
    """The pieces so far; face attributes follow their faces."""

    label: Ints
    """(F,) piece of each face."""
    turn: Floats
    """(F,) 1 or -1: whether the normal of the face counts reversed in its piece."""
    normal: Floats
    """(F, 3) twice the area along the normal."""


@dataclass(frozen=True)
class _Inner:
    """Edges with two opaque faces."""

    faces: Ints
    """(I, 2)."""
    length: Floats
    """(I,)."""
    agree: Floats
    """(I,) 1 where both faces run through the edge in opposite directions: their normals agree; else -1."""


def label_patches(
    corners: Floats, faces: NDArray[np.int32], edges: NDArray[np.int32], opaque: NDArray[np.bool_]
) -> NDArray[np.int32]:
    """Patch of each face.

    Parameters
    ----------
    corners : (F, 3, 3) any unit.
    faces : (F, 3) vertices.
    edges : (F, 3) edge from corner k to corner k + 1.
    opaque : (F,) whether a face hides anything.

    Returns
    -------
    (F,) numbers from 0 in the order of the first faces; a face that hides nothing is a patch of its own.
    """
    length = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    count = len(faces)
    pieces = _Pieces(np.arange(count), np.ones(count), normal)
    inner = _inner_edges(faces, edges, opaque, length)
    perimeter = length.sum(axis=1)
    perimeter = _join_all(pieces, inner, perimeter, flat=True)
    _join_all(pieces, inner, perimeter, flat=False)
    _, first, number = np.unique(pieces.label, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[number.ravel()].astype(np.int32)


def _inner_edges(
    faces: NDArray[np.int32], edges: NDArray[np.int32], opaque: NDArray[np.bool_], length: Floats
) -> _Inner:
    owner = np.repeat(np.arange(len(faces)), 3)
    upward = (faces < np.roll(faces, -1, axis=1)).ravel()
    use = opaque[owner]
    number = np.bincount(edges.ravel()[use], minlength=int(edges.max(initial=-1)) + 1)
    use &= number[edges.ravel()] == 2
    order = np.flatnonzero(use)[np.argsort(edges.ravel()[use], kind="stable")].reshape(-1, 2)
    agree = np.where(upward[order[:, 0]] != upward[order[:, 1]], 1.0, -1.0)
    return _Inner(owner[order], length.ravel()[order[:, 0]], agree)


def _join_all(pieces: _Pieces, inner: _Inner, perimeter: Floats, flat: bool) -> Floats:
    """Join pairs of pieces that prefer each other until there are none; returns the perimeters."""
    while True:
        pairs = _mutual(pieces, inner, perimeter, flat)
        if len(pairs.one) == 0:
            return perimeter
        perimeter = perimeter.copy()
        perimeter[pairs.one] += perimeter[pairs.other] - 2 * pairs.shared
        target = np.arange(len(perimeter))
        turn = np.ones(len(perimeter))
        target[pairs.other], turn[pairs.other] = pairs.one, pairs.turn
        pieces.turn *= turn[pieces.label]
        pieces.label = target[pieces.label]


@dataclass(frozen=True)
class _Pairs:
    one: Ints
    other: Ints
    shared: Floats
    turn: Floats


def _mutual(pieces: _Pieces, inner: _Inner, perimeter: Floats, flat: bool) -> _Pairs:
    """Pairs of pieces each of which is the best neighbour of the other, and may be joined."""
    label = pieces.label[inner.faces]
    apart = label[:, 0] != label[:, 1]
    label, length = label[apart], inner.length[apart]
    agree = inner.agree[apart] * pieces.turn[inner.faces[apart]].prod(axis=1)
    count = len(perimeter)
    keys, number = np.unique(label.min(axis=1) * count + label.max(axis=1), return_inverse=True)
    shared = np.bincount(number.ravel(), weights=length, minlength=len(keys))
    turn = np.where(np.bincount(number.ravel(), weights=length * agree, minlength=len(keys)) >= 0, 1.0, -1.0)
    one, other = keys // count, keys % count
    fits = _may_join(pieces, count, (one, other, turn), flat)
    share = shared / np.minimum(perimeter[one], perimeter[other])
    fits &= share >= (LEAST_SHARE if flat else DETAIL_SHARE)
    one, other, shared, turn, share = one[fits], other[fits], shared[fits], turn[fits], share[fits]
    order = np.argsort(-share, kind="stable")
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    best = np.full(count, len(order), np.int64)
    np.minimum.at(best, one, rank)
    np.minimum.at(best, other, rank)
    mutual = (best[one] == rank) & (best[other] == rank)
    return _Pairs(one[mutual], other[mutual], shared[mutual], turn[mutual])


def _may_join(pieces: _Pieces, count: int, pairs: tuple[Ints, Ints, Floats], flat: bool) -> NDArray[np.bool_]:
    one, other, turn = pairs
    turned = pieces.normal * pieces.turn[:, None]
    sums = [np.bincount(pieces.label, weights=turned[:, k], minlength=count) for k in range(3)]
    total = np.stack(sums, axis=1)
    size = np.bincount(pieces.label, minlength=count)
    small = size[one] + size[other] <= LARGEST
    area = np.bincount(pieces.label, weights=np.linalg.norm(pieces.normal, axis=1), minlength=count)
    if not flat:
        least, most = np.minimum(area[one], area[other]), np.maximum(area[one], area[other])
        return np.asarray(small & (least <= DETAIL_AREA * most))
    product = (total[one] * total[other]).sum(axis=1) * turn
    norms = np.linalg.norm(total[one], axis=1) * np.linalg.norm(total[other], axis=1)
    return np.asarray(small & (product >= FLAT * norms))
