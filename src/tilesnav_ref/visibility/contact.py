"""Condition (2) of the parity theorem: an occluder face keeps off the cell and off the target.

Every function may answer "meets" for faces that do not (the proof is then not tried), never the reverse.

References
----------
O. Devillers, P. Guigue, Faster triangle-triangle intersection tests, INRIA RR-4488 (2002): tests by
orientation signs only.
"""

from __future__ import annotations

import numpy as np

from tilesnav_ref.kernels import kernel
from tilesnav_ref.visibility.exact import difference, orientation
from tilesnav_ref.visibility.prisms import beyond_slants, box_around, box_prism, plane_side
from tilesnav_ref.visibility.sight import corner


@kernel
def meets_relative_interior(corners, face, target):  # type: ignore[no-untyped-def]
    """Whether a face may meet the relative interior of another; contact along the target's border is free."""
    if _boxes_apart(corners, face, target):
        return False
    a, b, c = corner(corners, target, 0), corner(corners, target, 1), corner(corners, target, 2)
    p, q, r = corner(corners, face, 0), corner(corners, face, 1), corner(corners, face, 2)
    sp, sq, sr = orientation(a, b, c, p), orientation(a, b, c, q), orientation(a, b, c, r)
    if sp == 0 and sq == 0 and sr == 0:
        return not _coplanar_apart(corners, face, target)
    if (sp >= 0 and sq >= 0 and sr >= 0) or (sp <= 0 and sq <= 0 and sr <= 0):
        return _one_side_contact((a, b, c), (p, q, r), (sp, sq, sr))
    ta, tb, tc = orientation(p, q, r, a), orientation(p, q, r, b), orientation(p, q, r, c)
    if (ta >= 0 and tb >= 0 and tc >= 0) or (ta <= 0 and tb <= 0 and tc <= 0):
        return False  # the target touches the plane of the face with its border at most
    return _edges_pierce((a, b, c), (p, q, r)) or _edges_pierce((p, q, r), (a, b, c))


@kernel
def _boxes_apart(corners, face, target):  # type: ignore[no-untyped-def]
    for k in range(3):
        low = min(corners[face, 0, k], corners[face, 1, k], corners[face, 2, k])
        high = max(corners[face, 0, k], corners[face, 1, k], corners[face, 2, k])
        target_low = min(corners[target, 0, k], corners[target, 1, k], corners[target, 2, k])
        target_high = max(corners[target, 0, k], corners[target, 1, k], corners[target, 2, k])
        if high < target_low or low > target_high:
            return True
    return False


@kernel
def _one_side_contact(target, face, sides):  # type: ignore[no-untyped-def]
    """A face weakly on one side meets the target's plane in nothing, a vertex or an edge."""
    on_plane = (sides[0] == 0) + (sides[1] == 0) + (sides[2] == 0)
    if on_plane == 0:
        return False
    if on_plane == 1:
        point = face[0] if sides[0] == 0 else (face[1] if sides[1] == 0 else face[2])
        return _segment_enters(target, point, point)
    if sides[0] != 0:
        return _segment_enters(target, face[1], face[2])
    if sides[1] != 0:
        return _segment_enters(target, face[0], face[2])
    return _segment_enters(target, face[0], face[1])


@kernel
def _projection(target):  # type: ignore[no-untyped-def]
    """Two axes whose projection keeps the target's area: all but the largest component of its normal."""
    u, v = difference(target[1], target[0]), difference(target[2], target[0])
    u0, u1, u2 = np.int64(u[0]), np.int64(u[1]), np.int64(u[2])
    v0, v1, v2 = np.int64(v[0]), np.int64(v[1]), np.int64(v[2])
    nx = abs(u1 * v2 - u2 * v1)
    ny = abs(u2 * v0 - u0 * v2)
    nz = abs(u0 * v1 - u1 * v0)
    if nx >= ny and nx >= nz:
        return 1, 2
    if ny >= nz:
        return 2, 0
    return 0, 1


@kernel
def _turn(a, b, p, i, j):  # type: ignore[no-untyped-def]
    """Sign of the turn a, b, p in the projection on axes i, j; exact: differences below 2**30."""
    value = np.int64(b[i] - a[i]) * np.int64(p[j] - a[j]) - np.int64(b[j] - a[j]) * np.int64(p[i] - a[i])
    return 1 if value > 0 else (-1 if value < 0 else 0)


