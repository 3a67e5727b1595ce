"""Faces that enter, as a set: grown across the open edges of known faces, else begun anew.

References
----------
S. Gumhold, W. Strasser, Real time compression of triangle mesh connectivity, 1998 (growing across edges).
C. Touma, C. Gotsman, Triangle mesh compression, 1998 (the fourth corner of a parallelogram).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tilesnav_ref.kernels import plain_inner_kernel, plain_kernel
from tilesnav_ref.packet.coder import FAILED, NUMBER_CONTEXTS, READING, code_bit, code_number, code_signed
from tilesnav_ref.packet.geometry_memory import find_shape, put_shape
from tilesnav_ref.packet.geometry_mesh import (
    BEFORE_FROM,
    BEFORE_TO,
    EDGES,
    FROM,
    LATEST_FROM,
    LATEST_TO,
    LIMIT,
    NONE,
    THIRD,
    TO,
    VERTICES,
    find_vertex,
    opposite_edge,
    put_face,
    put_vertex,
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
TOP, SEEN, HELD, HEAD = range(4)
"""Words of a stack: edges that wait, held edges looked at and in all; the edges that wait begin."""
MEMORY, PARALLELOGRAM, LEFT, RIGHT = 1, 2, 4, 8
"""Reasons for a candidate."""


class Scratch(NamedTuple):
    """What is known while a face is coded."""

    candidates: Any
    """(CANDIDATES, 3) int64 places."""
    masks: Any
    """(CANDIDATES + 1,) int64 their reasons; how many there are."""
    references: Any
    """(3, 3) int64 places."""
    point: Any
    """(3,) int64 the place that is coded."""


def new_scratch() -> Scratch:
    """Return what a body begins with: the origin for references."""
    candidates = np.zeros((CANDIDATES, 3), np.int64)
    masks = np.zeros(CANDIDATES + 1, np.int64)
    return Scratch(candidates, masks, np.zeros((3, 3), np.int64), np.zeros(3, np.int64))


@plain_inner_kernel
def set_reference(scratch: Any, row: Any, mesh: Any, vertex: Any) -> Any:
    """Make the place of a vertex a reference."""
    for k in range(3):
        scratch.references[row, k] = mesh.vertices[vertex, k]


@plain_inner_kernel
def set_point(scratch: Any, mesh: Any, vertex: Any) -> Any:
    """Make the place of a vertex the one to be coded."""
    for k in range(3):
        scratch.point[k] = mesh.vertices[vertex, k]


@plain_kernel
def add_candidate(scratch: Any, place: Any, reason: Any) -> Any:
    """Note a candidate, or that a candidate has one more reason."""
    candidates, masks = scratch.candidates, scratch.masks
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


@plain_inner_kernel
def add_neighbours(mesh: Any, scratch: Any, edge: Any, opposite: Any) -> Any:
    """Note the other ends of open edges to `edge[0]` and from `edge[1]`, as long as few are looked at."""
    places, edges = mesh.vertices, mesh.edges
    for side in range(2):
        e = places[edge[side], LATEST_TO if side == 0 else LATEST_FROM]
        for _ in range(INSPECTED):
            if e == NONE:
                break
            w = edges[e, FROM if side == 0 else TO]
            if w != opposite and opposite_edge(mesh, e) == NONE:
                place = (np.int64(places[w, 0]), np.int64(places[w, 1]), np.int64(places[w, 2]))
                add_candidate(scratch, place, LEFT if side == 0 else RIGHT)
            e = edges[e, BEFORE_TO if side == 0 else BEFORE_FROM]


@plain_kernel
def find_candidates(mesh: Any, scratch: Any, edge: Any, opposite: Any, memory: Any, shape: Any) -> None:
    """Find candidates for the third vertex of the face behind an edge (a, b) whose known face has `opposite`.

    `opposite` is NONE where there is no known face, and `shape` where nothing is remembered about it.
    """
    places = mesh.vertices
    a, b = edge
    scratch.masks[CANDIDATES] = 0
    if opposite != NONE:
        x, y, z = np.int64(places[a, 0]), np.int64(places[a, 1]), np.int64(places[a, 2])
        if shape != NONE:
            s = memory.shapes
            add_candidate(scratch, (x + s[shape, 6], y + s[shape, 7], z + s[shape, 8]), MEMORY)
        x += np.int64(places[b, 0]) - places[opposite, 0]
        y += np.int64(places[b, 1]) - places[opposite, 1]
        z += np.int64(places[b, 2]) - places[opposite, 2]
        add_candidate(scratch, (x, y, z), PARALLELOGRAM)
    add_neighbours(mesh, scratch, edge, opposite)


@plain_inner_kernel
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


@plain_inner_kernel
def code_vertex(coder: Any, mesh: Any, scratch: Any, first: Any) -> Any:
    """Code a vertex: a known one by how many are newer, else a new one by its place; returns it."""
    references, point = scratch.references, scratch.point
    vertices = mesh.counts[VERTICES]
    if vertices:
        v = NONE
        if not coder[0][READING]:
            v = int(find_vertex(mesh, point[0], point[1], point[2])[1])
        if code_bit(coder, first, 1 if v != NONE else 0):
            v = vertices - 1 - code_number(coder, first + 1, vertices - 1 - v)
            if v < 0:
                coder[0][FAILED] = 1
                v = 0
            return v
    code_point(coder, first + 1 + NUMBER_CONTEXTS, references, point)
    return np.int64(put_vertex(mesh, point[0], point[1], point[2]))


@plain_kernel
def code_third(coder: Any, mesh: Any, scratch: Any) -> Any:
    """Code the third vertex of a face: one of the candidates, else any; returns it."""
    candidates, masks, point = scratch.candidates, scratch.masks, scratch.point
    for k in range(masks[CANDIDATES]):
        x, y, z = candidates[k, 0], candidates[k, 1], candidates[k, 2]
        same = point[0] == x and point[1] == y and point[2] == z
        if code_bit(coder, CHOICE + masks[k], 1 if same else 0):
            return np.int64(put_vertex(mesh, x, y, z))
    return code_vertex(coder, mesh, scratch, VERTEX + 2 * VERTEX_CONTEXTS)


@plain_kernel
def known_vertex(entering: Any, mesh: Any, vertex: Any) -> Any:
    """Vertex of one mesh at the place of a vertex of another, or NONE."""
    places = mesh.vertices
    return find_vertex(entering, places[vertex, 0], places[vertex, 1], places[vertex, 2])[1]


@plain_kernel
def waiting_edge(entering: Any, sent: Any, mesh: Any, edge: Any) -> Any:
    """Edge of a face that was not sent, opposite to an edge of the mesh; NONE if there is none."""
    u = known_vertex(entering, mesh, edge[0])
    v = known_vertex(entering, mesh, edge[1])
    if min(u, v) == NONE:
        return NONE
    e = entering.vertices[v, LATEST_FROM]
    while e != NONE:
        if entering.edges[e, TO] == u and not sent[e // 3]:
            return e
        e = entering.edges[e, BEFORE_FROM]
    return NONE


@plain_kernel
def first_edge(entering: Any, face: Any, mesh: Any) -> Any:
    """Edge of a face to begin with: one whose vertices are known, if there is one."""
    best, most = 3 * face, -1
    for e in range(3 * face, 3 * face + 3):
        score = 0
        if known_vertex(mesh, entering, entering.edges[e, FROM]) != NONE:
            score = 2 if known_vertex(mesh, entering, entering.edges[e, TO]) != NONE else 1
        if score > most:
            best, most = e, score
    return best


@plain_inner_kernel
def begin_anew(coder: Any, mesh: Any, memory: Any, scratch: Any, source: Any) -> Any:
    """Code a face that shares no edge with a known one; `source` is its mesh and its edge when writing."""
    entering, e = source
    references = scratch.references
    writing = not coder[0][READING]
    ends = (np.int64(0), np.int64(0))
    for k in range(2):
        if writing:
            set_point(scratch, entering, entering.edges[e, FROM if k == 0 else TO])
        v = code_vertex(coder, mesh, scratch, VERTEX + k * VERTEX_CONTEXTS)
        ends = (ends[1], v)
        for row in range(2, 0, -1):
            for axis in range(3):
                references[row, axis] = references[row - 1, axis]
        set_reference(scratch, 0, mesh, v)
    if writing:
        set_point(scratch, entering, entering.edges[e, THIRD])
    a, b = ends
    find_candidates(mesh, scratch, (b, a), NONE, memory, NONE)
    return a, b, code_third(coder, mesh, scratch)


@plain_inner_kernel
def grow(coder: Any, mesh: Any, memory: Any, scratch: Any, source: Any) -> Any:
    """Code whether there is a face behind an edge, and its third vertex.

    `source` is the mesh of faces that enter and which of them were sent, the edge, and whether it is of a
    held face. Returns 1 or 0, the third vertex, and the edge of the face in that mesh when writing.
    """
    entering, sent, gate, is_held = source
    edges = mesh.edges
    a, b, c = edges[gate, FROM], edges[gate, TO], edges[gate, THIRD]
    found = find_shape(memory, mesh, a, b, c)
    e = np.int64(NONE)
    if not coder[0][READING]:
        e = np.int64(waiting_edge(entering, sent, mesh, (a, b)))
    context = EXISTS + (2 if found[1] != NONE else 0) + (1 if is_held else 0)
    if not code_bit(coder, context, 1 if e != NONE else 0):
        return 0, np.int64(NONE), e
    # Few edges have a face, so candidates are not looked for before.
    find_candidates(mesh, scratch, (a, b), c, memory, found[1])
    set_reference(scratch, 0, mesh, a)
    set_reference(scratch, 1, mesh, b)
    set_reference(scratch, 2, mesh, c)
    if e != NONE:
        set_point(scratch, entering, entering.edges[e, THIRD])
    v = code_third(coder, mesh, scratch)
    put_shape(memory, mesh, (a, b, c), v, found)
    return 1, v, e


@plain_inner_kernel
def next_edge(mesh: Any, stack: Any) -> Any:
    """Take the next edge without a face behind it, or NONE: the newest one, else the first held one."""
    while stack[TOP] > 0:
        stack[TOP] -= 1
        gate = stack[HEAD + stack[TOP]]
        if opposite_edge(mesh, gate) == NONE:
            return gate
    while stack[SEEN] < stack[HELD]:
        gate = stack[SEEN]
        stack[SEEN] += 1
        if opposite_edge(mesh, gate) == NONE:
            return gate
    return np.int64(NONE)


@plain_inner_kernel
def put_coded(mesh: Any, scratch: Any, face: Any, corners: Any, i: Any) -> Any:
    """Put a face in; write its corners, which are references for one that begins anew."""
    a, b, v = face
    set_reference(scratch, 1, mesh, a)
    set_reference(scratch, 2, mesh, b)
    set_reference(scratch, 0, mesh, v)
    for axis in range(3):
        corners[i, 0, axis] = mesh.vertices[a, axis]
        corners[i, 1, axis] = mesh.vertices[b, axis]
        corners[i, 2, axis] = mesh.vertices[v, axis]
    put_face(mesh, a, b, v)


@plain_kernel
def code_faces(coder: Any, mesh: Any, memory: Any, scratch: Any, source: Any) -> Any:
    """Write or read faces, in the order of the stream.

    Parameters
    ----------
    coder, mesh, memory, scratch : tuples
        `mesh` holds the held faces of the object and has room for the others.
    source : tuple
        Mesh of the faces to be written, whose face k has edges 3k to 3k + 2 (empty when reading); corners
        (F, 3, 3) int32 and rows (F,) int64 in that mesh, to be filled for each face in the order coded;
        (F + 1,) bool, all False, and a stack (3F + 3,) int64, which begins with zeros, to work with.
    """
    entering, corners, rows, sent, stack = source
    writing = not coder[0][READING]
    total = len(corners)
    held = mesh.counts[EDGES]
    stack[HELD] = held
    done, start, e = 0, 0, np.int64(NONE)
    while done < total and not coder[0][FAILED]:
        gate = next_edge(mesh, stack)
        if gate != NONE:
            found, v, e = grow(coder, mesh, memory, scratch, (entering, sent, gate, gate < held))
            if not found:
                continue
            a, b = np.int64(mesh.edges[gate, TO]), np.int64(mesh.edges[gate, FROM])
        else:
            if writing:
                while sent[start]:
                    start += 1
                e = np.int64(first_edge(entering, start, mesh))
            a, b, v = begin_anew(coder, mesh, memory, scratch, (entering, e))
        for k in range(3):
            stack[stack[TOP] + HEAD + k] = mesh.counts[EDGES] + k
        stack[TOP] += 3
        put_coded(mesh, scratch, (a, b, v), corners, done)
        if writing:
            rows[done] = e // 3
            sent[e // 3] = True
        done += 1
