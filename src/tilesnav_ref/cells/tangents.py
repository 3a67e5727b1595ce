"""Cut lines: the lowest line over points, measured at the middle of an interval.

Notes
-----
A line over an interval takes least from the area above it where its value at the middle is least. The lowest
line at the middle that runs over all points is the edge of their upper hull there. It is found by exchange:
a line through a point on the left and one on the right of the middle, of which one gives way to the point
that lies furthest above the line, until none does. Points that stand for faces ask for the clearance as
distance to the line. All of it is floating point: lines are guesses that exact tests judge.

References
----------
D. G. Kirkpatrick, R. Seidel, "The ultimate planar convex hull algorithm?", SIAM Journal on Computing 15(1),
1986 (bridges); the exchange is the simplex method of two unknowns.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel

_EXCHANGES = 24
"""A bridge over thousands of points needs about five."""
_CLOSE = 1e-3
"""Grid steps; lines are moved up at the end by what is missing, so this decides nothing."""


@kernel
def _missing(
    points: tuple[NDArray[np.float64], NDArray[np.float64]], line: tuple[float, float, float], shift: float
) -> tuple[float, int]:
    """How far the highest point lies above a line (u, v, slope), and which it is."""
    us, vs = points
    u, v, slope = line
    most, which = -np.inf, -1
    for p in range(len(us)):
        over = vs[p] + shift - v - slope * (us[p] - u)
        if over > most:
            most, which = over, p
    return most, which


@kernel
def lowest_line(
    points: tuple[NDArray[np.float64], NDArray[np.float64]],
    ends: tuple[float, float],
    floor: float,
    clearance: float,
) -> tuple[float, float]:
    """Values at both ends of the line over the points that is lowest at the middle and not below the floor.

    Parameters
    ----------
    points
        u and v, (P,) each.
    ends
        Interval of u.
    floor
        Least value at both ends.
    clearance
        Distance of the line from the points.
    """
    us, vs = points
    u0, u1 = ends
    middle = (u0 + u1) / 2.0
    left_u, left_v, right_u, right_v, slope, shift = u0, floor, u1, floor, 0.0, clearance
    for _ in range(_EXCHANGES):
        shift = clearance * math.sqrt(1.0 + slope * slope)
        most, which = _missing(points, (left_u, left_v, slope), shift)
        new_u, new_v = u0, floor
        if which >= 0:
            new_u, new_v = us[which], vs[which] + shift
        for u in (u0, u1):
            over = floor - left_v - slope * (u - left_u)
            if over > most:
                most, new_u, new_v = over, u, floor
        if most <= _CLOSE:
            break
        if new_u <= middle:
            left_u, left_v = new_u, new_v
        else:
            right_u, right_v = new_u, new_v
        slope = (right_v - left_v) / (right_u - left_u)
    shift = clearance * math.sqrt(1.0 + slope * slope)
    up = max(_missing(points, (left_u, left_v, slope), shift)[0], 0.0)
    y0, y1 = left_v + up + slope * (u0 - left_u), left_v + up + slope * (u1 - left_u)
    up = max(floor - y0, floor - y1, 0.0)
    return y0 + up, y1 + up


@kernel
def pinned_line(
    points: tuple[NDArray[np.float64], NDArray[np.float64]],
    pin: tuple[float, float, float],
    floor: float,
    clearance: float,
) -> float:
    """Value at u = pin[2] of the lowest line through (pin[0], pin[1]) over the points; inf where there is
    none."""
    us, vs = points
    at, value, end = pin
    direction = 1.0 if end > at else -1.0
    steep, shift = (floor - value) / abs(end - at), clearance
    for _ in range(3):  # the shift follows the slope
        best = (floor - value) / abs(end - at)
        shift = clearance * math.sqrt(1.0 + steep * steep)
        for p in range(len(us)):
            away = direction * (us[p] - at)
            if away > clearance + 1.0:  # nearer ones ask for any slope: the test at the end judges them
                best = max(best, (vs[p] + shift - value) / away)
        steep = best
    shift = clearance * math.sqrt(1.0 + steep * steep)
    for p in range(len(us)):
        if vs[p] + shift - value - steep * direction * (us[p] - at) > 1.0:
            return np.inf
    return value + steep * abs(end - at)
