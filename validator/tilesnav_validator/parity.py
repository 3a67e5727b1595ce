"""The third condition of the parity theorem: a segment in general position crosses an odd number of faces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator.shafts import Parts
from tilesnav_validator.signs import determinant

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

SCALE = 256
"""Points are means of corners with weights that sum to this; coordinates of up to 54 bits stay below 62."""

TRIES = 64
"""Segments that are tried for a leaf. Those that are not in general position have no volume among all."""


def odd(parts: Parts, leaf: IntArray, triangles: IntArray, random: np.random.Generator) -> BoolArray:
    """Which leaves have a segment in general position that crosses an odd number of triangles.

    Parameters
    ----------
    parts : Parts
        Of k leaves.
    leaf : ndarray of int64, shape (f,)
        Leaf that each triangle belongs to the occluder of.
    triangles : ndarray of int64, shape (f, 3, 3)
        In units.
    random : numpy.random.Generator

    Returns
    -------
    ndarray of bool, shape (k,)
        The parity is the same for all segments where the first two conditions hold.
    """
    result = np.zeros(len(parts.low), dtype=bool)
    pending = np.ones(len(parts.low), dtype=bool)
    for _ in range(TRIES):
        mine = np.flatnonzero(pending[leaf])
        chosen, row = np.unique(leaf[mine], return_inverse=True)
        some = parts.take(chosen)
        starts, ends = _inner(some.corners, random), _inner(some.target, random)
        crossed, general = _crossings(starts[row], ends[row], triangles[mine] * SCALE)
        settled = np.bincount(row, ~general, len(chosen)) == 0
        count = np.bincount(row, crossed, len(chosen)).astype(np.int64)
        result[chosen[settled]] = count[settled] % 2 == 1
        pending[chosen[settled]] = False
        if settled.all():
            break
    return result


def _inner(corners: IntArray, random: np.random.Generator) -> IntArray:
    """A random point of each relative interior, shape (k, 3), in units divided by ``SCALE``."""
    count, number = corners.shape[:2]
    shares = random.integers(1, 2**16, (count, number))
    weights = 1 + shares * (SCALE - number) // shares.sum(axis=1, keepdims=True)
    weights[:, 0] += SCALE - weights.sum(axis=1)
    return np.asarray((weights[..., None] * corners).sum(axis=1), dtype=np.int64)


def _crossings(start: IntArray, end: IntArray, triangles: IntArray) -> tuple[BoolArray, BoolArray]:
    """Which segments cross a triangle inside, and which are in general position to it, one triangle each."""
    along = (end - start)[:, None]
    corners = triangles - start[:, None]
    turns = determinant(along, corners, np.roll(corners, -1, axis=1))
    passes = (turns > 0).any(axis=1) & (turns < 0).any(axis=1)
    near = np.flatnonzero(~passes)
    one, two = corners[near, 1] - corners[near, 0], corners[near, 2] - corners[near, 0]
    heights = [
        determinant(one, two, point[near] - triangles[near, 0]).astype(np.int64) for point in (start, end)
    ]
    same_side = heights[0] * heights[1] > 0
    inside = (turns[near] != 0).all(axis=1) & (heights[0] * heights[1] < 0)
    crossed = np.zeros(len(start), dtype=bool)
    crossed[near] = inside
    general = np.ones(len(start), dtype=bool)
    general[near] = inside | same_side
    return crossed, general
