"""Faces that a cell cannot see wherever it looks from: beyond the range, or one-sided and seen from behind.

Nothing here takes part in a certificate: no segment to such a face counts, free or not.

References
----------
W. Cheney, A. A. Goldstein, Proximity maps for convex sets, Proceedings of the AMS 10 (1959): alternating
projections find the nearest points of two convex sets. They only suggest a direction; the gap along it is
what bounds the distance.
"""

from __future__ import annotations

import numpy as np

from tilesnav_ref.kernels import kernel
from tilesnav_ref.visibility.exact import orientation
from tilesnav_ref.visibility.geometry import UNLIMITED
from tilesnav_ref.visibility.prisms import box_around
from tilesnav_ref.visibility.sight import STACK, corner

PROJECTIONS = 12
"""More of them leave a few faces out that are hardly farther away than the range."""

# A gap below 2**62 and a squared length below 2**62 are each rounded once to float64, the root and the
# product once more: less than 4 units of 2**-53.
ROUNDING = 1.0 + 2.0**-50


@kernel
def leave_out(geometry, prism, alive):  # type: ignore[no-untyped-def]
    """Clear `alive` (F,) for faces that no point of a prism (8, 3) can see for reasons of range or side."""
    if geometry.far >= UNLIMITED and not geometry.one_sided.any():
        return
    box = box_around(prism)
    stack = np.empty(STACK, np.int32)
    stack[0] = 0
    top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        child = geometry.box_child[node]
        first, last = geometry.box_first[node], geometry.box_first[node] + geometry.box_count[node]
        if _boxes_are_far(geometry, box, geometry.box_lower[node], geometry.box_upper[node]):
            for k in range(first, last):
                alive[geometry.face_order[k]] = False
        elif child >= 0:
            stack[top] = child
            stack[top + 1] = child + 1
            top += 2
        else:
            for k in range(first, last):
                face = geometry.face_order[k]
                alive[face] = alive[face] and not is_out(geometry, prism, face)


@kernel
def is_out(geometry, prism, face):  # type: ignore[no-untyped-def]
    """Whether no point of a prism (8, 3) can see a face for reasons of range or side."""
    return pair_is_out(geometry, prism, geometry.corners[face], face)


@kernel
def pair_is_out(geometry, prism, part, face):  # type: ignore[no-untyped-def]
    """Whether no segment from a prism (8, 3) to a part (3, 3) of a face counts for reasons of range or side.

    That holds for the closures of both, so such pairs may be left out of a subdivision (spec, Annex C). The
    range is measured from the box around the prism.
    """
    if geometry.one_sided[face] and _is_behind(geometry, prism, face):
        return True
    return geometry.far < UNLIMITED and _part_is_far(geometry, box_around(prism), part)


@kernel
def _is_behind(geometry, prism, face):  # type: ignore[no-untyped-def]
    corners = geometry.corners
    p, q, r = corner(corners, face, 0), corner(corners, face, 1), corner(corners, face, 2)
    behind = True
    for i in range(8):
        behind = behind and orientation(p, q, r, (prism[i, 0], prism[i, 1], prism[i, 2])) <= 0
    return behind


@kernel
def _boxes_are_far(geometry, box, lower, upper):  # type: ignore[no-untyped-def]
    """Whether two boxes are at least the range apart; gaps are below 2**30, so their squares are exact."""
    if geometry.far >= UNLIMITED:
        return False
    total = np.int64(0)
    for k in range(3):
        gap = np.int64(max(lower[k] - box[1, k], box[0, k] - upper[k], 0.0))
        total += gap * gap
    return total >= geometry.far * geometry.far


@kernel
def _part_is_far(geometry, box, part):  # type: ignore[no-untyped-def]
    """Whether a triangle is surely at least the range away from a box."""
    on_face = (part[0] + part[1] + part[2]) / 3.0
    on_box = np.empty(3)
    for _ in range(PROJECTIONS):
        distance = 0.0
        for k in range(3):
            on_box[k] = min(max(on_face[k], box[0, k]), box[1, k])
            distance += (on_face[k] - on_box[k]) ** 2
        if distance < float(geometry.near) ** 2:
            return False  # the answer "near" needs no proof
        on_face = _nearest_on_triangle(part, on_box)
    return _gap_is_wide(geometry, box, part, (np.round(on_face - on_box), np.round(on_box)))


@kernel
def _gap_is_wide(geometry, box, part, how):  # type: ignore[no-untyped-def]
    """Whether the gap between box and triangle along a direction is at least the range wide.

    `how` is (direction, a point about which heights are taken), integer-valued. Differences are below 2**30
    and so are components of the direction: heights are sums of three products below 2**60, exact in int64.
    """
    direction, about = how
    length = np.int64(0)
    top = np.int64(0)
    for k in range(3):
        n = np.int64(direction[k])
        length += n * n
        top += max(n * np.int64(box[0, k] - about[k]), n * np.int64(box[1, k] - about[k]))
    least = np.int64(2**62)
    for i in range(3):
        height = np.int64(0)
        for k in range(3):
            height += np.int64(direction[k]) * np.int64(part[i, k] - about[k])
        least = min(least, height)
    if least <= top or length == 0:
        return False
    return float(least - top) >= float(geometry.far) * np.sqrt(float(length)) * ROUNDING


@kernel
def _nearest_on_triangle(part, point):  # type: ignore[no-untyped-def]
    """Point of a triangle nearest to a point, rounded."""
    u, v, w = part[1] - part[0], part[2] - part[0], point - part[0]
    uu, uv, vv = (u * u).sum(), (u * v).sum(), (v * v).sum()
    uw, vw = (u * w).sum(), (v * w).sum()
    whole = uu * vv - uv * uv
    one, two = vv * uw - uv * vw, uu * vw - uv * uw
    if one > 0.0 and two > 0.0 and one + two < whole:
        return part[0] + u * (one / whole) + v * (two / whole)
    best = part[0]
    least = np.inf
    for k in range(3):
        start, along = part[k], part[(k + 1) % 3] - part[k]
        share = min(max((along * (point - start)).sum() / (along * along).sum(), 0.0), 1.0)
        found = start + along * share
        distance = ((found - point) ** 2).sum()
        if distance < least:
            best, least = found, distance
    return best
