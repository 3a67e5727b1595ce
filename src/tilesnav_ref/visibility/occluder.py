"""Growing an occluder: faces M whose odd edges all clear the shaft, crossed an odd number of times.

The set is found by a flood from a face that one segment of the shaft crosses; how it is found matters only
for success. What makes it a proof is checked and nowhere assumed (spec, Annex C): every edge that an odd
number of faces of M share clears the shaft, no face of M meets the cell or the target, and one segment in
general position crosses M an odd number of times.

References
----------
D. Haumont, O. Makinen, S. Nirenstein, A low dimensional framework for exact polygon-to-polygon occlusion
queries, EGSR 2005 (silhouette patches by flood fill); I. Navazo et al., ShieldTester, CGF 22 (2003).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.visibility.contact import meets_box, meets_relative_interior
from tilesnav_ref.visibility.exact import orientation
from tilesnav_ref.visibility.geometry import Geometry
from tilesnav_ref.visibility.shaft import clears_edge
from tilesnav_ref.visibility.sight import CROSS, MISS, corner, meet

PROVED = 0
OPEN_EDGE = 1
"""An edge inside the shaft has no further face to go on with."""
TOO_LARGE = 2
EVEN = 3
"""The segment crosses the occluder an even number of times."""
CONTACT = 4
"""The first face itself meets the cell or the target."""
DEGENERATE = 5
"""The segment is not in general position with the occluder."""


class Flood(NamedTuple):
    """Working memory of a thread: marks are valid where they equal the number of the attempt."""

    stamp: NDArray[np.int64]
    """(1,) number of the attempt."""
    face_mark: NDArray[np.int64]
    """(F,) the face is in M."""
    edge_mark: NDArray[np.int64]
    """(E,) the parity below is valid."""
    edge_odd: NDArray[np.bool_]
    """(E,) an odd number of faces of M share the edge."""
    clear_mark: NDArray[np.int64]
    """(E,) the edge was shown to clear the shaft."""
    failed: NDArray[np.int64]
    """(F + 1,) the last group of attempts in which the face was in an M that failed; the present group."""
    faces: NDArray[np.int32]
    """(limit,) the faces of M."""
    edges: NDArray[np.int32]
    """(3 limit + 3,) edges that wait for their test."""
    used: NDArray[np.int64]
    """(2,) numbers of faces and of waiting edges."""


def make_flood(geometry: Geometry, limit: int) -> Flood:
    """Working memory for occluders of at most `limit` faces."""
    faces, edges = len(geometry.corners), len(geometry.edge_ends)
    return Flood(
        np.zeros(1, np.int64),
        np.zeros(faces, np.int64),
        np.zeros(edges, np.int64),
        np.zeros(edges, np.bool_),
        np.zeros(edges, np.int64),
        np.zeros(faces + 1, np.int64),
        np.zeros(limit, np.int32),
        np.zeros(3 * limit + 3, np.int32),
        np.zeros(2, np.int64),
    )


class Obstacle(NamedTuple):
    """What an occluder must keep off; fine units."""

    cell: NDArray[np.float64]
    """(2, 3) the whole cell, open."""
    face: int
    """The target face, all of its relative interior; -1 when the target is a box."""
    box: NDArray[np.float64]
    """(2, 3) the target box, closed; used when face is -1."""


@kernel
def prove_hidden(geometry, work, obstacle, seed, segment, stop_at_silhouettes):  # type: ignore[no-untyped-def]
    """Try to prove by one occluder through face `seed` that no segment of the shaft reaches its target.

    `work` holds the shaft and the flood; `segment` is (c, t), a segment of the shaft that
    crosses `seed`. Returns PROVED or the reason of failure.
    """
    shaft, flood = work.shaft, work.flood
    flood.stamp[0] += 1
    flood.used[:] = 0
    if not _may_occlude(geometry, obstacle, seed):
        return CONTACT
    _add(geometry, flood, seed)
    while flood.used[1] > 0:
        flood.used[1] -= 1
        edge = flood.edges[flood.used[1]]
        if not flood.edge_odd[edge] or _clears(geometry, shaft, flood, edge):
            continue
        face = _next_face(geometry, flood, obstacle, edge, (segment, stop_at_silhouettes))
        if face < 0:
            return _fail(flood, OPEN_EDGE)
        if flood.used[0] == len(flood.faces):
            return _fail(flood, TOO_LARGE)
        _add(geometry, flood, face)
    reason = _parity(geometry, flood, segment)
    return reason if reason == PROVED else _fail(flood, reason)


@kernel
def _fail(flood, reason):  # type: ignore[no-untyped-def]
    """Mark the faces of M: a flood from another of them would meet with the same failure."""
    for k in range(flood.used[0]):
        flood.failed[flood.faces[k]] = flood.failed[-1]
    return reason


@kernel
def _may_occlude(geometry, obstacle, face):  # type: ignore[no-untyped-def]
    if geometry.porous[face] or face == obstacle.face:
        return False
    if meets_box(geometry.corners, face, obstacle.cell[0], obstacle.cell[1], False):
        return False
    if obstacle.face >= 0:
        return not meets_relative_interior(geometry.corners, face, obstacle.face)
    return not meets_box(geometry.corners, face, obstacle.box[0], obstacle.box[1], True)


@kernel
def _add(geometry, flood, face):  # type: ignore[no-untyped-def]
    flood.face_mark[face] = flood.stamp[0]
    flood.faces[flood.used[0]] = face
    flood.used[0] += 1
    for k in range(3):
        edge = geometry.face_edges[face, k]
        if flood.edge_mark[edge] != flood.stamp[0]:
            flood.edge_mark[edge] = flood.stamp[0]
            flood.edge_odd[edge] = False
        flood.edge_odd[edge] = not flood.edge_odd[edge]
        flood.edges[flood.used[1]] = edge
        flood.used[1] += 1


@kernel
def _clears(geometry, shaft, flood, edge):  # type: ignore[no-untyped-def]
    if flood.clear_mark[edge] == flood.stamp[0]:
        return True
    ends = geometry.edge_ends[edge]
    if clears_edge(shaft, (ends[0, 0], ends[0, 1], ends[0, 2]), (ends[1, 0], ends[1, 1], ends[1, 2])):
        flood.clear_mark[edge] = flood.stamp[0]
        return True
    return False


@kernel
def _edge_side(geometry, face, edge, start):  # type: ignore[no-untyped-def]
    """On which side of the plane through an edge and the start of the segment the rest of a face lies."""
    ends = geometry.edge_ends[edge]
    p, q = (ends[0, 0], ends[0, 1], ends[0, 2]), (ends[1, 0], ends[1, 1], ends[1, 2])
    for k in range(3):
        if geometry.face_edges[face, k] == edge:
            return orientation(start, p, q, corner(geometry.corners, face, (k + 2) % 3))
    return 0


@kernel
def _next_face(geometry, flood, obstacle, edge, how):  # type: ignore[no-untyped-def]
    """A face to close an odd edge with, or -1.

    As seen from the start of the segment, a face that continues M across the edge is preferred to one that
    folds back (a silhouette, or the twin of a doubled face).
    """
    segment, stop_at_silhouettes = how
    first, last = geometry.edge_offsets[edge], geometry.edge_offsets[edge + 1]
    side = 0
    for k in range(first, last):
        if flood.face_mark[geometry.edge_faces[k]] == flood.stamp[0]:
            side = _edge_side(geometry, geometry.edge_faces[k], edge, segment[0])
    other = -1
    for k in range(first, last):
        face = geometry.edge_faces[k]
        if flood.face_mark[face] == flood.stamp[0] or not _may_occlude(geometry, obstacle, face):
            continue
        if _edge_side(geometry, face, edge, segment[0]) * side < 0:
            return face
        other = face
    return -1 if stop_at_silhouettes else other


@kernel
def _parity(geometry, flood, segment):  # type: ignore[no-untyped-def]
    odd = False
    for i in range(flood.used[0]):
        how = meet(geometry.corners, flood.faces[i], segment[0], segment[1])
        if how == CROSS:
            odd = not odd
        elif how != MISS:
            return DEGENERATE
    return PROVED if odd else EVEN
