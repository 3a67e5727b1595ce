"""Top-down over the box hierarchy: whole nodes first, faces at the leaves."""

from __future__ import annotations

import numpy as np

from tilesnav_ref.kernels import kernel
from tilesnav_ref.visibility.certify import (
    HIDDEN,
    VISIBLE,
    box_is_hidden,
    decide_face,
    face_is_hidden,
)
from tilesnav_ref.visibility.record import begin, finish, put_leaf
from tilesnav_ref.visibility.sight import STACK


@kernel
def count_below(geometry, flags):  # type: ignore[no-untyped-def]
    """(B,) number of flagged faces below each node of the hierarchy."""
    count = np.zeros(len(geometry.box_child), np.int32)
    for node in range(len(count) - 1, -1, -1):
        child = geometry.box_child[node]
        if child >= 0:
            count[node] = count[child] + count[child + 1]
            continue
        for k in range(geometry.box_first[node], geometry.box_first[node] + geometry.box_count[node]):
            count[node] += flags[geometry.face_order[k]]
    return count


@kernel
def _hide_below(geometry, node, alive):  # type: ignore[no-untyped-def]
    for k in range(geometry.box_first[node], geometry.box_first[node] + geometry.box_count[node]):
        alive[geometry.face_order[k]] = False


@kernel
def _node_is_hidden(geometry, work, cell, node):  # type: ignore[no-untyped-def]
    box = np.empty((2, 3))
    for k in range(3):
        box[0, k] = geometry.box_lower[node, k]
        box[1, k] = geometry.box_upper[node, k]
    if not box_is_hidden(geometry, work, cell, box):
        return False
    first = geometry.box_first[node]
    begin(work.record, np.sort(geometry.face_order[first : first + geometry.box_count[node]]))
    put_leaf(work.record, work.flood)
    finish(work.record)
    return True


@kernel
def cull(geometry, work, cell, proven, alive):  # type: ignore[no-untyped-def]
    """Clear `alive` (F,) for faces below nodes that are hidden from the box `cell` (2, 3).

    Nodes with a face of `proven` (F,) below are not tried.
    """
    visible = count_below(geometry, proven)
    waiting = count_below(geometry, alive)
    stack = np.empty(STACK, np.int32)
    stack[0] = 0
    top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if waiting[node] == 0:
            continue
        if visible[node] == 0 and _node_is_hidden(geometry, work, cell, node):
            _hide_below(geometry, node, alive)
        elif geometry.box_child[node] >= 0:
            stack[top] = geometry.box_child[node]
            stack[top + 1] = geometry.box_child[node] + 1
            top += 2


@kernel
def cull_faces(geometry, work, cell, proven, alive):  # type: ignore[no-untyped-def]
    """Clear `alive` (F,) for faces that one attempt each proves hidden from the box `cell` (2, 3).

    Faces of `proven` (F,) are not tried.
    """
    for k in range(len(geometry.face_order)):
        face = geometry.face_order[k]
        if alive[face] and not proven[face] and face_is_hidden(geometry, work, cell, face):
            alive[face] = False


@kernel
def decide(geometry, work, cell, found, budget):  # type: ignore[no-untyped-def]
    """Decide every face from a cell (2, 3).

    `found` is (proven, alive, reasons): `alive` (F,) is cleared for hidden faces, `proven` (F,) is set for
    visible ones, and what stays undecided is counted by the reason.
    """
    proven, alive, reasons = found
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
