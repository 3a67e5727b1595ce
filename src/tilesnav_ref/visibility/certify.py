"""Deciding targets from a cell: hidden by proof, visible by proof, or undecided within a budget.

A target is a node of the box hierarchy (one attempt) or a face (attempts with division of cell and
face). Parts cover their whole in the sense of spec Annex C: occluders keep off the relative interior of the
whole face and the interior of the whole cell, so that segments through the cuts between parts are blocked
as well.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import inner_kernel, kernel
from tilesnav_ref.visibility.backs import put_leaf, sheet_hides
from tilesnav_ref.visibility.geometry import Geometry
from tilesnav_ref.visibility.limits import pair_is_out
from tilesnav_ref.visibility.occluder import PROVED, Flood, Obstacle, make_flood, prove_hidden, surface_of
from tilesnav_ref.visibility.prisms import LEAST_CUT, box_around, box_prism, edge_length, halve, plane_side
from tilesnav_ref.visibility.record import Record, begin, finish, make_record, put_cut
from tilesnav_ref.visibility.segments import extremes_see, inner_point, inner_point_of_face, search, trial
from tilesnav_ref.visibility.shaft import Shaft, make_shaft, set_shaft
from tilesnav_ref.visibility.sight import Crossed, corner, find_crossed, make_crossed, sees
from tilesnav_ref.visibility.units import Division, Units, is_fine

VISIBLE = -1
"""A segment was found that proves the face visible."""
HIDDEN = PROVED
OUT_OF_BUDGET = 6
OUT_OF_BITS = 7
"""Neither the cell part nor the face part can be halved exactly any more."""
NO_CUT = 0
REASONS = ("proved", "open-edge", "too-large", "even-parity", "contact", "degenerate", "budget", "resolution")

CROSSING_LIMIT = 24
"""Faces of one segment that are tried as the seed of an occluder, nearest to the smaller end of the shaft
first.

