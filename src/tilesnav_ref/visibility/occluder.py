"""Growing an occluder: faces M whose odd edges all clear the shaft, crossed an odd number of times.

The set is found by a flood over units (faces, or patches of them) from one that a segment of the shaft
crosses; how it is found matters only for success. What makes it a proof is checked and nowhere assumed (spec,
Annex C): every edge that an odd number of faces of M share clears the shaft, no face of M meets the cell or
the target, and one segment in general position crosses M an odd number of times.

References
----------
D. Haumont, O. Makinen, S. Nirenstein, A low dimensional framework for exact polygon-to-polygon occlusion
queries, EGSR 2005 (silhouette patches by flood fill); I. Navazo et al., ShieldTester, CGF 22 (2003).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import inner_kernel, kernel
from tilesnav_ref.visibility.contact import meets_box, meets_prism, meets_relative_interior
from tilesnav_ref.visibility.exact import orientation
from tilesnav_ref.visibility.geometry import Geometry
from tilesnav_ref.visibility.shaft import clears_edge
from tilesnav_ref.visibility.sight import corner
from tilesnav_ref.visibility.units import Units

PROVED = 0
OPEN_EDGE = 1
"""An edge inside the shaft has no further face to go on with."""
TOO_LARGE = 2
EVEN = 3
"""The segment crosses the occluder an even number of times."""
CONTACT = 4
"""The first unit itself meets the cell or the target."""
DEGENERATE = 5
"""The segment is not in general position with the occluder."""


class Surface(NamedTuple):
    """What a flood sees of a geometry (see Geometry); few arrays, since each call copies them."""

    corners: NDArray[np.float64]
    porous: NDArray[np.bool_]
    face_edges: NDArray[np.int32]
    edge_offsets: NDArray[np.int64]
    edge_faces: NDArray[np.int32]
    edge_ends: NDArray[np.float64]


class Flood(NamedTuple):
    """Working memory of a thread: marks are valid where they equal the number of the attempt."""

    units: Units
    """What is added at a time."""
    stamps: NDArray[np.int64]
    """(3,) number of the flood, of the group of floods for one shaft, of the obstacle."""
    unit_mark: NDArray[np.int64]
    """(U,) the unit is in M."""
    edge_mark: NDArray[np.int64]
    """(E,) the parity below is valid."""
    edge_odd: NDArray[np.bool_]
    """(E,) an odd number of faces of M share the edge."""
    clear_mark: NDArray[np.int64]
    """(E,) the edge was shown to clear the shaft of this group of floods."""
    failed: NDArray[np.int64]
    """(U,) the last group of floods in which the unit was in an M that failed."""
    contact: NDArray[np.int64]
    """(U,) twice the number of the obstacle for which contact was looked at, and 1 where it may occlude."""
    members: NDArray[np.int32]
    """(limit,) the units of M."""
    edges: NDArray[np.int32]
    """Edges that wait for their test."""
    used: NDArray[np.int64]
    """(2,) numbers of units and of waiting edges."""
    success: NDArray[np.int64]
    """(U + 1,) for each unit the number of the last proof that grew from it; the number of proofs so far."""


def make_flood(geometry: Geometry, units: Units, limit: int) -> Flood:
    """Working memory for occluders of at most `limit` units."""
    count, edges = len(units.offsets) - 1, len(geometry.edge_ends)
    longest = int(np.diff(units.border_offsets).max(initial=0)) + 3
    return Flood(
        units,
        np.ones(3, np.int64),
        np.zeros(count, np.int64),
        np.zeros(edges, np.int64),
        np.zeros(edges, np.bool_),
        np.zeros(edges, np.int64),
        np.zeros(count, np.int64),
        np.zeros(count, np.int64),
        np.zeros(limit, np.int32),
        np.zeros(min(longest * limit, edges * 2 + 3), np.int32),
        np.zeros(2, np.int64),
        np.zeros(count + 1, np.int64),
    )


class Obstacle(NamedTuple):
    """What an occluder must keep off; fine units."""

    cell: NDArray[np.float64]
    """(8, 3) the whole cell, open."""
    bounds: NDArray[np.float64]
    """(2, 3) of the cell."""
    face: int
    """The target face, all of its relative interior; -1 when the target is a box."""
    box: NDArray[np.float64]
    """(2, 3) the target box, closed; that of the face when there is one."""


@kernel
def surface_of(geometry):  # type: ignore[no-untyped-def]
    """What floods see of a geometry."""
    return Surface(
        geometry.corners,
        geometry.porous,
        geometry.face_edges,
        geometry.edge_offsets,
        geometry.edge_faces,
        geometry.edge_ends,
    )


@kernel
def prove_hidden(surface, flood, work, obstacle, seed, how):  # type: ignore[no-untyped-def]
    """Try to prove by one occluder through face `seed` that no segment of the shaft reaches its target.

    `work` is (shaft, what the segment meets); `how` is (start of the segment,
    whether to stop at silhouettes). Another shaft needs another number of the group, another obstacle another
    number of its own. Returns PROVED or the reason of failure.
    """
    units = flood.units
    shaft, crossed = work
    flood.stamps[0] += 1
    flood.used[:] = 0
    unit = units.of_face[seed]
    if not _may_occlude(surface, flood, obstacle, unit):
        return CONTACT
    _add(surface, flood, obstacle, unit)
    while flood.used[1] > 0:
        flood.used[1] -= 1
        edge = flood.edges[flood.used[1]]
        if not flood.edge_odd[edge] or _clears(surface, shaft, flood, edge):
            continue
        face = _next_face(surface, flood, obstacle, edge, how)
        if face < 0:
            return _fail(flood, OPEN_EDGE)
        if flood.used[0] == len(flood.members):
            return _fail(flood, TOO_LARGE)
        unit = units.of_face[face]
        if flood.used[1] + units.border_offsets[unit + 1] - units.border_offsets[unit] + 3 > len(flood.edges):
            return _fail(flood, TOO_LARGE)
        _add(surface, flood, obstacle, unit)
    reason = _parity(flood, crossed)
    return reason if reason == PROVED else _fail(flood, reason)


@inner_kernel
def _fail(flood, reason):  # type: ignore[no-untyped-def]
    """Mark the units of M: a flood from another of them would meet with the same failure."""
    for k in range(flood.used[0]):
        flood.failed[flood.members[k]] = flood.stamps[1]
    return reason


@inner_kernel
def _may_occlude(surface, flood, obstacle, unit):  # type: ignore[no-untyped-def]
    """Whether no face of a unit meets the cell or the target; remembered for the obstacle."""
    units = flood.units
    if flood.contact[unit] >> 1 != flood.stamps[2]:
        keeps_off = _keeps_off(surface, units, obstacle, unit)
        flood.contact[unit] = 2 * flood.stamps[2] + (1 if keeps_off else 0)
    return flood.contact[unit] & 1 == 1


@inner_kernel
def _overlap(units, unit, box):  # type: ignore[no-untyped-def]
    apart = False
    for k in range(3):
        apart = apart or units.lower[unit, k] > box[1, k] or units.upper[unit, k] < box[0, k]
    return not apart


@inner_kernel
def _keeps_off(surface, units, obstacle, unit):  # type: ignore[no-untyped-def]
    first, last = units.offsets[unit], units.offsets[unit + 1]
    if surface.porous[units.faces[first]]:
        return False
    if last - first == 1 and units.faces[first] == obstacle.face:
        return False
    if _overlap(units, unit, obstacle.bounds):
        for k in range(first, last):
            if meets_prism(surface.corners, units.faces[k], obstacle.cell):
                return False
    return not _overlap(units, unit, obstacle.box) or _keeps_off_target(surface, units, obstacle, unit)


@inner_kernel
def _keeps_off_target(surface, units, obstacle, unit):  # type: ignore[no-untyped-def]
    for k in range(units.offsets[unit], units.offsets[unit + 1]):
        face = units.faces[k]
        if obstacle.face < 0:
            if meets_box(surface.corners, face, obstacle.box):
                return False
        elif face != obstacle.face and meets_relative_interior(surface.corners, face, obstacle.face):
            return False
    return True


@inner_kernel
def _add(surface, flood, obstacle, unit):  # type: ignore[no-untyped-def]
    """Add a unit to M, or what is left of it without the target."""
    units = flood.units
    flood.unit_mark[unit] = flood.stamps[0]
    flood.members[flood.used[0]] = unit
    flood.used[0] += 1
    for k in range(units.border_offsets[unit], units.border_offsets[unit + 1]):
        _toggle(flood, units.border[k])
    if obstacle.face >= 0 and units.of_face[obstacle.face] == unit:
        for k in range(3):
            _toggle(flood, surface.face_edges[obstacle.face, k])


@inner_kernel
def _toggle(flood, edge):  # type: ignore[no-untyped-def]
    if flood.edge_mark[edge] != flood.stamps[0]:
        flood.edge_mark[edge] = flood.stamps[0]
        flood.edge_odd[edge] = False
    flood.edge_odd[edge] = not flood.edge_odd[edge]
    flood.edges[flood.used[1]] = edge
    flood.used[1] += 1


@inner_kernel
def _clears(surface, shaft, flood, edge):  # type: ignore[no-untyped-def]
    if flood.clear_mark[edge] == flood.stamps[1]:
        return True
    ends = surface.edge_ends[edge]
    if clears_edge(shaft, (ends[0, 0], ends[0, 1], ends[0, 2]), (ends[1, 0], ends[1, 1], ends[1, 2])):
        flood.clear_mark[edge] = flood.stamps[1]
        return True
    return False


@inner_kernel
def _edge_side(surface, face, edge, start):  # type: ignore[no-untyped-def]
    """On which side of the plane through an edge and the start of the segment the rest of a face lies."""
    ends = surface.edge_ends[edge]
    p, q = (ends[0, 0], ends[0, 1], ends[0, 2]), (ends[1, 0], ends[1, 1], ends[1, 2])
    for k in range(3):
        if surface.face_edges[face, k] == edge:
            return orientation(start, p, q, corner(surface.corners, face, (k + 2) % 3))
    return 0


@inner_kernel
def _next_face(surface, flood, obstacle, edge, how):  # type: ignore[no-untyped-def]
    """A face to close an odd edge with, or -1.

    As seen from the start of the segment, a face that continues M across the edge is preferred to one that
    folds back (a silhouette, or the twin of a doubled face).
    """
    units = flood.units
    start, stop_at_silhouettes = how
    first, last = surface.edge_offsets[edge], surface.edge_offsets[edge + 1]
    side = 0
    for k in range(first, last):
        if flood.unit_mark[units.of_face[surface.edge_faces[k]]] == flood.stamps[0]:
            side = _edge_side(surface, surface.edge_faces[k], edge, start)
    other = -1
    for k in range(first, last):
        face = surface.edge_faces[k]
        unit = units.of_face[face]
        if flood.unit_mark[unit] == flood.stamps[0] or not _may_occlude(surface, flood, obstacle, unit):
            continue
        if _edge_side(surface, face, edge, start) * side < 0:
            return face
        other = face
    return -1 if stop_at_silhouettes else other


@inner_kernel
def _parity(flood, crossed):  # type: ignore[no-untyped-def]
    units = flood.units
    odd = False
    for i in range(crossed.counts[1]):
        if flood.unit_mark[units.of_face[crossed.faces[i]]] == flood.stamps[0]:
            odd = not odd
    for i in range(crossed.counts[2]):
        if flood.unit_mark[units.of_face[crossed.touched[i]]] == flood.stamps[0]:
            return DEGENERATE
    return PROVED if odd else EVEN
