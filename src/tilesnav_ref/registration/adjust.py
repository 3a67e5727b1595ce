"""Adjustment of the poses of all scans at once.

Notes
-----
Each scan is compared with the scans nearest to it: points against the planes around their partners. The
distances are linear in small motions of all scans, so one sparse system moves them together, which closes
loops that a growing map leaves open.

References
----------
P. Bergstroem, O. Edlund: Robust registration of point sets using iteratively reweighted least squares,
Comput. Optim. Appl. 58 (2014); F. Lu, E. Milios: Globally consistent range scan alignment for environment
mapping, Autonomous Robots 4 (1997).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

from tilesnav_ref.registration.motion import place, turned_about, unplace
from tilesnav_ref.registration.settings import RegistrationSettings
from tilesnav_ref.registration.thin import Planes, Thinned, middles_of, planes_of

PLANES_EVERY = 3
"""Rounds for which fitted planes serve; they turn with their scans in between."""
SCALES = (0.01, 0.2)
"""Metres: least and greatest distance at which a partner counts little."""
SCALE_FACTOR = 4.0
"""Times the spread of the distances; what lies farther is another surface."""
SAME_WAY = 0.9
"""Cosine of the greatest angle between the planes of partners."""
LEAST_STEP = 2e-4
"""Metres and radians; a round that moves all scans less is the last."""
PRIOR_SHIFT, PRIOR_TURN = 1.0, 0.2
"""Metres and radians: how well the poses of the growing map are known. It only matters along a direction that
no plane fixes, as along a bare corridor."""


@dataclass(frozen=True)
class Adjusted:
    """Poses after the adjustment and how they fit."""

    poses: NDArray[np.float64]
    """(S, 4, 4)."""
    rms: NDArray[np.float64]
    """(S,) weighted root mean square distance of points of a scan from the planes of others, metres."""
    matched: NDArray[np.float64]
    """(S,) share of the compared points of a scan that have a partner."""
    held: NDArray[np.float64]
    """(S,) mean square cosine between the planes' normals and the direction that they fix least: 1/3 where
    they face all ways alike, 0 where nothing holds the scan along a line."""
    rounds: int


@dataclass
class _System:
    """Normal equations over the motions of all scans, and the figures of a round."""

    count: int

    def __post_init__(self) -> None:
        self.blocks: dict[tuple[int, int], NDArray[np.float64]] = {}
        self.right = np.zeros((self.count, 6))
        self.squares, self.weights = np.zeros(self.count), np.zeros(self.count)
        self.partners, self.compared = np.zeros(self.count), np.zeros(self.count)
        self.facing = np.zeros((self.count, 3, 3))
        self.distances: list[NDArray[np.float64]] = []

    def add(self, i: int, j: int, block: NDArray[np.float64]) -> None:
        self.blocks[i, j] = self.blocks.get((i, j), np.zeros((6, 6))) + block

    @property
    def variance(self) -> float:
        return float(self.squares.sum() / max(self.weights.sum(), 1.0))

    def solve(self) -> NDArray[np.float64]:
        """(S, 6) motions of all scans, the first zero."""
        count = self.count
        prior = self.variance / np.array([PRIOR_TURN**2] * 3 + [PRIOR_SHIFT**2] * 3)
        for k in range(count):
            self.add(k, k, np.diag(prior))
        inner = {key: block for key, block in self.blocks.items() if key[0] and key[1]}
        grid = np.indices((6, 6))
        rows = np.concatenate([grid[0].ravel() + 6 * (i - 1) for i, _ in inner])
        columns = np.concatenate([grid[1].ravel() + 6 * (j - 1) for _, j in inner])
        values = np.concatenate([block.ravel() for block in inner.values()])
        factor = splu(coo_matrix((values, (rows, columns)), shape=(6 * count - 6,) * 2).tocsc())
        motions = np.zeros((count, 6))
        motions[1:] = -factor.solve(self.right[1:].ravel()).reshape(-1, 6)
        return motions


def adjust(
    scans: list[Thinned],
    poses: NDArray[np.float64],
    settings: RegistrationSettings,
    done: Callable[[int], None],
) -> Adjusted:
    """Move all scans but the first until their planes lie on each other.

    Parameters
    ----------
    scans : list of Thinned
        Two or more.
    poses : (S, 4, 4) float64
        Where they lie within about `settings.fine_reach`.
    settings : RegistrationSettings
    done : callable
        Told how many rounds are done.
    """
    scale, planes = SCALES[1], planes_of(scans, poses)
    for number in range(settings.rounds):
        if number and number % PLANES_EVERY == 0:
            planes = planes_of(scans, poses)
        system = _compare(scans, planes, poses, settings, scale)
        motions = system.solve()
        middles = middles_of(scans, poses)
        poses = np.array([turned_about(*args) for args in zip(poses, middles, motions, strict=True)])
        scale = _scale(system)
        done(number + 1)
        if number >= PLANES_EVERY and np.abs(motions).max() < LEAST_STEP:
            break
    system = _compare(scans, planes, poses, settings, scale)
    weights = np.maximum(system.weights, 1e-9)
    held = np.linalg.eigvalsh(system.facing / weights[:, None, None])[:, 0]
    rms = np.sqrt(system.squares / weights)
    matched = system.partners / np.maximum(system.compared, 1.0)
    return Adjusted(poses, rms, matched, np.maximum(held, 0.0), number + 1 if settings.rounds else 0)


def _scale(system: _System) -> float:
    """Distance at which a partner counts little, from the median of the distances."""
    everything = np.concatenate([*system.distances, np.zeros(0)])
    # 1.4826 makes a standard deviation of the median of a normal distribution's magnitudes.
    spread = 1.4826 * float(np.median(everything)) if len(everything) else SCALES[1]
    return min(max(SCALE_FACTOR * spread, SCALES[0]), SCALES[1])


def _compare(
    scans: list[Thinned],
    planes: list[Planes],
    poses: NDArray[np.float64],
    settings: RegistrationSettings,
    scale: float,
) -> _System:
    """Compare each scan with the nearest others."""
    system = _System(len(scans))
    middles = middles_of(scans, poses)
    for i, scan in enumerate(scans):
        chosen = np.flatnonzero(planes[i].flat)
        chosen = chosen[:: max(1, len(chosen) // settings.link_points)]
        points = place(poses[i], scan.points[chosen])
        normals = planes[i].normals[chosen] @ poses[i][:3, :3].T
        near = np.argsort(np.linalg.norm(middles - middles[i], axis=1), kind="stable")
        met = np.zeros(len(points), np.bool_)
        for j in near[near != i][: settings.links]:
            own, ends = _partners(scans[j], planes[j], poses[j], (points, normals), settings.fine_reach)
            met[own] = True
            _link(system, (i, j), (points[own], *ends), (middles[i], middles[j]), scale)
        system.partners[i], system.compared[i] = met.sum(), len(met)
    return system


def _partners(
    other: Thinned,
    planes: Planes,
    pose: NDArray[np.float64],
    oriented: tuple[NDArray[np.float64], NDArray[np.float64]],
    reach: float,
) -> tuple[NDArray[np.int64], tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Points that have a partner in another scan, and its place and normal."""
    points, normals = oriented
    away, partner = other.tree.query(unplace(pose, points), distance_upper_bound=reach)
    own = np.flatnonzero(np.isfinite(away))
    partner = partner[own]
    facing = planes.normals[partner] @ pose[:3, :3].T
    same = planes.flat[partner] & (np.abs(np.einsum("ij,ij->i", facing, normals[own])) > SAME_WAY)
    return own[same], (place(pose, other.points[partner[same]]), facing[same])


