"""A memory of shapes: what followed a triangle across an edge, wherever it lay.

A hash table with linear probing that grows with what it holds: few shapes are distinct, and a small table
stays near the processor.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tilesnav_ref.kernels import plain_inner_kernel, plain_kernel
from tilesnav_ref.packet.geometry_mesh import EDGES, FROM, NONE, THIRD, TO, mix, opposite_edge

SHAPES, SHAPE_MASK = range(2)
"""Counts of a memory; slots that are in use less one."""
FIRST_SLOTS = 1024


class Memory(NamedTuple):
    """Shapes seen so far."""

    counts: Any
    """(2,) int64."""
    shapes: Any
    """(N, 9) int32: two vectors that span a triangle, and the third one from the same corner."""
    table: Any
    """(S,) int32 shape in each slot or NONE."""


def new_memory(faces: int) -> Memory:
    """Return an empty memory with room for the edges of a number of faces."""
    room = 3 * faces
    slots = FIRST_SLOTS
    while slots < 2 * room:
        slots *= 2
    memory = Memory(np.zeros(2, np.int64), np.empty((room, 9), np.int32), np.empty(slots, np.int32))
    memory.counts[SHAPE_MASK] = FIRST_SLOTS - 1
    memory.table[:FIRST_SLOTS] = NONE
    return memory


@plain_inner_kernel
def shape_hash(bx: Any, by: Any, bz: Any, cx: Any, cy: Any, cz: Any) -> Any:
    """Hash of two vectors of magnitudes below 2^25: six products below 2^56."""
    one = np.int64(bx) * 0x5E3779B1 + np.int64(by) * 0x45EBCA77 + np.int64(bz) * 0x42B2AE3D
    return mix(one + np.int64(cx) * 0x3C6EF372 + np.int64(cy) * 0x27D4EB2F + np.int64(cz) * 0x165667B1)


@plain_inner_kernel
def find_shape(memory: Any, mesh: Any, a: Any, b: Any, c: Any) -> Any:
    """Slot of the shape of a face seen from its edge (a, b), and the number of what followed it or NONE."""
    v = mesh.vertices
    x, y, z = v[a, 0], v[a, 1], v[a, 2]
    bx, by, bz = v[b, 0] - x, v[b, 1] - y, v[b, 2] - z
    cx, cy, cz = v[c, 0] - x, v[c, 1] - y, v[c, 2] - z
    k, table, mask = memory.shapes, memory.table, memory.counts[SHAPE_MASK]
    slot = shape_hash(bx, by, bz, cx, cy, cz) & mask
    n = table[slot]
    while n != NONE:
        same_b = k[n, 0] == bx and k[n, 1] == by and k[n, 2] == bz
        if same_b and k[n, 3] == cx and k[n, 4] == cy and k[n, 5] == cz:
            break
        slot = (slot + 1) & mask
        n = table[slot]
    return slot, n


@plain_kernel
def double_table(memory: Any) -> Any:
    """Take twice as many slots into use."""
    slots = 2 * (memory.counts[SHAPE_MASK] + 1)
    mask = slots - 1
    memory.counts[SHAPE_MASK] = mask
    table = memory.table
    table[:slots] = NONE
    k = memory.shapes
    for n in range(memory.counts[SHAPES]):
        slot = shape_hash(k[n, 0], k[n, 1], k[n, 2], k[n, 3], k[n, 4], k[n, 5]) & mask
        while table[slot] != NONE:
            slot = (slot + 1) & mask
        table[slot] = n


@plain_inner_kernel
def put_shape(memory: Any, mesh: Any, face: Any, v: Any, found: Any) -> Any:
    """Note that vertex v follows a face (a, b, c) across its edge; `found` is what `find_shape` returned."""
    a, b, c = face
    slot, n = found
    places, shapes = mesh.vertices, memory.shapes
    count = memory.counts[SHAPES]
    row = count if n == NONE else np.int64(n)
    if n == NONE:
        memory.counts[SHAPES] = count + 1
        memory.table[slot] = count
        for k in range(3):
            shapes[row, k] = places[b, k] - places[a, k]
            shapes[row, 3 + k] = places[c, k] - places[a, k]
    for k in range(3):
        shapes[row, 6 + k] = places[v, k] - places[a, k]
    if 2 * memory.counts[SHAPES] > memory.counts[SHAPE_MASK] + 1:
        double_table(memory)


@plain_kernel
def remember_held(memory: Any, mesh: Any) -> Any:
    """Note for each edge of the faces put in what follows across it."""
    edges = mesh.edges
    for e in range(mesh.counts[EDGES]):
        other = opposite_edge(mesh, e)
        if other != NONE:
            a, b, c = edges[e, FROM], edges[e, TO], edges[e, THIRD]
            put_shape(memory, mesh, (a, b, c), edges[other, THIRD], find_shape(memory, mesh, a, b, c))
