"""Level codes by a bracket of L* that holds, not by samples of it.

With r = p - x and n the unit normal of a face, L >= l means l |r|^2 - n.r <= 0. The left side is convex in r,
and r runs over the convex hull of all differences of corners. The method of Frank and Wolfe (1956) finds its
least value, and the duality gap bounds that value from below; so each question "is L* >= l" is answered with
a proof in both directions.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from functools import cache

import numpy as np
from numpy.typing import NDArray

from casebuilder.exact import cell_corners
from casebuilder.world import Cell, Lod, Triangle

STEPS = 20000
MARGIN = 1e-3
"""Relative distance of L* from the border between two codes, so that no judge can differ by rounding."""


def reaches(points: NDArray[np.float64], normal: NDArray[np.float64], level: float) -> bool:
    """Whether some r in the hull of points has |n.r| / |r|^2 >= level; raises ValueError when undecided."""
    for signed in (normal, -normal):
        r = points[np.argmin(level * (points**2).sum(axis=1) - points @ signed)]
        for _ in range(STEPS):
            value = level * (r @ r) - signed @ r
            if value <= 0:
                return True
            gradient = 2 * level * r - signed
            towards = points[np.argmin(points @ gradient)] - r
            gap = -(gradient @ towards)
            if value - gap > 0:
                break
            r = r + min(1.0, gap / (2 * level * (towards @ towards))) * towards
        else:
            raise ValueError(f"undecided whether L reaches {level}")
    return False


@cache
def face_reaches(cell: Cell, exponent: int, face: Triangle, level: float) -> bool:
    """Whether L* of a closed cell and a face is at least level."""
    step = 2.0**exponent
    corners = np.array([[float(v) for v in c] for c in cell_corners(cell, exponent)]) * step
    triangle = np.array(face, dtype=np.float64) * step
    normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
    length = math.sqrt(normal @ normal)
    if length == 0:
        return False
    points = (corners[:, None, :] - triangle[None, :, :]).reshape(-1, 3)
    return reaches(points, normal / length, level)


def level_code(cell: Cell, exponent: int, faces: tuple[Triangle, ...], lod: Lod) -> int:
    """Code of the largest L over a cell and some faces; raises ValueError near the border of two codes."""

    def code_at(factor: float) -> int:
        def reached(code: int) -> bool:
            border = factor * lod.reference * lod.base ** -(code + 1)
            return any(face_reaches(cell, exponent, face, border) for face in faces)

        return bisect_left(range(lod.level_count - 1), True, key=reached)

    code = code_at(1 + MARGIN)
    if code != code_at(1 - MARGIN):
        raise ValueError(f"L* of {cell} is too close to the border of code {code}")
    return code
