"""The shaft of a cell part and a target part, and condition (1): an edge that no segment of the shaft meets.

A segment runs from a point c of the open cell part, a prism, to a point t of the target part (the relative
interior of a triangle, or a closed box, which may be flat). An edge is cleared by one of four weak
separations; each is strict for every point of [c, t) because c is interior, and t itself is no concern since
no occluder meets the target (contact.py).

References
----------
E. Haines, Shaft culling tool, Journal of Graphics Tools 5 (2000): supporting planes of two boxes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import inner_kernel, kernel
from tilesnav_ref.visibility.exact import exact_determinant_sign, orientation
from tilesnav_ref.visibility.prisms import box_around, plane_side

MAX_PLANES = 12


class Shaft(NamedTuple):
    """Working memory of one shaft, overwritten by `set_shaft`; fine units."""

    cell: NDArray[np.float64]
    """(8, 3) corners of the cell part."""
    target: NDArray[np.float64]
    """(8, 3) corners of the target part; the first `counts[0]` count."""
    lower: NDArray[np.float64]
    """(3,) of the hull of both."""
    upper: NDArray[np.float64]
    """(3,)."""
    planes: NDArray[np.int64]
    """(12, 6) rows (axis i, axis j, a, b, x, y): outside is a (p_i - x) + b (p_j - y) >= 0."""
    counts: NDArray[np.int64]
    """(3,) target corners, planes, side of the target's plane on which the cell part lies (0: unknown)."""


def make_shaft() -> Shaft:
    """Working memory for one thread."""
    return Shaft(
        np.zeros((8, 3)),
        np.zeros((8, 3)),
        np.zeros(3),
        np.zeros(3),
        np.zeros((MAX_PLANES, 6), np.int64),
        np.zeros(3, np.int64),
    )


@kernel
def set_shaft(shaft, cell, target, target_count):  # type: ignore[no-untyped-def]
    """Prepare a shaft from the corners (8, 3) of the cell part and those of the target part.

    `target_count` is 3 for a triangle and 8 for a box.
    """
    shaft.cell[:] = cell
    shaft.target[:target_count] = target[:target_count]
    shaft.counts[0] = target_count
    cell_box, target_box = box_around(cell), box_around(shaft.target[:target_count])
    for k in range(3):
        shaft.lower[k] = min(cell_box[0, k], target_box[0, k])
        shaft.upper[k] = max(cell_box[1, k], target_box[1, k])
    shaft.counts[1] = 0
    for i in range(3):
        _add_planes(shaft, cell_box, target_box, (i, (i + 1) % 3))
    shaft.counts[2] = 0
    if target_count == 3:
        a, b, c = _row(shaft.target, 0), _row(shaft.target, 1), _row(shaft.target, 2)
        shaft.counts[2] = plane_side(a, b, c, cell)


@kernel
def _add_planes(shaft, cell, target, axes):  # type: ignore[no-untyped-def]
    """Lines joining like corners of the two rectangles that support both."""
    i, j = axes
    for which in range(4):
        p, q = which & 1, which >> 1
        ax, ay = np.int64(cell[p][i]), np.int64(cell[q][j])
        bx, by = np.int64(target[p][i]), np.int64(target[q][j])
        a, b = by - ay, ax - bx
        if a == 0 and b == 0:
            continue
        least, most = np.int64(0), np.int64(0)
        for corner in range(4):
            for box in range(2):
                x = np.int64(cell[corner & 1][i]) if box == 0 else np.int64(target[corner & 1][i])
                y = np.int64(cell[corner >> 1][j]) if box == 0 else np.int64(target[corner >> 1][j])
                value = a * (x - ax) + b * (y - ay)
                least, most = min(least, value), max(most, value)
        if least < 0 and most > 0:
            continue
        if most > 0:
            a, b = -a, -b
        row = shaft.planes[shaft.counts[1]]
        row[0], row[1], row[2], row[3], row[4], row[5] = i, j, a, b, ax, ay
        shaft.counts[1] += 1


