"""Local planes: principal components of neighbourhoods, then the flattest one that holds a point.

References
----------
H. Hoppe et al., "Surface reconstruction from unorganized points", SIGGRAPH 1992 (principal components).
M. Kuwahara et al., "Processing of RI-angiocardiographic images", 1976 (the best of the windows that hold a
pixel, which keeps edges; here, neighbourhoods that hold a point).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel

FEWEST = 6
"""Points of a neighbourhood with a plane of its own; three always have one."""


class LocalPlanes(NamedTuple):
    """A plane at each sorted point."""

    normals: NDArray[np.float32]
    """(N, 3) unit, sign arbitrary."""
    shifts: NDArray[np.float32]
    """(N,) metres; normal . (x - point) = shift on the plane."""
    rms: NDArray[np.float32]
    """(N,) metres; infinite where there are too few neighbours."""
    spread: NDArray[np.float32]
    """(N,) radians; standard deviation of the normal, about the axis that is held worst."""


@kernel
def least_axis(
    xx: float, xy: float, xz: float, yy: float, yz: float, zz: float
) -> tuple[float, float, float, float, float]:
    """Least two eigenvalues of a symmetric matrix and the unit eigenvector of the least.

    Notes
    -----
    Trigonometric solution of the characteristic polynomial, then the longest cross product of two rows. It
    is exact to about the square root of the rounding of float64, far below the noise of any sensor. A
    multiple of the identity gives z.
    """
    mean = (xx + yy + zz) / 3.0
    a, b, c = xx - mean, yy - mean, zz - mean
    p = math.sqrt((a * a + b * b + c * c + 2.0 * (xy * xy + xz * xz + yz * yz)) / 6.0)
    if p <= 1e-12 * abs(mean) or p == 0.0:  # equal eigenvalues: any axis is right
        return mean, mean, 0.0, 0.0, 1.0
    det = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    half = min(1.0, max(-1.0, det / (2.0 * p * p * p)))
    turn = math.acos(half) / 3.0
    least = mean + 2.0 * p * math.cos(turn + 2.0 * math.pi / 3.0)
    middle = 3.0 * mean - least - (mean + 2.0 * p * math.cos(turn))
    a, b, c = xx - least, yy - least, zz - least
    x, y, z = xy * yz - xz * b, xz * xy - a * yz, a * b - xy * xy
    best = x * x + y * y + z * z
    u, v, w = xy * c - xz * yz, xz * xz - a * c, a * yz - xy * xz
    other = u * u + v * v + w * w
    if other > best:
        x, y, z, best = u, v, w, other
    u, v, w = b * c - yz * yz, yz * xz - xy * c, xy * yz - b * xz
    other = u * u + v * v + w * w
    if other > best:
        x, y, z, best = u, v, w, other
    if best == 0.0:
        return least, middle, 0.0, 0.0, 1.0
    length = math.sqrt(best)
    return least, middle, x / length, y / length, z / length


@kernel
def fit_around(
    points: NDArray[np.float64], runs: NDArray[np.int32], at: int, radius: float, local: NDArray[np.float64]
) -> None:
    """Write (normal, shift, rms, spread) of the plane of the points within a radius of one of them."""
    x0, y0, z0 = points[at, 0], points[at, 1], points[at, 2]
    limit = radius * radius
    count = 0
    sx = sy = sz = sxx = sxy = sxz = syy = syz = szz = 0.0
    for run in range(9):
        for other in range(runs[run, 0], runs[run, 1]):
            x, y, z = points[other, 0] - x0, points[other, 1] - y0, points[other, 2] - z0
            if x * x + y * y + z * z <= limit:
                count += 1
                sx += x
                sy += y
                sz += z
                sxx += x * x
                sxy += x * y
                sxz += x * z
                syy += y * y
                syz += y * z
                szz += z * z
    if count < FEWEST:
        local[4] = local[5] = math.inf
        return
    mx, my, mz = sx / count, sy / count, sz / count
    least, middle, local[0], local[1], local[2] = least_axis(
        sxx / count - mx * mx,
        sxy / count - mx * my,
        sxz / count - mx * mz,
        syy / count - my * my,
        syz / count - my * mz,
        szz / count - mz * mz,
    )
    local[3] = local[0] * mx + local[1] * my + local[2] * mz
    # three parameters were taken from the points: the mean square of few points is too small
    local[4] = math.sqrt(max(0.0, least) * count / (count - 3.0))
    local[5] = local[4] / math.sqrt(count * middle) if middle > 0.0 else math.inf


@kernel
def fit_cubes(
    points: NDArray[np.float64],
    cubes: NDArray[np.int64],
    runs: NDArray[np.int32],
    radius: float,
    span: tuple[int, int],
    out: LocalPlanes,
) -> None:
    """Fit planes around all points of a span of cubes."""
    local = np.zeros(6)
    for cube in range(span[0], span[1]):
        for at in range(cubes[cube], cubes[cube + 1]):
            fit_around(points, runs[cube], at, radius, local)
            out.normals[at, 0] = local[0]
            out.normals[at, 1] = local[1]
            out.normals[at, 2] = local[2]
            out.shifts[at] = local[3]
            out.rms[at] = local[4]
            out.spread[at] = local[5]


@kernel
def sharpen_cubes(
    points: NDArray[np.float64],
    cubes: NDArray[np.int64],
    runs: NDArray[np.int32],
    fit: tuple[float, float],
    span: tuple[int, int],
    planes: tuple[LocalPlanes, LocalPlanes],
) -> None:
    """Give each point of a span the flattest plane of its neighbours that it lies on.

    `fit` is the radius and the greatest distance of a point from a plane that it takes, metres.
    """
    radius, distance = fit
    given, out = planes
    limit = radius * radius
    for cube in range(span[0], span[1]):
        for at in range(cubes[cube], cubes[cube + 1]):
            best, chosen, shift = given.rms[at], at, given.shifts[at]
            if not abs(shift) <= distance:
                best = math.inf
            for run in range(9):
                for other in range(runs[cube, run, 0], runs[cube, run, 1]):
                    if not given.rms[other] < best:
                        continue
                    x = points[other, 0] - points[at, 0]
                    y = points[other, 1] - points[at, 1]
                    z = points[other, 2] - points[at, 2]
                    if x * x + y * y + z * z > limit:
                        continue
                    n = given.normals[other]
                    away = n[0] * x + n[1] * y + n[2] * z + given.shifts[other]
                    if abs(away) <= distance:
                        best, chosen, shift = given.rms[other], other, away
            for axis in range(3):
                out.normals[at, axis] = given.normals[chosen, axis]
            out.shifts[at] = shift
            out.rms[at] = best
            out.spread[at] = given.spread[chosen]
