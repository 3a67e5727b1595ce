"""Faces and cells that an earlier and a new map have in common."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.model import Scene

Rows = NDArray[np.int64]


def match_rows(first: Rows, second: Rows) -> NDArray[np.int64]:
    """Pair equal rows of two tables; of rows that occur several times each is paired at most once.

    Parameters
    ----------
    first, second : (A, W) and (B, W) int64

    Returns
    -------
    ndarray
        (A,) int64 row of `second` that each row of `first` is paired with, -1 where there is none left. Of
        equal rows the first of one table goes with the first of the other.
    """
    _, group = np.unique(np.concatenate([first, second]), axis=0, return_inverse=True)
    group = group.reshape(-1).astype(np.int64)
    one, two = group[: len(first)], group[len(first) :]
    most = max(len(first), len(second)) + 1
    codes = [own * most + _ranks(own) for own in (one, two)]
    found = np.full(len(first), -1, np.int64)
    _, at_first, at_second = np.intersect1d(codes[0], codes[1], assume_unique=True, return_indices=True)
    found[at_first] = at_second
    return found


def _ranks(group: NDArray[np.int64]) -> NDArray[np.int64]:
    """For each element how many equal ones come before it."""
    order = np.argsort(group, kind="stable")
    ordered = group[order]
    ranks = np.empty(len(group), np.int64)
    ranks[order] = np.arange(len(group)) - np.searchsorted(ordered, ordered)
    return ranks


def face_rows(scene: Scene) -> Rows:
    """What makes a face the same as another: corners and flags.

    Returns
    -------
    ndarray
        (F, 11) int64: grid coordinates of three corners, porous, one-sided. The corners of a one-sided face
        begin with the least and keep their sense of rotation; those of other faces ascend.
    """
    corners = scene.corners()
    order = np.lexsort((corners[:, :, 2], corners[:, :, 1], corners[:, :, 0]), axis=1)
    turned = (order[:, :1] + np.arange(3)) % 3
    order = np.where(scene.one_sided[:, None], turned, order)
    chosen = np.take_along_axis(corners, order[:, :, None], axis=1)
    flags = np.stack([scene.porous, scene.one_sided], axis=1).astype(np.int64)
    return np.concatenate([chosen.reshape(-1, 9), flags], axis=1)


def cell_rows(planes: NDArray[np.float64]) -> Rows:
    """(N, 24) what makes a cell the same as another: the bits of its planes (N, 6, 4), in their order."""
    return np.ascontiguousarray(planes, np.float64).reshape(len(planes), 24).view(np.int64)
