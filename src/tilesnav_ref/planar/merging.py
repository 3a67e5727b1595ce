"""Joining features that are parts of one plane and touch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.planar.assignment import only_label
from tilesnav_ref.planar.moments import Moments

TOUCHING = 6
"""Most greater labels that are noted for a point; its neighbours note others."""


@kernel
def touching_cubes(
    points: NDArray[np.float64],
    cubes: NDArray[np.int64],
    runs: NDArray[np.int32],
    radius: float,
    span: tuple[int, int],
    marks: tuple[NDArray[np.int32], NDArray[np.int32]],
) -> None:
    """Write, for the points of a span, greater labels that neighbours carry.

    `marks` are the labels (N,) and what is written (N, `TOUCHING`), -1 for none.
    """
    labels, found = marks
    limit = radius * radius
    for cube in range(span[0], span[1]):
        if only_label(runs[cube], labels) >= 0:
            found[cubes[cube] : cubes[cube + 1]] = -1
            continue
        for at in range(cubes[cube], cubes[cube + 1]):
            found[at] = -1
            own, known = labels[at], 0
            for run in range(9 if own >= 0 else 0):
                for other in range(runs[cube, run, 0], runs[cube, run, 1]):
                    label = labels[other]
                    if label <= own or known == TOUCHING or label in found[at, :known]:
                        continue
                    x = points[other, 0] - points[at, 0]
                    y = points[other, 1] - points[at, 1]
                    z = points[other, 2] - points[at, 2]
                    if x * x + y * y + z * z <= limit:
                        found[at, known] = label
                        known += 1


def pairs_of(labels: NDArray[np.int32], found: NDArray[np.int32]) -> NDArray[np.int64]:
    """(P, 2) different pairs of labels, ascending."""
    pairs = np.concatenate(
        [np.stack((labels[found[:, k] >= 0], found[found[:, k] >= 0, k]), axis=1) for k in range(TOUCHING)]
    ).astype(np.int64)
    factor = np.int64(len(labels) + 1)
    keys = np.unique(pairs[:, 0] * factor + pairs[:, 1])
    return np.stack((keys // factor, keys % factor), axis=1)


def merged(moments: Moments, pairs: NDArray[np.int64], flatness: float) -> NDArray[np.int32]:
    """New label of each feature after all joins that keep both parts flat.

    Parameters
    ----------
    moments : Moments
        Of K features.
    pairs : (P, 2) int64
        Features that touch.
    flatness : float
        Greatest rms distance of the points of each part from the plane of both, metres.

    Returns
    -------
    (K,) int32
        Numbers from 0 without gaps, in the order of the first part.

    Notes
    -----
    In each round the pairs that fit best join, no feature twice, and the rest is measured anew against the
    greater features. A round joins one pair at least or is the last.
    """
    root = np.arange(len(moments.counts))
    while len(pairs):
        errors, joined = _errors(moments, pairs)
        fit = np.flatnonzero(errors <= flatness)
        chosen = _apart(pairs, fit[np.argsort(errors[fit], kind="stable")])
        if not len(chosen):
            break
        keep, gone = pairs[chosen].T
        for mine, new in zip(moments, joined, strict=True):
            mine[keep] = new[chosen]
        target = np.arange(len(root))
        target[gone] = keep
        root = target[root]
        pairs = np.sort(target[pairs], axis=1)
        pairs = np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)
    return np.unique(root, return_inverse=True)[1].astype(np.int32)


def _errors(moments: Moments, pairs: NDArray[np.int64]) -> tuple[NDArray[np.float64], Moments]:
    """Greater of the rms distances of both parts from the common plane, and the moments of the unions."""
    joined = moments.joined(pairs[:, 0], pairs[:, 1])
    normals, offsets, _ = joined.planes()
    squares = []
    for part in pairs.T:
        away = np.einsum("pi,pi->p", normals, moments.means[part]) + offsets
        spread = np.einsum("pi,pij,pj->p", normals, moments.scatters[part], normals)
        squares.append(spread / moments.counts[part] + away**2)
    return np.sqrt(np.maximum(np.maximum(*squares), 0.0)), joined


def _apart(pairs: NDArray[np.int64], order: NDArray[np.int64]) -> NDArray[np.int64]:
    """Those of the pairs, taken in an order, that share no feature with an earlier one."""
    used: set[int] = set()
    chosen = []
    for pair in order.tolist():
        a, b = (int(n) for n in pairs[pair])
        if a not in used and b not in used:
            used |= {a, b}
            chosen.append(pair)
    return np.array(chosen, np.int64)
