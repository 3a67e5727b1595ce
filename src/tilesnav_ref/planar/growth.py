"""Growth of planar features from the flattest local planes.

References
----------
T. Rabbani, F. van den Heuvel, G. Vosselman, "Segmentation of point clouds using smoothness constraint", 2006
(growth over neighbours in the order of their residuals).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.planar.normals import least_axis

REFIT = 1.3
"""A feature is fitted anew when its count has grown by this factor: its radius has grown by 14 % then, so
an error of the fit has not carried far."""


class Cloud(NamedTuple):
    """Sorted points and what growth needs to know of each."""

    points: NDArray[np.float64]
    cube_of: NDArray[np.int32]
    runs: NDArray[np.int32]
    normals: NDArray[np.float32]
    shifts: NDArray[np.float32]
    rms: NDArray[np.float32]
    cosines: NDArray[np.float32]
    labels: NDArray[np.int32]
    """(N,) written: feature of each point, `OPEN` or `TRIED`."""


class Rules(NamedTuple):
    """When a point joins, and when a feature stands; metres and cosines."""

    radius: float
    distance: float
    flatness: float
    """Greatest rms of a feature."""
    fewest: int


WIDTH = 2.0
"""Least standard deviation of the points along the shorter way in the plane, in the greatest rms from it: a
row of points lies on many planes."""
OPEN = -1
TRIED = -2
"""No feature, and no seed again."""


@kernel
def refit(sums: NDArray[np.float64], count: int, plane: NDArray[np.float64]) -> tuple[float, float]:
    """Write the least squares plane of summed moments (x y z xx xy xz yy yz zz).

    Returns the mean square of the distances from it, and that along the shorter way in it.
    """
    x, y, z = sums[0] / count, sums[1] / count, sums[2] / count
    least, middle, plane[0], plane[1], plane[2] = least_axis(
        sums[3] / count - x * x,
        sums[4] / count - x * y,
        sums[5] / count - x * z,
        sums[6] / count - y * y,
        sums[7] / count - y * z,
        sums[8] / count - z * z,
    )
    plane[3] = -(plane[0] * x + plane[1] * y + plane[2] * z)
    return max(0.0, least), max(0.0, middle)


@kernel
def grown(
    cloud: Cloud, rules: Rules, start: int, label: int, queue: NDArray[np.int32], plane: NDArray[np.float64]
) -> tuple[int, float, float]:
    """Grow a feature over neighbours that lie on its plane with about its normal.

    The plane (relative to the start) follows the points, and growth ends where they are no longer flat: of a
    surface that bends, the part before the last fit is kept. Returns the number of points and their
    mean squares, as :func:`refit` does; the points are the first of `queue`, and carry the label.
    """
    points, limit = cloud.points, rules.radius * rules.radius
    sums = np.zeros(9)
    x0, y0, z0 = points[start, 0], points[start, 1], points[start, 2]
    queue[0] = start
    cloud.labels[start] = label
    count, done, again = 1, 0, 8
    kept, square, width = 0, 0.0, 0.0
    while done < count:
        at = queue[done]
        done += 1
        ax, ay, az = points[at, 0], points[at, 1], points[at, 2]
        runs = cloud.runs[cloud.cube_of[at]]
        for run in range(9):
            for other in range(runs[run, 0], runs[run, 1]):
                if cloud.labels[other] >= 0:
                    continue
                x, y, z = points[other, 0], points[other, 1], points[other, 2]
                if (x - ax) ** 2 + (y - ay) ** 2 + (z - az) ** 2 > limit:
                    continue
                x, y, z = x - x0, y - y0, z - z0
                if not abs(plane[0] * x + plane[1] * y + plane[2] * z + plane[3]) <= rules.distance:
                    continue
                n = cloud.normals[other]
                if not abs(plane[0] * n[0] + plane[1] * n[1] + plane[2] * n[2]) >= cloud.cosines[other]:
                    continue
                cloud.labels[other] = label
                queue[count] = other
                count += 1
                sums[0] += x
                sums[1] += y
                sums[2] += z
                sums[3] += x * x
                sums[4] += x * y
                sums[5] += x * z
                sums[6] += y * y
                sums[7] += y * z
                sums[8] += z * z
        if count >= again:
            now, across = refit(sums, count, plane)
            again = int(count * REFIT) + 1
            if now > rules.flatness * rules.flatness and kept >= rules.fewest:
                for k in range(kept, count):
                    cloud.labels[queue[k]] = OPEN
                return kept, square, width
            kept, square, width = count, now, across
    if count > 3:
        square, width = refit(sums, count, plane)
    return count, square, width


@kernel
def grow_all(
    cloud: Cloud, rules: Rules, seeds: NDArray[np.int32], queue: NDArray[np.int32], first: int
) -> int:
    """Grow features from seeds in their order, numbered from `first`; return the number after the last.

    A feature with too few points, or not flat enough, gives its points back.
    """
    plane = np.empty(4)
    label = first
    for at in seeds:
        if cloud.labels[at] != OPEN or not cloud.rms[at] < math.inf:
            continue
        for axis in range(3):
            plane[axis] = cloud.normals[at, axis]
        plane[3] = -cloud.shifts[at]
        count, square, width = grown(cloud, rules, at, label, queue, plane)
        least = rules.flatness * rules.flatness
        if count >= rules.fewest and square <= least and width >= WIDTH * WIDTH * least:
            label += 1
        else:
            for k in range(count):
                cloud.labels[queue[k]] = TRIED
    return label
