"""Planes through random samples of three points near a point.

References
----------
M. A. Fischler, R. C. Bolles, "Random sample consensus", CACM 24, 1981 (planes of three points).
P. H. S. Torr, A. Zisserman, "MLESAC", CVIU 78, 2000 (the score: squared distances, bounded).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.planar.normals import FEWEST, LocalPlanes, least_axis

SAMPLED = 64
"""Most neighbours that samples are drawn from."""
TRIALS = 24
"""Samples of three points. Where a third of the neighbours is on the plane, one of 24 hits it with a
probability of 0.6; the neighbours of the point on the same plane draw others."""
REFITS = 3
"""Least squares fits, each to the points near the last, from a plane that noise has turned."""


@kernel
def drawn(state: int) -> int:
    """31 random bits of a state (the finaliser of MurmurHash3, 32 bits)."""
    state &= 0xFFFFFFFF
    state = ((state ^ (state >> 16)) * 0x85EBCA6B) & 0xFFFFFFFF
    state = ((state ^ (state >> 13)) * 0xC2B2AE35) & 0xFFFFFFFF
    return (state ^ (state >> 16)) >> 1


@kernel
def neighbours(
    points: NDArray[np.float64], runs: NDArray[np.int32], at: int, radius: float, near: NDArray[np.float64]
) -> int:
    """Write the places of the points within a radius, relative to the one; return their number."""
    limit = radius * radius
    count = 0
    for run in range(9):
        for other in range(runs[run, 0], runs[run, 1]):
            x = points[other, 0] - points[at, 0]
            y = points[other, 1] - points[at, 1]
            z = points[other, 2] - points[at, 2]
            if x * x + y * y + z * z <= limit and count < len(near):
                near[count, 0] = x
                near[count, 1] = y
                near[count, 2] = z
                count += 1
    return count


@kernel
def through_three(near: NDArray[np.float64], state: int, count: int, plane: NDArray[np.float64]) -> bool:
    """Write the plane (normal, offset) of three points drawn; False where they are nearly on a line."""
    a = near[drawn(state) % count]
    b = near[drawn(state + 1) % count]
    c = near[drawn(state + 2) % count]
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = math.sqrt(x * x + y * y + z * z)
    sides = (ux * ux + uy * uy + uz * uz) * (vx * vx + vy * vy + vz * vz)
    if length * length <= 0.03 * sides:  # an angle below 10 degrees: noise would turn the plane
        return False
    plane[0], plane[1], plane[2] = x / length, y / length, z / length
    plane[3] = -(plane[0] * a[0] + plane[1] * a[1] + plane[2] * a[2])
    return True


@kernel
def cost_of(near: NDArray[np.float64], count: int, plane: NDArray[np.float64], distance: float) -> float:
    """Sum of squared distances from a plane, each at most `distance` squared."""
    limit = distance * distance
    cost = 0.0
    for k in range(count):
        away = plane[0] * near[k, 0] + plane[1] * near[k, 1] + plane[2] * near[k, 2] + plane[3]
        cost += min(away * away, limit)
    return cost


@kernel
def fit_near(
    near: NDArray[np.float64], count: int, plane: NDArray[np.float64], distance: float
) -> tuple[float, float]:
    """Fit a plane anew to the points within a distance of it; return rms and spread, infinite for too few."""
    inside = 0
    sums = np.zeros(9)
    for k in range(count):
        x, y, z = near[k, 0], near[k, 1], near[k, 2]
        if abs(plane[0] * x + plane[1] * y + plane[2] * z + plane[3]) <= distance:
            inside += 1
            sums += np.array((x, y, z, x * x, x * y, x * z, y * y, y * z, z * z))
    if inside < FEWEST:
        return math.inf, math.inf
    sums /= inside
    x, y, z = sums[0], sums[1], sums[2]
    least, middle, plane[0], plane[1], plane[2] = least_axis(
        sums[3] - x * x, sums[4] - x * y, sums[5] - x * z, sums[6] - y * y, sums[7] - y * z, sums[8] - z * z
    )
    plane[3] = -(plane[0] * x + plane[1] * y + plane[2] * z)
    rms = math.sqrt(max(0.0, least) * inside / (inside - 3.0))
    return rms, rms / math.sqrt(inside * middle) if middle > 0.0 else math.inf


@kernel
def sample_cubes(
    points: NDArray[np.float64],
    cubes: NDArray[np.int64],
    runs: NDArray[np.int32],
    fit: tuple[float, float, float, int],
    span: tuple[int, int],
    out: LocalPlanes,
) -> None:
    """Give the points of a span that have no flat plane yet the best plane of random samples.

    `fit` is the radius, the greatest distance of a point from its plane, the rms above which a plane is not
    flat (metres), and the seed.
    """
    radius, distance, flat, seed = fit
    near = np.empty((SAMPLED, 3))
    plane, best_plane = np.empty(4), np.empty(4)
    for cube in range(span[0], span[1]):
        for at in range(cubes[cube], cubes[cube + 1]):
            if out.rms[at] <= flat:
                continue
            count = neighbours(points, runs[cube], at, radius, near)
            best = math.inf
            for trial in range(TRIALS if count >= FEWEST else 0):
                state = seed * 0x9E3779B1 + (at * TRIALS + trial) * 3
                if not through_three(near, state, count, plane) or abs(plane[3]) > distance:
                    continue
                cost = cost_of(near, count, plane, distance)
                if cost < best:
                    best = cost
                    best_plane[:] = plane
            rms = spread = math.inf
            for _ in range(REFITS if best < math.inf else 0):
                rms, spread = fit_near(near, count, best_plane, distance)
            out.rms[at] = rms
            out.spread[at] = spread
            for axis in range(3):
                out.normals[at, axis] = best_plane[axis] if rms < math.inf else 0.0
            out.shifts[at] = -best_plane[3] if rms < math.inf else 0.0
