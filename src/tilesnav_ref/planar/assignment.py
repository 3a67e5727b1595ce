"""Each point goes to the plane nearby that explains it best."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel

CANDIDATES = 12
"""Most features near a point; further ones are left out."""
SUPPORT = 3
"""Fewest neighbours of a feature that a point does not belong to yet; fewer are strays themselves."""
NORMAL_COST = 9.0
"""Most that a wrong normal costs, in squared standard deviations: at an edge normals mislead."""


class Choice(NamedTuple):
    """What a point is explained by."""

    normals: NDArray[np.float64]
    """(K, 3) planes of the features."""
    offsets: NDArray[np.float64]
    local_normals: NDArray[np.float32]
    """(N, 3) of the points."""
    local_rms: NDArray[np.float32]
    local_spread: NDArray[np.float32]
    labels: NDArray[np.int32]
    """(N,) before."""
    out: NDArray[np.int32]
    """(N,) written."""


class Limits(NamedTuple):
    """Lengths in metres, angles in radians."""

    radius: float
    distance: float
    """Greatest distance of a point from its plane."""
    noise: float
    """Standard deviation of that distance."""
    flat: float
    """Greatest rms at which a local normal says anything."""


@kernel
def assign_cubes(
    points: NDArray[np.float64],
    cubes: NDArray[np.int64],
    runs: NDArray[np.int32],
    limits: Limits,
    span: tuple[int, int],
    choice: Choice,
) -> None:
    """Write the best label of the points of a span, given the labels of all before.

    The cost is the negative logarithm of the likelihood: squared distance, squared angle (bounded), and the
    share of the neighbours that carry the label.
    """
    names = np.empty(CANDIDATES, np.int32)
    votes = np.empty(CANDIDATES, np.int64)
    limit = limits.radius * limits.radius
    for cube in range(span[0], span[1]):
        alone = only_label(runs[cube], choice.labels)
        for at in range(cubes[cube], cubes[cube + 1]):
            if alone >= 0 and choice.labels[at] == alone:
                near = abs(away_from(points, at, choice, alone)) <= limits.distance
                choice.out[at] = alone if near else -1
                continue
            known = 0
            for run in range(9):
                for other in range(runs[cube, run, 0], runs[cube, run, 1]):
                    label = choice.labels[other]
                    if label < 0:
                        continue
                    x = points[other, 0] - points[at, 0]
                    y = points[other, 1] - points[at, 1]
                    z = points[other, 2] - points[at, 2]
                    if x * x + y * y + z * z > limit:
                        continue
                    place = 0
                    while place < known and names[place] != label:
                        place += 1
                    if place == CANDIDATES:
                        continue
                    if place == known:
                        names[place], votes[place] = label, 0
                        known += 1
                    votes[place] += 1
            choice.out[at] = best_label(points, at, limits, choice, names[:known], votes[:known])


@kernel
def only_label(runs: NDArray[np.int32], labels: NDArray[np.int32]) -> int:
    """Label of all labelled points in nine runs, -1 where there are several or none."""
    found = -1
    for run in range(9):
        for at in range(runs[run, 0], runs[run, 1]):
            if labels[at] >= 0 and labels[at] != found:
                if found >= 0:
                    return -1
                found = labels[at]
    return found


@kernel
def away_from(points: NDArray[np.float64], at: int, choice: Choice, label: int) -> float:
    """Signed distance of a point from the plane of a feature."""
    n = choice.normals[label]
    upon = n[0] * points[at, 0] + n[1] * points[at, 1] + n[2] * points[at, 2]
    return float(upon + choice.offsets[label])


@kernel
def best_label(
    points: NDArray[np.float64],
    at: int,
    limits: Limits,
    choice: Choice,
    names: NDArray[np.int32],
    votes: NDArray[np.int64],
) -> int:
    """Candidate of least cost, -1 where no plane is near."""
    own = choice.labels[at]
    total = votes.sum()
    local = choice.local_normals[at]
    found, best = -1, math.inf
    for place in range(len(names)):
        label = names[place]
        if label != own and votes[place] < SUPPORT:
            continue
        n = choice.normals[label]
        away = away_from(points, at, choice, label)
        if not abs(away) <= limits.distance:
            continue
        cost = (away / limits.noise) ** 2 - 2.0 * math.log(votes[place] / total)
        if choice.local_rms[at] <= limits.flat:
            cosine = abs(n[0] * local[0] + n[1] * local[1] + n[2] * local[2])
            angle = math.acos(min(1.0, cosine))
            cost += min(NORMAL_COST, (angle / choice.local_spread[at]) ** 2)
        if cost < best or (cost == best and label < found):
            found, best = label, cost
    return found
