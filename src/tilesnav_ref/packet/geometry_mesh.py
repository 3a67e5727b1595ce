"""Faces of an object as both sides know them: vertices by place, and directed edges in pairs.

Hash tables with linear probing; what they find is what was put in, never what merely looks like it. All that
belongs to a vertex or to an edge lies in one row, since what takes time is to fetch it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tilesnav_ref.kernels import plain_inner_kernel, plain_kernel

NONE = -1
LIMIT = 1 << 23
"""Coordinates are smaller in magnitude."""
VERTICES, EDGES, MASK = range(3)
"""Counts of a mesh; slots of its hash tables less one."""
LATEST_FROM, LATEST_TO = 3, 4
"""Of a vertex, behind its place: latest edge from it and to it."""
FROM, TO, THIRD, PAIR, ALONG, AGAINST, BEFORE_FROM, BEFORE_TO = range(8)
"""Of an edge: its vertices, the third one of its face; the first edge between the same two vertices, which
has the latest one from the lesser to the greater and the other way round; the edges from and to the same
vertex before it."""


class Mesh(NamedTuple):
    """Arrays with room for the faces of one object after the other."""

    counts: Any
    """(3,) int64."""
    vertices: Any
    """(V, 5) int32: place, LATEST_FROM, LATEST_TO."""
    vertex_table: Any
    """(S,) int32 vertex in each slot or NONE."""
    edges: Any
    """(E, 8) int32; face f has the edges 3f to 3f + 2."""
    edge_table: Any
    """(S,) int32 first edge of a pair in each slot or NONE."""


def new_mesh(faces: int) -> Mesh:
    """Return a mesh with room for a number of faces; `clear_mesh` makes it ready."""
    room = 3 * faces
    slots = slot_count(room)
    return Mesh(
        np.zeros(3, np.int64),
        np.empty((room, 5), np.int32),
        np.empty(slots, np.int32),
        np.empty((room, 8), np.int32),
        np.empty(slots, np.int32),
    )


@plain_kernel
def slot_count(room: Any) -> Any:
    """Slots of a table that is filled by two thirds at most: a power of two."""
    slots = 4
    while 2 * slots < 3 * room:
        slots *= 2
    return slots


@plain_kernel
def clear_mesh(mesh: Any, faces: Any) -> Any:
    """Empty a mesh, for an object with no more than so many faces."""
    slots = slot_count(3 * faces)
    mesh.counts[VERTICES] = 0
    mesh.counts[EDGES] = 0
    mesh.counts[MASK] = slots - 1
    mesh.vertex_table[:slots] = NONE
    mesh.edge_table[:slots] = NONE


@plain_inner_kernel
def mix(sum_of_products: Any) -> Any:
    """Hash of a sum of products that is below 2^62 in magnitude; no product leaves 63 bits."""
    low = (1 << 30) - 1
    h = sum_of_products ^ (sum_of_products >> 29)
    h = (h & low) * 0x6C1B3C6D
    return h ^ (h >> 23)


@plain_inner_kernel
def find_vertex(mesh: Any, x: Any, y: Any, z: Any) -> Any:
    """Slot of a place, and its vertex or NONE."""
    vertices, table, mask = mesh.vertices, mesh.vertex_table, mesh.counts[MASK]
    slot = mix(np.int64(x) * 0x5E3779B1 + np.int64(y) * 0x45EBCA77 + np.int64(z) * 0x42B2AE3D) & mask
    v = table[slot]
    while v != NONE:
        if vertices[v, 0] == x and vertices[v, 1] == y and vertices[v, 2] == z:
            break
        slot = (slot + 1) & mask
        v = table[slot]
    return slot, v


@plain_inner_kernel
def put_vertex(mesh: Any, x: Any, y: Any, z: Any) -> Any:
    """Vertex at a place, new where there was none."""
    slot, v = find_vertex(mesh, x, y, z)
    if v == NONE:
        v = mesh.counts[VERTICES]
        mesh.counts[VERTICES] = v + 1
        mesh.vertices[v, 0] = x
        mesh.vertices[v, 1] = y
        mesh.vertices[v, 2] = z
        mesh.vertices[v, LATEST_FROM] = NONE
        mesh.vertices[v, LATEST_TO] = NONE
        mesh.vertex_table[slot] = v
    return v


@plain_inner_kernel
def find_pair(mesh: Any, a: Any, b: Any) -> Any:
    """Slot of the edges between two vertices, and the first of them or NONE."""
    edges, table, mask = mesh.edges, mesh.edge_table, mesh.counts[MASK]
    slot = mix(np.int64(min(a, b)) * 0x5E3779B1 + np.int64(max(a, b)) * 0x45EBCA77) & mask
    e = table[slot]
    while e != NONE:
        p, q = edges[e, FROM], edges[e, TO]
        if (p == a and q == b) or (p == b and q == a):
            break
        slot = (slot + 1) & mask
        e = table[slot]
    return slot, e


@plain_inner_kernel
def opposite_edge(mesh: Any, e: Any) -> Any:
    """Latest edge from the end of an edge to its beginning, or NONE."""
    edges = mesh.edges
    return edges[edges[e, PAIR], AGAINST if edges[e, TO] > edges[e, FROM] else ALONG]


@plain_inner_kernel
def put_edge(mesh: Any, a: Any, b: Any, c: Any) -> Any:
    """Put the next edge in, which is the latest one from a to b."""
    edges, vertices = mesh.edges, mesh.vertices
    e = mesh.counts[EDGES]
    mesh.counts[EDGES] = e + 1
    edges[e, FROM] = a
    edges[e, TO] = b
    edges[e, THIRD] = c
    slot, found = find_pair(mesh, a, b)
    pair = e if found == NONE else np.int64(found)
    if found == NONE:
        mesh.edge_table[slot] = e
        edges[e, ALONG] = NONE
        edges[e, AGAINST] = NONE
    edges[e, PAIR] = pair
    edges[pair, AGAINST if a > b else ALONG] = e
    edges[e, BEFORE_FROM] = vertices[a, LATEST_FROM]
    vertices[a, LATEST_FROM] = e
    edges[e, BEFORE_TO] = vertices[b, LATEST_TO]
    vertices[b, LATEST_TO] = e


@plain_kernel
def put_face(mesh: Any, a: Any, b: Any, c: Any) -> Any:
    """Put a face in by its vertices."""
    put_edge(mesh, a, b, c)
    put_edge(mesh, b, c, a)
    put_edge(mesh, c, a, b)


@plain_kernel
def put_corners(mesh: Any, corners: Any, room: Any) -> Any:
    """Empty a mesh, make it ready for `room` faces, and put (F, 3, 3) faces in by their corners."""
    clear_mesh(mesh, room)
    for i in range(len(corners)):
        a = put_vertex(mesh, corners[i, 0, 0], corners[i, 0, 1], corners[i, 0, 2])
        b = put_vertex(mesh, corners[i, 1, 0], corners[i, 1, 1], corners[i, 1, 2])
        c = put_vertex(mesh, corners[i, 2, 0], corners[i, 2, 1], corners[i, 2, 2])
        put_face(mesh, a, b, c)
