"""Faces hidden by the sheet that they belong to.

The back of a wall is hidden by the rest of its house. The rest of a sheet, without the target itself, is an
occluder like any other (spec, Annex C): its border is the border of the sheet, which few shafts meet, and the
edges of the target, which lie in the target's plane. So no occluder has to be grown, and what a sheet has to
keep off is looked at once for each region.
"""

from __future__ import annotations

import numpy as np

from tilesnav_ref.kernels import kernel
from tilesnav_ref.visibility.contact import meets_prism, meets_relative_interior
from tilesnav_ref.visibility.exact import COORDINATE_BITS
from tilesnav_ref.visibility.record import OPEN as OPEN_WORDS
from tilesnav_ref.visibility.record import put, set_word
from tilesnav_ref.visibility.segments import inner_point, inner_point_of_face, weighted_point
from tilesnav_ref.visibility.shaft import clears_edge, is_beyond
from tilesnav_ref.visibility.sight import STACK, corner, find_crossed

UNKNOWN, BLOCKED, OPEN = 0, 1, 2
"""Of a sheet and a region: not looked at; the sheet meets the region; it keeps off."""
SEGMENTS = 3
"""Segments that are tried when one is not in general position."""
PROBES = 3
"""Probes from each side of a face: an odd number, so that most of them say one thing."""
REACH = 2.0**29
"""Length of a probe in fine units, about."""
FARTHEST = 2.0**COORDINATE_BITS - 1.0


@kernel
def crossings_of_sheet(sheets, crossed, sheet):  # type: ignore[no-untyped-def]
    """How often a segment crosses a sheet; -1 when it is not in general position with it."""
    for k in range(crossed.counts[2]):
        if sheets.of_face[crossed.touched[k]] == sheet:
            return -1
    number = 0
    for k in range(crossed.counts[1]):
        number += sheets.of_face[crossed.faces[k]] == sheet
    return number


@kernel
def _is_clean(geometry, sheets, face):  # type: ignore[no-untyped-def]
    """Whether no other face of its sheet meets the relative interior of a face."""
    sheet = sheets.of_face[face]
    lower, upper = np.empty(3), np.empty(3)
    for k in range(3):
        lower[k], upper[k] = geometry.corners[face, :, k].min(), geometry.corners[face, :, k].max()
    stack = np.empty(STACK, np.int32)
    stack[0] = 0
    top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        apart = False
        for k in range(3):
            apart = apart or geometry.box_lower[node, k] > upper[k] or geometry.box_upper[node, k] < lower[k]
        if apart:
            continue
        if geometry.box_child[node] >= 0:
            stack[top] = geometry.box_child[node]
            stack[top + 1] = geometry.box_child[node] + 1
            top += 2
            continue
        for k in range(geometry.box_first[node], geometry.box_first[node] + geometry.box_count[node]):
            other = geometry.face_order[k]
            if other == face or sheets.of_face[other] != sheet:
                continue
            if meets_relative_interior(geometry.corners, other, face):
                return False
    return True


@kernel
def find_inner_sides(geometry, division, crossed):  # type: ignore[no-untyped-def]
    """Fill `inner` (F,) of a division by probes that leave each face on both sides.

    It is only a guess of what is worth trying. A side from which most probes cross the rest of the sheet an
    odd number of times is inside. Faces that another face of their sheet meets get 0: their sheet is no
    occluder for them.
    """
    inner = division.inner
    for face in range(len(inner)):
        if geometry.porous[face] or not _is_clean(geometry, division.sheets, face):
            continue
        votes = (
            _votes(geometry, division.sheets, crossed, (face, 1.0)),
            _votes(geometry, division.sheets, crossed, (face, -1.0)),
        )
        if votes[0] * 2 > PROBES and votes[1] * 2 < PROBES:
            inner[face] = 1
        elif votes[1] * 2 > PROBES and votes[0] * 2 < PROBES:
            inner[face] = -1


@kernel
def _far(start, way):  # type: ignore[no-untyped-def]
    return np.floor(min(max(start + REACH * way, -FARTHEST), FARTHEST))


@kernel
def _votes(geometry, sheets, crossed, what):  # type: ignore[no-untyped-def]
    """Number of probes from one side of a face that cross its sheet an odd number of times."""
    face, side = what
    p = geometry.corners[face]
    u0, u1, u2 = p[1, 0] - p[0, 0], p[1, 1] - p[0, 1], p[1, 2] - p[0, 2]
    v0, v1, v2 = p[2, 0] - p[0, 0], p[2, 1] - p[0, 1], p[2, 2] - p[0, 2]
    n = np.array((u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0))
    size = np.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
    if size == 0.0:
        return 0
    t = weighted_point(p, (2, 1, 1), 4)
    # Any ways upwards in different directions do: proofs do not rest on them.
    ways = ((0.62, 0.35, 0.73), (-0.71, 0.41, 0.67), (0.23, -0.77, 0.7))
    found = 0
    for way in ways:
        along = way[0] * n[0] + way[1] * n[1] + way[2] * n[2]
        # Upwards for walls; a way that points to the other side is turned back to this one.
        turn = -2.0 * along / size if along * side < 0 else 0.0
        c = (
            _far(t[0], way[0] + (turn + 0.1 * side) * n[0] / size),
            _far(t[1], way[1] + (turn + 0.1 * side) * n[1] / size),
            _far(t[2], way[2] + (turn + 0.1 * side) * n[2] / size),
        )
        if find_crossed(geometry, c, t, face, crossed):
            number = crossings_of_sheet(sheets, crossed, sheets.of_face[face])
            found += number % 2 == 1 and number > 0
    return found