Trying three instead of all left 60 % more faces undecided and took twice the time (Munich street cells): what
is not hidden as a node is tried again face by face, and an undecided face costs its whole budget.
"""
TRIAL_SHARE = 8
"""After one such part of its budget a face is given up when, at the rate so far, the budget would not do."""


class Workspace(NamedTuple):
    """Working memory of one thread."""

    shaft: Shaft
    single: Flood
    """Floods over faces."""
    patches: Flood
    """Floods over patches."""
    crossed: Crossed
    """What a segment meets."""
    random: NDArray[np.int64]
    """(1,) state of the generator, 1 to segments.RANDOM_MODULUS - 1."""
    cells: NDArray[np.float64]
    """(depth, 8, 3) waiting cell parts."""
    parts: NDArray[np.float64]
    """(depth, 3, 3) waiting face parts."""
    levels: NDArray[np.int64]
    """(depth,) number of cuts above each waiting pair."""
    record: Record
    """Proofs that were found."""
    with_patches: bool
    """Whether floods over patches are tried, before those over faces."""
    sheets: Units
    inner: NDArray[np.int8]
    """(F,) see Division."""
    states: NDArray[np.int8]
    """(S,) what is known of each sheet and the region below (backs.py)."""
    region: NDArray[np.float64]
    """(8, 3)."""


class Budget(NamedTuple):
    """Limits of the work on one face."""

    attempts: int
    """Pairs of parts tried."""
    depth: int
    """Cuts above a pair."""
    leaf_segments: int
    """Random segments tried in a pair that could not be decided, in search of a visible one, after its
    extreme ones."""


def make_workspace(
    scene: tuple[Geometry, Division], occluder_limit: int, depth: int, record: int = 0
) -> Workspace:
    """Working memory for one thread; `record` is the number of words for proofs, 0 for none."""
    geometry, division = scene
    size = depth + 2
    return Workspace(
        make_shaft(),
        make_flood(geometry, division.single, occluder_limit),
        make_flood(geometry, division.patches, occluder_limit),
        make_crossed(CROSSING_LIMIT),
        np.ones(1, np.int64),
        np.zeros((size, 8, 3)),
        np.zeros((size, 3, 3)),
        np.zeros(size, np.int64),
        make_record(record),
        is_fine(division),
        division.sheets,
        division.inner,
        np.zeros(len(division.sheets.offsets) - 1, np.int8),
        np.zeros((8, 3)),
    )


def forget(work: Workspace) -> None:
    """Forget which units proofs grew from, so that results depend on nothing but the block at hand."""
    work.single.success[:] = 0
    work.patches.success[:] = 0


@kernel
def middle(box):  # type: ignore[no-untyped-def]
    """The middle of a box, rounded down to integers."""
    return (
        np.floor((box[0, 0] + box[1, 0]) / 2),
        np.floor((box[0, 1] + box[1, 1]) / 2),
        np.floor((box[0, 2] + box[1, 2]) / 2),
    )


@kernel
def _attempt(geometry, work, obstacle, segment, how):  # type: ignore[no-untyped-def]
    """Try occluders through the faces that a segment of the present shaft crosses; recorded if one proves.

    `how` is (whether to begin with the face nearest to the cell, whether the flood stops at silhouettes). A
    stop fails early, which is best for the many nodes that cannot fall; without it more faces fall.
    """
    near_cell, stop_at_silhouettes = how
    if not find_crossed(geometry, segment[0], segment[1], obstacle.face, work.crossed):
        return False
    how = (segment[0], stop_at_silhouettes)
    for k in range(0 if work.with_patches else 1, 2):
        flood = work.patches if k == 0 else work.single
        if _grows(surface_of(geometry), flood, (work.shaft, work.crossed), obstacle, (near_cell, how)):
            put_leaf(geometry, work, flood, obstacle.face)
            return True
    return False


@inner_kernel
def _grows(surface, flood, work, obstacle, order):  # type: ignore[no-untyped-def]
    """Whether a flood from one of the nearest faces proves; `work` is (shaft, what the segment meets)."""
    near_cell, how = order
    nearest = work[1].nearest[: work[1].counts[0]]
    seeds = nearest if near_cell else nearest[::-1]
    number = len(seeds)
    best = _most_recent(flood.units, seeds, flood.success)
    flood.stamps[1] += 1
    for i in range(-1, number):
        if i == best or (i < 0 and best < 0):
            continue
        seed = seeds[best if i < 0 else i]
        if flood.failed[flood.units.of_face[seed]] == flood.stamps[1]:
            continue
        if prove_hidden(surface, flood, work, obstacle, seed, how) == PROVED:
            flood.success[-1] += 1
            flood.success[flood.units.of_face[seed]] = flood.success[-1]
            return True
    return False


@inner_kernel
def _most_recent(units, seeds, success):  # type: ignore[no-untyped-def]
    """Position of the seed from which the latest proof grew, -1 when none has grown from any of them.

    What hides one target hides its neighbours, and those are treated one after the other.
    """
    best, latest = -1, 0
    for i in range(len(seeds)):
        if success[units.of_face[seeds[i]]] > latest:
            best, latest = i, success[units.of_face[seeds[i]]]
    return best


@kernel
def make_obstacle(work, cell, face, box):  # type: ignore[no-untyped-def]
    """What an occluder must keep off: a region (8, 3) and a face in a box (2, 3), or the box where `face` is
    -1."""
    work.single.stamps[2] += 1
    work.patches.stamps[2] += 1
    return Obstacle(cell, box_around(cell), face, box)


@kernel
def box_is_hidden(geometry, work, cell, box):  # type: ignore[no-untyped-def]
    """Whether one attempt proves that no segment from the open cell (8, 3) reaches the closed box (2, 3)."""
    bounds = box_around(cell)
    apart = False
    for k in range(3):
        apart = apart or box[1, k] < bounds[0, k] or box[0, k] > bounds[1, k]
    if not apart:
        return False
    set_shaft(work.shaft, cell, box_prism(box), 8)
    segment = (inner_point(work.random, cell), middle(box))
    obstacle = make_obstacle(work, cell, -1, box)
    return _attempt(geometry, work, obstacle, segment, (_size(cell) < _size(box), True))


@inner_kernel
def _size(points):  # type: ignore[no-untyped-def]
    largest = 0.0
    for k in range(3):
        largest = max(largest, points[:, k].max() - points[:, k].min())
    return largest


@kernel
def face_is_hidden(geometry, work, cell, face):  # type: ignore[no-untyped-def]
    """Whether one attempt proves that a face is hidden from a cell (8, 3); recorded if so."""
    part = geometry.corners[face]
    set_shaft(work.shaft, cell, part, 3)
    segment = (inner_point(work.random, cell), inner_point_of_face(work.random, part))
    obstacle = make_obstacle(work, cell, face, box_around(geometry.corners[face]))
    begin(work.record, np.array([face]))
    if not _attempt(geometry, work, obstacle, segment, (_size(cell) < _size(part), False)):
        return False
    finish(work.record)
    return True


@kernel
def _side_of_face(geometry, face, cell):  # type: ignore[no-untyped-def]
    corners = geometry.corners
    return plane_side(corner(corners, face, 0), corner(corners, face, 1), corner(corners, face, 2), cell)


@kernel
def back_is_hidden(geometry, work, cell, face):  # type: ignore[no-untyped-def]
    """Whether the sheet of a face hides it from a region (8, 3); recorded if so."""
    part = geometry.corners[face]
    side = work.inner[face]
    if side == 0 or _side_of_face(geometry, face, cell) != side:
        return False
    set_shaft(work.shaft, cell, part, 3)
    begin(work.record, np.array([face]))
    if not sheet_hides(geometry, work, cell, cell, part, face):
        return False
    finish(work.record)
    return True


@kernel
def decide_face(geometry, work, cell, face, budget):  # type: ignore[no-untyped-def]
    """HIDDEN, VISIBLE, or the reason why a face could not be decided from a cell (8, 3)."""
    verdict, inner, part = _explore(geometry, work, cell, face, budget)
    what = (face, budget.leaf_segments)
    if verdict >= OUT_OF_BUDGET and search(geometry, work.random, (inner, part), what):
        return VISIBLE
    return verdict


@kernel
def _explore(geometry, work, cell, face, budget):  # type: ignore[no-untyped-def]
    """Divide cell and face until every pair of parts is proved; returns the verdict and the last pair."""
    obstacle = make_obstacle(work, cell, face, box_around(geometry.corners[face]))
    begin(work.record, np.array([face]))
    work.cells[0] = cell
    work.parts[0] = geometry.corners[face]
    work.levels[0] = 0
    top = 1
    inner, part = work.cells[0].copy(), work.parts[0].copy()
    done = 0.0  # share of all pairs (c, t) that is proved, as far as halves are halves
    for tried in range(budget.attempts):
        if tried * TRIAL_SHARE >= budget.attempts and done * budget.attempts < tried:
            break
        top -= 1
        inner, part, level = work.cells[top].copy(), work.parts[top].copy(), work.levels[top]
        if pair_is_out(geometry, inner, part, face):
            if top == 0:
                return HIDDEN, inner, part
            done += 0.5**level
            continue
        segment = trial(geometry, work.random, inner, part)
        if sees(geometry, segment[0], segment[1], face):
            return VISIBLE, inner, part
        set_shaft(work.shaft, inner, part, 3)
        how = (_size(inner) < _size(part), False)
        if sheet_hides(geometry, work, cell, inner, part, face) or _attempt(
            geometry, work, obstacle, segment, how
        ):
            if top == 0:
                finish(work.record)
                return HIDDEN, inner, part
            done += 0.5**level
            continue
        if tried == 0 and extremes_see(geometry, inner, part, face):
            return VISIBLE, inner, part
        if level == budget.depth:
            break
        code = _push_halves(work, inner, part, top)
        if code == NO_CUT:
            return OUT_OF_BITS, inner, part
        put_cut(work.record, code)
        work.levels[top] = work.levels[top + 1] = level + 1
        top += 2
    return OUT_OF_BUDGET, inner, part


@kernel
def _push_halves(work, inner, part, top):  # type: ignore[no-untyped-def]
    """Push the two halves of a pair, cut in its larger side; returns the code of the cut.

    It is 1 + the axis of a cut of the cell part, 4 + the edge of a cut of the face part, or NO_CUT when
    neither can be cut exactly (spec, "Certificates"). The half that is pushed last comes first in the record:
    the one above the cut, or with the first end of the edge.
    """
    if _size(part) > _size(inner):
        code = _cut_part(work, inner, part, top)
        return code if code != NO_CUT else _cut_cell(work, inner, part, top)
    code = _cut_cell(work, inner, part, top)
    return code if code != NO_CUT else _cut_part(work, inner, part, top)


@kernel
def _cut_cell(work, inner, part, top):  # type: ignore[no-untyped-def]
    """Halve a cell part across the axis along which it is longest, if it can be, or else across another."""
    lengths = np.empty(3)
    for k in range(3):
        lengths[k] = edge_length(inner, k)
    for _ in range(3):
        axis = np.argmax(lengths)
        if lengths[axis] < LEAST_CUT:
            return NO_CUT
        if halve(inner, axis, work.cells[top], work.cells[top + 1]):
            work.parts[top] = work.parts[top + 1] = part
            return 1 + axis
        lengths[axis] = 0.0
    return NO_CUT


@kernel
def _cut_part(work, inner, part, top):  # type: ignore[no-untyped-def]
    """Halve the longest edge; both halves must keep coordinates that are multiples of 4."""
    best, edge = -1.0, 0
    for k in range(3):
        length = 0.0
        for j in range(3):
            length += (part[(k + 1) % 3, j] - part[k, j]) ** 2
        if length > best:
            best, edge = length, k
    other = (edge + 1) % 3
    for j in range(3):
        if np.int64(part[edge, j] + part[other, j]) % 8 != 0:
            return NO_CUT
    for i in range(2):
        work.cells[top + i] = inner
        work.parts[top + i] = part
    for j in range(3):
        half = (part[edge, j] + part[other, j]) / 2
        work.parts[top, edge, j] = half
        work.parts[top + 1, other, j] = half
    return 4 + edge
