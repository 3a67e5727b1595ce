"""Whether a feature is the surface of something, or a slice through foliage.

The points that a scanner takes in one sweep lie on a plane, in a tree as well. But behind and before a slice
of a tree there is more of the tree; a surface has at most one side on which there is something loose.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.planar.assignment import Choice, away_from, only_label

PARALLEL = 0.8
"""Cosine above which another feature nearby may be the next slice."""
LOOSE = 0.3
"""Greatest number of loose neighbours on the side that has fewer, for each neighbour in the feature. Where
foliage is as dense on both sides as in the slice it is about 1; strays, a twentieth of all points, make
0.01."""


@kernel
def loose_cubes(
    points: NDArray[np.float64],
    cubes: NDArray[np.int64],
    runs: NDArray[np.int32],
    limits: tuple[float, float],
    span: tuple[int, int],
    work: tuple[Choice, NDArray[np.uint16]],
) -> None:
    """Count, for the points of a span, neighbours of the same feature and loose ones on its two sides.

    `limits` is the radius and the greatest distance of an inlier. Loose are points without a feature, and of
    features that are nearly parallel, off the plane.
    """
    choice, found = work
    radius, distance = limits
    labels = choice.labels
    for cube in range(span[0], span[1]):
        if only_label(runs[cube], labels) < 0 and not has_label(labels[cubes[cube] : cubes[cube + 1]]):
            continue
        for at in range(cubes[cube], cubes[cube + 1]):
            own = labels[at]
            for run in range(9 if own >= 0 else 0):
                for other in range(runs[cube, run, 0], runs[cube, run, 1]):
                    label = labels[other]
                    if label != own and label >= 0:
                        a, b = choice.normals[own], choice.normals[label]
                        if abs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) < PARALLEL:
                            continue
                    x = points[other, 0] - points[at, 0]
                    y = points[other, 1] - points[at, 1]
                    z = points[other, 2] - points[at, 2]
                    if x * x + y * y + z * z > radius * radius:
                        continue
                    if label == own:
                        found[at, 0] += 1
                        continue
                    away = away_from(points, other, choice, own)
                    if abs(away) > distance:
                        found[at, 1 if away > 0 else 2] += 1


@kernel
def has_label(labels: NDArray[np.int32]) -> bool:
    """Whether one of the labels is of a feature."""
    return bool((labels >= 0).any())


def solid(labels: NDArray[np.int32], found: NDArray[np.uint16], features: int) -> NDArray[np.bool_]:
    """(K,) whether a feature has a side with little that is loose."""
    own = labels >= 0
    own_labels = labels[own]
    inside, above, below = (
        np.bincount(own_labels, weights=found[own, k], minlength=features) for k in range(3)
    )
    return np.asarray(np.minimum(above, below) <= LOOSE * inside)