@kernel
def sheet_keeps_off(corners, sheets, memory, sheet, region):  # type: ignore[no-untyped-def]
    """Whether no face of a sheet meets the open region (8, 3).

    `memory` is (states (S,), the region (8, 3) that they hold for); another region begins anew.
    """
    states, known = memory
    if not np.array_equal(known, region):
        known[:] = region
        states[:] = UNKNOWN
    if states[sheet] == UNKNOWN:
        states[sheet] = OPEN
        for k in range(sheets.offsets[sheet], sheets.offsets[sheet + 1]):
            if meets_prism(corners, sheets.faces[k], region):
                states[sheet] = BLOCKED
                break
    return states[sheet] == OPEN


@kernel
def border_clears(edge_ends, sheets, shaft, sheet):  # type: ignore[no-untyped-def]
    """Whether all of the border of a sheet clears the present shaft."""
    for k in range(sheets.border_offsets[sheet], sheets.border_offsets[sheet + 1]):
        ends = edge_ends[sheets.border[k]]
        if not clears_edge(shaft, (ends[0, 0], ends[0, 1], ends[0, 2]), (ends[1, 0], ends[1, 1], ends[1, 2])):
            return False
    return True


@kernel
def reaches(geometry, shaft, face):  # type: ignore[no-untyped-def]
    """Whether a face may meet the present shaft: no single plane separates them."""
    p = geometry.corners[face]
    for k in range(3):
        if (p[0, k] <= shaft.lower[k] and p[1, k] <= shaft.lower[k] and p[2, k] <= shaft.lower[k]) or (
            p[0, k] >= shaft.upper[k] and p[1, k] >= shaft.upper[k] and p[2, k] >= shaft.upper[k]
        ):
            return False
    return not is_beyond(
        shaft,
        corner(geometry.corners, face, 0),
        corner(geometry.corners, face, 1),
        corner(geometry.corners, face, 2),
    )


@kernel
def _put_unit(geometry, work, units, unit, target):  # type: ignore[no-untyped-def]
    """Record the faces of a unit but the target; returns their number.

    In a unit of several faces those are left out that cannot meet the present shaft: an edge between one
    that is left out and one that is not clears the shaft, as the former does.
    """
    first, last = units.offsets[unit], units.offsets[unit + 1]
    number = 0
    for k in range(first, last):
        face = units.faces[k]
        if face != target and (last - first == 1 or reaches(geometry, work.shaft, face)):
            put(work.record, face)
            number += 1
    return number


@kernel
def put_leaf(geometry, work, flood, target):  # type: ignore[no-untyped-def]
    """The occluder that the flood has just found proves the pair of parts at hand."""
    if len(work.record.words) == 0:
        return
    place = work.record.state[OPEN_WORDS]
    put(work.record, 0)
    number = 0
    for k in range(flood.used[0]):
        number += _put_unit(geometry, work, flood.units, flood.members[k], target)
    set_word(work.record, place, number)


@kernel
def _put_sheet(geometry, work, sheet, target):  # type: ignore[no-untyped-def]
    if len(work.record.words) == 0:
        return
    place = work.record.state[OPEN_WORDS]
    put(work.record, 0)
    set_word(work.record, place, _put_unit(geometry, work, work.sheets, sheet, target))


@kernel
def sheet_hides(geometry, work, region, inner, part, face):  # type: ignore[no-untyped-def]
    """Whether the rest of its sheet is proved to hide part (3, 3) of a face from part `inner` of a region.

    The shaft must be that of the pair; region and part of it are prisms (8, 3). The proof is recorded as a
    leaf.
    """
    side = work.inner[face]
    sheet = work.sheets.of_face[face]
    if side == 0 or work.shaft.counts[2] != side:
        return False
    memory = work.states, work.region
    if not sheet_keeps_off(geometry.corners, work.sheets, memory, sheet, region):
        return False
    if not border_clears(geometry.edge_ends, work.sheets, work.shaft, sheet):
        return False
    for _ in range(SEGMENTS):
        segment = (inner_point(work.random, inner), inner_point_of_face(work.random, part))
        if not find_crossed(geometry, segment[0], segment[1], face, work.crossed):
            continue
        number = crossings_of_sheet(work.sheets, work.crossed, sheet)
        if number >= 0:
            if number % 2 == 1:
                _put_sheet(geometry, work, sheet, face)
            return number % 2 == 1
    return False