@kernel
def _segment_enters(target, p, q):  # type: ignore[no-untyped-def]
    """Whether a segment (or point) in the target's plane meets the target's relative interior.

    Both are convex: they are apart exactly when one of the target's edges, or the line of the segment, has
    them weakly on two sides.
    """
    i, j = _projection(target)
    turn = _turn(target[0], target[1], target[2], i, j)
    if turn == 0:
        return True  # no area, no answer
    for k in range(3):
        a, b = target[k], target[(k + 1) % 3]
        if _turn(a, b, p, i, j) * turn <= 0 and _turn(a, b, q, i, j) * turn <= 0:
            return False
    s = (_turn(p, q, target[0], i, j), _turn(p, q, target[1], i, j), _turn(p, q, target[2], i, j))
    one_side = (s[0] >= 0 and s[1] >= 0 and s[2] >= 0) or (s[0] <= 0 and s[1] <= 0 and s[2] <= 0)
    is_point = p[0] == q[0] and p[1] == q[1] and p[2] == q[2]
    return is_point or not one_side


@kernel
def _coplanar_apart(corners, face, target):  # type: ignore[no-untyped-def]
    """Whether a coplanar face surely keeps off the target's relative interior: a weakly separating edge."""
    t = (corner(corners, target, 0), corner(corners, target, 1), corner(corners, target, 2))
    f = (corner(corners, face, 0), corner(corners, face, 1), corner(corners, face, 2))
    i, j = _projection(t)
    return _edge_separates(t, f, i, j) or _edge_separates(f, t, i, j)


@kernel
def _edge_separates(a, b, i, j):  # type: ignore[no-untyped-def]
    turn = _turn(a[0], a[1], a[2], i, j)
    if turn == 0:
        return False
    for k in range(3):
        p, q = a[k], a[(k + 1) % 3]
        s0, s1, s2 = (
            _turn(p, q, b[0], i, j) * turn,
            _turn(p, q, b[1], i, j) * turn,
            _turn(p, q, b[2], i, j) * turn,
        )
        if s0 <= 0 and s1 <= 0 and s2 <= 0:
            return True
    return False


@kernel
def _edges_pierce(a, b):  # type: ignore[no-untyped-def]
    """Whether an edge of triangle a meets the closed triangle b; edges in the plane of b count as meeting."""
    for k in range(3):
        p, q = a[k], a[(k + 1) % 3]
        sp = orientation(b[0], b[1], b[2], p)
        sq = orientation(b[0], b[1], b[2], q)
        if sp * sq > 0:
            continue
        one = orientation(p, q, b[0], b[1])
        two = orientation(p, q, b[1], b[2])
        three = orientation(p, q, b[2], b[0])
        if not (min(one, two, three) < 0 and max(one, two, three) > 0):
            return True
    return False


@kernel
def meets_box(corners, face, box):  # type: ignore[no-untyped-def]
    """Whether a face may meet a closed box (2, 3)."""
    for k in range(3):
        low = min(corners[face, 0, k], corners[face, 1, k], corners[face, 2, k])
        high = max(corners[face, 0, k], corners[face, 1, k], corners[face, 2, k])
        if high < box[0, k] or low > box[1, k]:
            return False
    return _in_reach_of_plane(corners, face, box_prism(box))


@kernel
def _in_reach_of_plane(corners, face, prism):  # type: ignore[no-untyped-def]
    """Whether the plane of a face meets a closed prism."""
    p, q, r = corner(corners, face, 0), corner(corners, face, 1), corner(corners, face, 2)
    least, most = 1, -1
    for i in range(8):
        side = orientation(p, q, r, (prism[i, 0], prism[i, 1], prism[i, 2]))
        least, most = min(least, side), max(most, side)
    return least <= 0 and most >= 0


@kernel
def meets_prism(corners, face, prism):  # type: ignore[no-untyped-def]
    """Whether a face may meet an open prism (8, 3)."""
    box = box_around(prism)
    for k in range(3):
        low = min(corners[face, 0, k], corners[face, 1, k], corners[face, 2, k])
        high = max(corners[face, 0, k], corners[face, 1, k], corners[face, 2, k])
        if high <= box[0, k] or low >= box[1, k]:
            return False
    p, q, r = corner(corners, face, 0), corner(corners, face, 1), corner(corners, face, 2)
    return plane_side(p, q, r, prism) == 0 and not beyond_slants(prism, corners[face])
