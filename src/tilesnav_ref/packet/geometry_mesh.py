"""Faces of an object as both sides know them: vertices by place, directed edges, memory of shapes.

Hash tables with linear probing; what they find is what was put in, never what merely looks like it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tilesnav_ref.kernels import kernel

VERTICES, EDGES = range(2)
"""Words of a mesh."""
NONE = -1
LIMIT = 1 << 23
"""Coordinates are smaller in magnitude."""


def new_mesh(faces: int) -> Any:
    """Return an empty mesh with room for a number of faces.

    A tuple: counts; places (V, 3) of vertices; their hash table; edges (E, 3): from, to, third vertex;
    hash table of edges; latest edge from and latest edge to each vertex (V, 2); the edges before them (E, 2).
    """
    room = 3 * faces
    slots = 1 << max(2 * room, 4).bit_length()
    return (
        np.zeros(2, np.int64),
        np.zeros((room, 3), np.int64),
        np.full(slots, NONE, np.int64),
        np.zeros((room, 3), np.int64),
        np.full(slots, NONE, np.int64),
        np.full((room, 2), NONE, np.int64),
        np.full((room, 2), NONE, np.int64),
    )


@kernel
def mix(a: Any, b: Any, c: Any) -> Any:
    """Hash of three integers, 0 to 2**40 - 1; no product leaves 63 bits."""
    low = (1 << 30) - 1
    h = (a & low) * 0x5E3779B1 + (b & low) * 0x45EBCA77 + (c & low) * 0x42B2AE3D
    h ^= h >> 29
    h = (h & low) * 0x6C1B3C6D
    return (h ^ (h >> 23)) & ((1 << 40) - 1)


@kernel
def find_vertex(mesh: Any, x: Any, y: Any, z: Any) -> Any:
    """Slot of a place, and its vertex or NONE."""
    places, table = mesh[1], mesh[2]
    slot = mix(x, y, z) & (len(table) - 1)
    while table[slot] != NONE:
        v = table[slot]
        if places[v, 0] == x and places[v, 1] == y and places[v, 2] == z:
            return slot, v
        slot = (slot + 1) & (len(table) - 1)
    return slot, NONE


@kernel
def put_vertex(mesh: Any, x: Any, y: Any, z: Any) -> Any:
    """Vertex at a place, new where there was none."""
    slot, v = find_vertex(mesh, x, y, z)
    if v != NONE:
        return v
    v = mesh[0][VERTICES]
    mesh[0][VERTICES] = v + 1
    mesh[1][v, 0] = x
    mesh[1][v, 1] = y
    mesh[1][v, 2] = z
    mesh[2][slot] = v
    return v


@kernel
def find_edge(mesh: Any, a: Any, b: Any) -> Any:
    """Slot of a directed edge, and the latest edge there or NONE."""
    edges, table = mesh[3], mesh[4]
    slot = mix(a, b, 0) & (len(table) - 1)
    while table[slot] != NONE:
        e = table[slot]
        if edges[e, 0] == a and edges[e, 1] == b:
            return slot, e
        slot = (slot + 1) & (len(table) - 1)
    return slot, NONE


@kernel
def put_face(mesh: Any, face: Any) -> Any:
    """Put a face in; a directed edge that is there already is known by its latest face."""
    a, b, c = face
    for _k in range(3):
        slot, _before = find_edge(mesh, a, b)
        e = mesh[0][EDGES]
        mesh[0][EDGES] = e + 1
        mesh[3][e, 0] = a
        mesh[3][e, 1] = b
        mesh[3][e, 2] = c
        mesh[4][slot] = e
        mesh[6][e, 0] = mesh[5][a, 0]
        mesh[5][a, 0] = e
        mesh[6][e, 1] = mesh[5][b, 1]
        mesh[5][b, 1] = e
        a, b, c = b, c, a


def new_memory(faces: int) -> Any:
    """Return an empty memory of shapes: count, keys (N, 6), values (N, 3), hash table."""
    room = 3 * faces
    slots = 1 << max(2 * room, 4).bit_length()
    return (
        np.zeros(1, np.int64),
        np.zeros((room, 6), np.int64),
        np.zeros((room, 3), np.int64),
        np.full(slots, NONE, np.int64),
    )


@kernel
def recall(memory: Any, mesh: Any, a: Any, b: Any, c: Any) -> Any:
    """Slot of the shape of a face seen from its edge, and the number of what followed it or NONE."""
    places = mesh[1]
    keys, table = memory[1], memory[3]
    x, y, z = places[a, 0], places[a, 1], places[a, 2]
    bx, by, bz = places[b, 0] - x, places[b, 1] - y, places[b, 2] - z
    cx, cy, cz = places[c, 0] - x, places[c, 1] - y, places[c, 2] - z
    slot = mix(mix(bx, by, bz), mix(cx, cy, cz), 1) & (len(table) - 1)
    while table[slot] != NONE:
        k = keys[table[slot]]
        if k[0] == bx and k[1] == by and k[2] == bz and k[3] == cx and k[4] == cy and k[5] == cz:
            return slot, table[slot]
        slot = (slot + 1) & (len(table) - 1)
    return slot, NONE


@kernel
def remember(memory: Any, mesh: Any, face: Any, v: Any) -> Any:
    """Note what follows a face (a, b, c) across its edge from a to b: a face with vertex v."""
    places = mesh[1]
    a, b, c = face
    slot, n = recall(memory, mesh, a, b, c)
    if n == NONE:
        n = memory[0][0]
        memory[0][0] = n + 1
        for k in range(3):
            memory[1][n, k] = places[b, k] - places[a, k]
            memory[1][n, 3 + k] = places[c, k] - places[a, k]
        memory[3][slot] = n
    value = memory[2][n]
    for k in range(3):
        value[k] = places[v, k] - places[a, k]


@kernel
def put_corners(mesh: Any, corners: Any) -> Any:
    """Put faces in by their corners, (F, 3, 3) integers."""
    vertices = np.zeros(3, np.int64)
    for i in range(len(corners)):
        for k in range(3):
            x, y, z = corners[i, k, 0], corners[i, k, 1], corners[i, k, 2]
            vertices[k] = put_vertex(mesh, np.int64(x), np.int64(y), np.int64(z))
        put_face(mesh, (vertices[0], vertices[1], vertices[2]))


@kernel
def remember_held(memory: Any, mesh: Any) -> Any:
    """Note for each edge of the faces put in what follows across it."""
    for e in range(mesh[0][EDGES]):
        a, b, c = mesh[3][e, 0], mesh[3][e, 1], mesh[3][e, 2]
        reverse = find_edge(mesh, b, a)[1]
        if reverse != NONE:
            remember(memory, mesh, (a, b, c), mesh[3][reverse, 2])