def _link(
    system: _System,
    pair: tuple[int, int],
    ends: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    middles: tuple[NDArray[np.float64], NDArray[np.float64]],
    scale: float,
) -> None:
    """Add the distances of points of scan i from the planes at their partners in scan j."""
    (i, j), (points, partners, normals) = pair, ends
    distance = np.einsum("ij,ij->i", points - partners, normals)
    weight = 1.0 / (1.0 + (distance / scale) ** 2) ** 2  # Geman and McClure
    by_i = np.concatenate((np.cross(points - middles[0], normals), normals), axis=1)
    by_j = -np.concatenate((np.cross(partners - middles[1], normals), normals), axis=1)
    weighted_i, weighted_j = by_i * weight[:, None], by_j * weight[:, None]
    system.add(i, i, by_i.T @ weighted_i)
    system.add(j, j, by_j.T @ weighted_j)
    system.add(i, j, by_i.T @ weighted_j)
    system.add(j, i, by_j.T @ weighted_i)
    system.right[i] += weighted_i.T @ distance
    system.right[j] += weighted_j.T @ distance
    system.squares[i] += float((weight * distance**2).sum())
    system.weights[i] += float(weight.sum())
    system.facing[i] += (normals * weight[:, None]).T @ normals
    system.distances.append(np.abs(distance))
