"""Distance of a point and a triangle.

References
----------
C. Ericson, "Real-Time Collision Detection", 2005, section 5.1.5.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import inner_kernel, kernel

Array = NDArray[np.float64]


@inner_kernel
def _square_at(corners: Array, point: Array, v: float, w: float) -> float:
    """Square of the distance of a point and the point of a triangle with the weights 1 - v - w, v, w."""
    total = 0.0
    for k in range(3):
        at = corners[0, k] + v * (corners[1, k] - corners[0, k]) + w * (corners[2, k] - corners[0, k])
        total += (at - point[k]) ** 2
    return total


@kernel
def squared_distance(corners: Array, point: Array) -> float:
    """Square of the distance of a point and a triangle.

    Parameters
    ----------
    corners : (3, 3) float64
        May be without area; any unit.
    point : (3,) float64

    Returns
    -------
    float
        Of the nearest point up to rounding, and of a point of the triangle in any case, so that it is never
        too small by more than the rounding of the coordinates.

    Notes
    -----
    The region that the nearest point is in is told by six inner products. A wrong region because of rounding
    gives another point of the triangle: the weights are between 0 and 1 in every case.
    """
    d1 = d2 = d3 = d4 = d5 = d6 = 0.0
    for k in range(3):
        ab, ac = corners[1, k] - corners[0, k], corners[2, k] - corners[0, k]
        ap, bp, cp = point[k] - corners[0, k], point[k] - corners[1, k], point[k] - corners[2, k]
        d1 += ab * ap
        d2 += ac * ap
        d3 += ab * bp
        d4 += ac * bp
        d5 += ab * cp
        d6 += ac * cp
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    v, w = 0.0, 0.0
    if d1 <= 0 and d2 <= 0:
        pass
    elif d3 >= 0 and d4 <= d3:
        v = 1.0
    elif d6 >= 0 and d5 <= d6:
        w = 1.0
    elif vc <= 0 and d1 >= 0 and d3 <= 0:
        v = d1 / (d1 - d3)
    elif vb <= 0 and d2 >= 0 and d6 <= 0:
        w = d2 / (d2 - d6)
    elif va <= 0 and d4 >= d3 and d5 >= d6:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        v = 1.0 - w
    elif va + vb + vc > 0:  # else there is no area, and the first corner will do
        v, w = vb / (va + vb + vc), vc / (va + vb + vc)
    return _square_at(corners, point, v, w)  # type: ignore[no-any-return]