@inner_kernel
def _row(points, i):  # type: ignore[no-untyped-def]
    return (points[i, 0], points[i, 1], points[i, 2])


@inner_kernel
def clears_edge(shaft, p, q):  # type: ignore[no-untyped-def]
    """Whether it is sure that no segment of the shaft meets the segment p q."""
    for k in range(3):
        if (p[k] <= shaft.lower[k] and q[k] <= shaft.lower[k]) or (
            p[k] >= shaft.upper[k] and q[k] >= shaft.upper[k]
        ):
            return True
    for row in range(shaft.counts[1]):
        if _beyond(shaft.planes[row], p) and _beyond(shaft.planes[row], q):
            return True
    if shaft.counts[2] != 0 and _behind_target(shaft, p, q):
        return True
    return _line_on_one_side(shaft, p, q)


@kernel
def is_beyond(shaft, p, q, r):  # type: ignore[no-untyped-def]
    """Whether a plane of the shaft, or that of the target, has a triangle on the far side."""
    for row in range(shaft.counts[1]):
        plane = shaft.planes[row]
        if _beyond(plane, p) and _beyond(plane, q) and _beyond(plane, r):
            return True
    return shaft.counts[2] != 0 and _behind_target(shaft, p, q) and _behind_target(shaft, r, r)


@inner_kernel
def _beyond(plane, p):  # type: ignore[no-untyped-def]
    return plane[2] * (np.int64(p[plane[0]]) - plane[4]) + plane[3] * (np.int64(p[plane[1]]) - plane[5]) >= 0


@inner_kernel
def _behind_target(shaft, p, q):  # type: ignore[no-untyped-def]
    a, b, c = _row(shaft.target, 0), _row(shaft.target, 1), _row(shaft.target, 2)
    side = shaft.counts[2]
    return orientation(a, b, c, p) * side <= 0 and orientation(a, b, c, q) * side <= 0


# Each of the two products that make a component of w carries one rounding, as does their difference; so do
# the three products and two sums of w . b. With |u| <= U, |a| <= A, |b| <= B componentwise that is at most
# 6 U A B times 8 units of 2**-53 (the same form as the determinant filter).
LINE_ERROR = 48.0 * 2.0**-53


@inner_kernel
def _line_on_one_side(shaft, p, q):  # type: ignore[no-untyped-def]
    """Whether orientation(p, q, c, t) has one weak sign for all corners c and t.

    It is bilinear in (c, t), so one weak sign at the corners, not all zero, is one strict sign for interior
    points: every line c t passes the line p q on the same side. All zero cannot be: the cell part has volume.
    """
    u0, u1, u2 = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    largest = max(abs(u0), abs(u1), abs(u2))
    least, most = 0, 0
    for i in range(8):
        a0, a1, a2 = shaft.cell[i, 0] - p[0], shaft.cell[i, 1] - p[1], shaft.cell[i, 2] - p[2]
        w0, w1, w2 = u1 * a2 - u2 * a1, u2 * a0 - u0 * a2, u0 * a1 - u1 * a0
        scale = LINE_ERROR * largest * max(abs(a0), abs(a1), abs(a2))
        for j in range(shaft.counts[0]):
            b0, b1, b2 = shaft.target[j, 0] - p[0], shaft.target[j, 1] - p[1], shaft.target[j, 2] - p[2]
            value = w0 * b0 + w1 * b1 + w2 * b2
            bound = scale * max(abs(b0), abs(b1), abs(b2))
            if value > bound:
                sign = 1
            elif value < -bound:
                sign = -1
            else:
                sign = exact_determinant_sign((b0, b1, b2), (u0, u1, u2), (a0, a1, a2))
            least, most = min(least, sign), max(most, sign)
            if least < 0 and most > 0:
                return False
    return True
