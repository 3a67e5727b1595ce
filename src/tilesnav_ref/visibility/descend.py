"""Top-down over the box hierarchy: whole nodes first, faces at the leaves."""

from __future__ import annotations

import numpy as np

from tilesnav_ref.kernels import kernel
from tilesnav_ref.visibility.certify import (
    HIDDEN,
    VISIBLE,
    back_is_hidden,
    box_is_hidden,
    decide_face,
    face_is_hidden,
)
from tilesnav_ref.visibility.record import begin, finish
from tilesnav_ref.visibility.sight import STACK

CREDIT = 16
"""Failures in a row after which targets are passed over."""
GAIN = 4
"""Failures that a success makes up for."""
PASS = 15
"""Targets passed over before the next is tried."""


@kernel
def bound_below(geometry, flags):  # type: ignore[no-untyped-def]
    """(B, 2, 3) box of the flagged faces below each node; inf to -inf where there are none."""
    boxes = np.empty((len(geometry.box_child), 2, 3))
    for node in range(len(boxes) - 1, -1, -1):
        boxes[node, 0], boxes[node, 1] = np.inf, -np.inf
        child = geometry.box_child[node]
        if child >= 0:
            for i in range(2):
                for k in range(3):
                    boxes[node, 0, k] = min(boxes[node, 0, k], boxes[child + i, 0, k])
                    boxes[node, 1, k] = max(boxes[node, 1, k], boxes[child + i, 1, k])
            continue
        for j in range(geometry.box_first[node], geometry.box_first[node] + geometry.box_count[node]):
            face = geometry.face_order[j]
            if flags[face]:
                for k in range(3):
                    boxes[node, 0, k] = min(boxes[node, 0, k], geometry.corners[face, :, k].min())
                    boxes[node, 1, k] = max(boxes[node, 1, k], geometry.corners[face, :, k].max())
    return boxes


@kernel
def _wanted_below(geometry, node, wanted):  # type: ignore[no-untyped-def]
    """The wanted faces below a node, ascending."""
    first = geometry.box_first[node]
    below = geometry.face_order[first : first + geometry.box_count[node]]
    return np.sort(below[wanted[below]])


@kernel
def worth_trying(credit):  # type: ignore[no-untyped-def]
    """Whether to try the next target of a row; after many failures only one of some is tried.

    `credit` is what is left of the failures that are allowed in a row or, below 0, minus the number of
    targets that are still to be passed over.
    """
    if credit[0] < 0:
        credit[0] += 1
        return False
    return True


@kernel
def account(credit, success):  # type: ignore[no-untyped-def]
    """Keep the credit of a row of targets after a try."""
    if success:
        credit[0] = min(credit[0] + GAIN, CREDIT)
    elif credit[0] > 0:
        credit[0] -= 1
    else:
        credit[0] = -PASS


@kernel
def cull(geometry, work, cell, proven, alive):  # type: ignore[no-untyped-def]
    """Clear `alive` (F,) for faces below nodes that are hidden from the region `cell` (8, 3).

    Nodes with a face of `proven` (F,) below are not tried, nor are most of those that follow upon many
    failures at the same depth: neighbours come one after the other.
    """
    wanted = alive & ~proven
    boxes = bound_below(geometry, wanted)
    credit = np.full((STACK, 1), CREDIT)
    stack = np.empty((STACK, 2), np.int32)
    stack[0, 0], stack[0, 1] = 0, 0
    top = 1
    while top > 0:
        top -= 1
        node, depth = stack[top]
        if boxes[node, 0, 0] > boxes[node, 1, 0]:
            continue
        if worth_trying(credit[depth]):
            below = _wanted_below(geometry, node, wanted)
            begin(work.record, below)
            hidden = box_is_hidden(geometry, work, cell, boxes[node])
            account(credit[depth], hidden)
            if hidden:
                finish(work.record)
                alive[below] = False
                continue
        if geometry.box_child[node] >= 0:
            for k in range(2):
                stack[top + k, 0], stack[top + k, 1] = geometry.box_child[node] + k, depth + 1
            top += 2


@kernel
def cull_backs(geometry, work, cell, proven, alive):  # type: ignore[no-untyped-def]
    """Clear `alive` (F,) for faces that their own sheets hide from the region `cell` (8, 3)."""
    for face in range(len(alive)):
        if alive[face] and not proven[face]:
            alive[face] = not back_is_hidden(geometry, work, cell, face)


@kernel
def cull_faces(geometry, work, cell, proven, alive):  # type: ignore[no-untyped-def]
    """Clear `alive` (F,) for faces that one attempt each proves hidden from the region `cell` (8, 3).

    Faces of `proven` (F,) are not tried, nor are most of those that follow upon many failures.
    """
    credit = np.full(1, CREDIT)
    for k in range(len(geometry.face_order)):
        face = geometry.face_order[k]
        if alive[face] and not proven[face] and worth_trying(credit):
            hidden = face_is_hidden(geometry, work, cell, face)
            account(credit, hidden)
            alive[face] = not hidden


@kernel
def decide(geometry, work, cell, found, budget):  # type: ignore[no-untyped-def]
    """Decide every face from a cell (8, 3).

    `found` is (proven, alive, reasons): `alive` (F,) is cleared for hidden faces, `proven` (F,) is set for
    visible ones, and what stays undecided is counted by the reason.
    """
    proven, alive, reasons = found
    cull_backs(geometry, work, cell, proven, alive)
    cull(geometry, work, cell, proven, alive)
    for k in range(len(geometry.face_order)):
        face = geometry.face_order[k]
        if proven[face] or not alive[face]:
            continue
        verdict = decide_face(geometry, work, cell, face, budget)
        if verdict == HIDDEN:
            alive[face] = False
        elif verdict == VISIBLE:
            proven[face] = True
        else:
            reasons[verdict] += 1
