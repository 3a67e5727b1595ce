"""Faces that enter, as a set: grown across the open edges of known faces, else begun anew.

References
----------
S. Gumhold, W. Strasser, Real time compression of triangle mesh connectivity, 1998 (growing across edges).
C. Touma, C. Gotsman, Triangle mesh compression, 1998 (the fourth corner of a parallelogram).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tilesnav_ref.kernels import kernel
from tilesnav_ref.packet.coder import FAILED, NUMBER_CONTEXTS, READING, code_bit, code_number, code_signed
from tilesnav_ref.packet.geometry_mesh import (
    EDGES,
    LIMIT,
    NONE,
    VERTICES,
    find_edge,
    find_vertex,
    put_face,
    put_vertex,
    recall,
    remember,
)
from tilesnav_ref.packet.numbers import LEAVES_CONTEXTS, PLACES_CONTEXTS

EXISTS = 6 * NUMBER_CONTEXTS + LEAVES_CONTEXTS + PLACES_CONTEXTS
"""First context of whether a face is at an edge: 2 x 2."""
CHOICE = EXISTS + 4
"""First context of whether a candidate is the third vertex: 16 masks."""
POINT_CONTEXTS = 36 + 3 * (NUMBER_CONTEXTS + 1)
"""For a place: 3 axes x 4 x 3 of what it equals, 3 axes of differences."""
VERTEX_CONTEXTS = 1 + NUMBER_CONTEXTS + POINT_CONTEXTS
"""For a vertex: known or not, its number, its place."""
VERTEX = CHOICE + 16
"""First context of the first, the second and the third vertex of a face."""
CONTEXTS = VERTEX + 3 * VERTEX_CONTEXTS
CANDIDATES = 4
"""Candidates for a third vertex at most."""
INSPECTED = 8
"""Edges at a vertex that are looked at for candidates, latest first."""
MEMORY, PARALLELOGRAM, LEFT, RIGHT = 1, 2, 4, 8
"""Reasons for a candidate."""


def new_scratch() -> Any:
    """Places of candidates, their reasons, how many; places of references; the place that is coded."""
    candidates = np.zeros((CANDIDATES, 3), np.int64)
    masks = np.zeros(CANDIDATES + 1, np.int64)
    return candidates, masks, np.zeros((3, 3), np.int64), np.zeros(3, np.int64)


@kernel
def copy_place(target: Any, source: Any) -> Any:
    """Copy three coordinates."""
    target[0] = source[0]
    target[1] = source[1]
    target[2] = source[2]


@kernel
def add_candidate(scratch: Any, place: Any, reason: Any) -> Any:
    """Note a candidate, or that a candidate has one more reason."""
    candidates, masks = scratch[0], scratch[1]
    x, y, z = place
    count = masks[CANDIDATES]
    for k in range(count):
        if candidates[k, 0] == x and candidates[k, 1] == y and candidates[k, 2] == z:
            masks[k] |= reason
            return
    if count == CANDIDATES or max(abs(x), abs(y), abs(z)) >= LIMIT:
        return
    candidates[count, 0] = x
    candidates[count, 1] = y
    candidates[count, 2] = z
    masks[count] = reason
    masks[CANDIDATES] = count + 1


@kernel
def add_neighbours(mesh: Any, scratch: Any, edge: Any, opposite: Any) -> Any:
    """Note the other ends of open edges to `edge[0]` and from `edge[1]`, as long as few are looked at."""
    places, edges = mesh[1], mesh[3]
    for side in range(2):
        vertex = edge[side]
        e = mesh[5][vertex, 1 - side]
        for _ in range(INSPECTED):
            if e == NONE:
                break
            w = edges[e, side]
            reverse = find_edge(mesh, vertex, w)[1] if side == 0 else find_edge(mesh, w, vertex)[1]
            if w != opposite and reverse == NONE:
                place = (places[w, 0], places[w, 1], places[w, 2])
                add_candidate(scratch, place, LEFT if side == 0 else RIGHT)
            e = mesh[6][e, 1 - side]


@kernel
def find_candidates(mesh: Any, memory: Any, scratch: Any, edge: Any, opposite: Any) -> None:
    """Find candidates for the third vertex of the face behind an edge (a, b) whose known face has `opposite`.

    `opposite` is NONE where there is no known face.
    """
    places = mesh[1]
    a, b = edge
    masks = scratch[1]
    masks[CANDIDATES] = 0
    if opposite != NONE:
        n = recall(memory, mesh, a, b, opposite)[1]
        if n != NONE:
            x, y, z = memory[2][n, 0], memory[2][n, 1], memory[2][n, 2]
            add_candidate(scratch, (places[a, 0] + x, places[a, 1] + y, places[a, 2] + z), MEMORY)
        x = places[a, 0] + places[b, 0] - places[opposite, 0]
        y = places[a, 1] + places[b, 1] - places[opposite, 1]
        z = places[a, 2] + places[b, 2] - places[opposite, 2]
        add_candidate(scratch, (x, y, z), PARALLELOGRAM)
    add_neighbours(mesh, scratch, edge, opposite)


@kernel
def code_point(coder: Any, first: Any, references: Any, point: Any) -> Any:
    """Code a place axis by axis: equal to one of three references, or by the difference from the first."""
    last = 0
    for axis in range(3):
        source = 0
        for k in range(3):
            value = references[k, axis]
            repeated = False
            for j in range(k):
                repeated |= references[j, axis] == value
            context = first + (axis * 4 + last) * 3 + k
            if not repeated and code_bit(coder, context, 1 if point[axis] == value else 0):
                point[axis] = value
                source = k + 1
                break
        if source == 0:
            base = references[0, axis]
            context = first + 36 + axis * (NUMBER_CONTEXTS + 1)
            point[axis] = base + code_signed(coder, context, point[axis] - base)
            if abs(point[axis]) >= LIMIT:
                coder[0][FAILED] = 1
                point[axis] = 0
        last = source


@kernel
def code_vertex(coder: Any, mesh: Any, scratch: Any, first: Any) -> Any:
    """Code a vertex: a known one by how many are newer, else a new one by its place; returns it."""
    references, point = scratch[2], scratch[3]
    vertices = mesh[0][VERTICES]
    if vertices:
        v = find_vertex(mesh, point[0], point[1], point[2])[1]
        if code_bit(coder, first, 1 if v != NONE else 0):
            v = vertices - 1 - code_number(coder, first + 1, vertices - 1 - v)
            if v < 0:
                coder[0][FAILED] = 1
                v = 0
            return v
    code_point(coder, first + 1 + NUMBER_CONTEXTS, references, point)
    return put_vertex(mesh, point[0], point[1], point[2])


@kernel
def code_third(coder: Any, mesh: Any, scratch: Any) -> Any:
    """Code the third vertex of a face: one of the candidates, else any; returns it."""
    candidates, masks, _references, point = scratch
    for k in range(masks[CANDIDATES]):
        same = point[0] == candidates[k, 0] and point[1] == candidates[k, 1] and point[2] == candidates[k, 2]
        if code_bit(coder, CHOICE + masks[k], 1 if same else 0):
            return put_vertex(mesh, candidates[k, 0], candidates[k, 1], candidates[k, 2])
    return code_vertex(coder, mesh, scratch, VERTEX + 2 * VERTEX_CONTEXTS)


@kernel
def waiting_edge(entering: Any, sent: Any, mesh: Any, edge: Any) -> Any:
    """Edge of a face that was not sent, opposite to an edge of the mesh; NONE if there is none."""
    a, b = edge
    places = mesh[1]
    u = find_vertex(entering, places[a, 0], places[a, 1], places[a, 2])[1]
    v = find_vertex(entering, places[b, 0], places[b, 1], places[b, 2])[1]
    if NONE in (u, v):
        return NONE
    e = entering[5][v, 0]
    while e != NONE:
        if entering[3][e, 1] == u and not sent[e // 3]:
            return e
        e = entering[6][e, 0]
    return NONE


@kernel
def first_edge(entering: Any, face: Any, mesh: Any) -> Any:
    """Edge of a face to begin with: one whose vertices are known, if there is one."""
    best, most = 3 * face, -1
    for e in range(3 * face, 3 * face + 3):
        p, q = entering[3][e, 0], entering[3][e, 1]
        score = 0
        if find_vertex(mesh, entering[1][p, 0], entering[1][p, 1], entering[1][p, 2])[1] != NONE:
            score = (
                2
                if find_vertex(mesh, entering[1][q, 0], entering[1][q, 1], entering[1][q, 2])[1] != NONE
                else 1
            )
        if score > most:
            best, most = e, score
    return best


@kernel
def begin_anew(coder: Any, mesh: Any, memory: Any, scratch: Any, source: Any) -> Any:
    """Code a face that shares no edge with a known one; `source` is its mesh and its edge when writing."""
    entering, e = source
    references, point = scratch[2], scratch[3]
    writing = not coder[0][READING]
    if writing:
        copy_place(point, entering[1][entering[3][e, 0]])
    a = code_vertex(coder, mesh, scratch, VERTEX)
    copy_place(references[2], references[1])
    copy_place(references[1], references[0])
    copy_place(references[0], mesh[1][a])
    if writing:
        copy_place(point, entering[1][entering[3][e, 1]])
    b = code_vertex(coder, mesh, scratch, VERTEX + VERTEX_CONTEXTS)
    copy_place(references[2], references[1])
    copy_place(references[1], references[0])
    copy_place(references[0], mesh[1][b])
    if writing:
        copy_place(point, entering[1][entering[3][e, 2]])
    find_candidates(mesh, memory, scratch, (b, a), NONE)
    return a, b, code_third(coder, mesh, scratch)


@kernel
def code_gate(coder: Any, mesh: Any, memory: Any, scratch: Any, source: Any) -> Any:
    """Code whether there is a face behind an edge (a, b) of a known face (a, b, c).

    Returns 1 or 0, and the edge of that face when writing.
    """
    entering, sent, a, b, c, is_held = source
    known = 1 if recall(memory, mesh, a, b, c)[1] != NONE else 0
    e = NONE
    if not coder[0][READING]:
        e = waiting_edge(entering, sent, mesh, (a, b))
    found = code_bit(coder, EXISTS + 2 * known + (1 if is_held else 0), 1 if e != NONE else 0)
    if found:  # few edges have a face, so candidates are not looked for before
        find_candidates(mesh, memory, scratch, (a, b), c)
    return found, e


@kernel
def grow(coder: Any, mesh: Any, memory: Any, scratch: Any, source: Any) -> Any:
    """Code the face behind an edge (a, b) of a known face, whose candidates were found."""
    entering, e, a, b, c = source
    references, point = scratch[2], scratch[3]
    copy_place(references[0], mesh[1][a])
    copy_place(references[1], mesh[1][b])
    copy_place(references[2], mesh[1][c])
    if e != NONE:
        copy_place(point, entering[1][entering[3][e, 2]])
    v = code_third(coder, mesh, scratch)
    remember(memory, mesh, (a, b, c), v)
    return v


@kernel
def code_faces(coder: Any, mesh: Any, memory: Any, scratch: Any, source: Any) -> Any:
    """Write or read faces, in the order of the stream.

    Parameters
    ----------
    coder, mesh, memory, scratch : tuples
        `mesh` holds the held faces of the object and has room for the others.
    source : tuple
        Mesh of the faces to be written, whose face k has edges 3k to 3k + 2 (empty when reading); corners
        (F, 3, 3) int64 and numbers (F,) int64 in that mesh, to be filled for each face in the order coded.
    """
    entering, corners, numbers = source
    writing = not coder[0][READING]
    total = len(corners)
    sent = np.zeros(total + 1, np.bool_)
    stack = np.zeros(len(mesh[3]) + 1, np.int64)
    top = mesh[0][EDGES]
    held = top
    for i in range(held):
        stack[i] = held - 1 - i
    done, start, e = 0, 0, NONE
    while done < total and not coder[0][FAILED]:
        if top:
            top -= 1
            gate = stack[top]
            a, b, c = mesh[3][gate, 0], mesh[3][gate, 1], mesh[3][gate, 2]
            if find_edge(mesh, b, a)[1] != NONE:
                continue
            found, e = code_gate(coder, mesh, memory, scratch, (entering, sent, a, b, c, gate < held))
            if not found:
                continue
            v = grow(coder, mesh, memory, scratch, (entering, e, a, b, c))
            a, b = b, a
        else:
            if writing:
                while sent[start]:
                    start += 1
                e = first_edge(entering, start, mesh)
            a, b, v = begin_anew(coder, mesh, memory, scratch, (entering, e))
        for k in range(3):
            copy_place(corners[done, k], mesh[1][(a, b, v)[k]])
            copy_place(scratch[2][(k + 1) % 3], corners[done, k])
            stack[top + k] = mesh[0][EDGES] + k
        top += 3
        put_face(mesh, (a, b, v))
        if writing:
            numbers[done] = e // 3
            sent[e // 3] = True
        done += 1
