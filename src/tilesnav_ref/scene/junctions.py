"""Vertices that lie exactly on edges, found with a uniform grid of cubes.

References
----------
A. Fujimoto, T. Tanaka, K. Iwata, ARTS: Accelerated Ray-Tracing System, 1986 (uniform grids walked along
lines). Here an edge is walked in slabs along its longest axis, and every cube that a slab's part of the
edge can touch is visited.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.scene.model import COORDINATE_LIMIT

CUBE_BITS = 20
"""Bits of a cube coordinate in a key; 2**24 steps / 16 is the finest division."""


def find_junctions(
    vertices: NDArray[np.int64], edges: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Every pair of an edge and a vertex that lies exactly inside it.

    Parameters
    ----------
    vertices : (V, 3) int64
        Different grid coordinates of magnitude below 2**23.
    edges : (E, 2) int64
        Indices into vertices; no edge of zero length.

    Returns
    -------
    edge : (J,) int64
        Edges, ascending.
    vertex : (J,) int64
        Vertices on them, in the order in which they are met from the first end of the edge.

    Raises
    ------
    ValueError
        When shapes or magnitudes are not as above.

    Notes
    -----
    Decided with 64-bit integers: differences have 24 bits, products 48.
    """
    if vertices.ndim != 2 or vertices.shape[1] != 3 or edges.ndim != 2 or edges.shape[1] != 2:
        raise ValueError(f"shapes {vertices.shape}, {edges.shape}, not (V, 3), (E, 2)")
    if len(vertices) and np.abs(vertices).max() >= COORDINATE_LIMIT:
        raise ValueError("coordinates of 2**23 or more")
    if not len(edges):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    shift = _cube_shift(vertices)
    lower = vertices.min(axis=0)
    cubes = (vertices - lower) >> shift
    keys = (cubes[:, 0] << (2 * CUBE_BITS)) | (cubes[:, 1] << CUBE_BITS) | cubes[:, 2]
    order = np.argsort(keys, kind="stable")
    grid = (np.ascontiguousarray(vertices - lower), keys[order], order)
    counts = _walk(grid, edges, shift, np.zeros(len(edges) + 1, np.int64), np.zeros(0, np.int64))
    offsets = np.concatenate((np.zeros(1, np.int64), np.cumsum(counts)))
    found = np.full(int(offsets[-1]), -1, np.int64)
    _walk(grid, edges, shift, offsets, found)
    edge = np.repeat(np.arange(len(edges)), counts)
    distance = np.abs(vertices[found] - vertices[edges[edge, 0]]).sum(axis=1)  # grows along an edge
    return edge, found[np.lexsort((distance, edge))]


def _cube_shift(vertices: NDArray[np.int64]) -> int:
    """Binary logarithm of the side of a cube: about the square root of V cubes along the longest axis."""
    extent = int((vertices.max(axis=0) - vertices.min(axis=0)).max()) + 1
    side = extent / max(1.0, float(np.sqrt(len(vertices))))
    return max(24 - CUBE_BITS, int(np.ceil(np.log2(max(side, 1.0)))))


@kernel
def _strictly_inside(p, q, v):  # type: ignore[no-untyped-def]
    """Whether v lies on the open segment from p to q."""
    dx, dy, dz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    ex, ey, ez = v[0] - p[0], v[1] - p[1], v[2] - p[2]
    if dx * ey != dy * ex or dy * ez != dz * ey or dz * ex != dx * ez:
        return False
    along = dx * ex + dy * ey + dz * ez
    return 0 < along < dx * dx + dy * dy + dz * dz


@kernel
def _slab_ranges(p, q, axis, first, last):  # type: ignore[no-untyped-def]
    """Coordinates that the segment takes while its axis coordinate is in [first, last], rounded outwards.

    Exact: (q - p) * (x - p_axis) has 48 bits, and the division is rounded down and one is added.
    """
    low = np.empty(3, np.int64)
    high = np.empty(3, np.int64)
    span = q[axis] - p[axis]
    start = max(first, min(p[axis], q[axis]))
    end = min(last, max(p[axis], q[axis]))
    for k in range(3):
        if span == 0:
            low[k], high[k] = p[k], p[k]
            continue
        a = p[k] + (q[k] - p[k]) * (start - p[axis]) // span
        b = p[k] + (q[k] - p[k]) * (end - p[axis]) // span
        low[k] = min(a, b)
        high[k] = max(a, b) + 1
    low[axis], high[axis] = start, end
    return low, high


@kernel
def _scan(grid, ends, low, high, write, found):  # type: ignore[no-untyped-def]
    """Count the vertices on an edge in a box of cubes; from position `write` on, also store them."""
    points, keys, order = grid
    count = 0
    for x in range(low[0], high[0] + 1):
        for y in range(low[1], high[1] + 1):
            column = (x << 40) | (y << 20)
            for i in range(
                np.searchsorted(keys, column | low[2]), np.searchsorted(keys, column | high[2], side="right")
            ):
                if _strictly_inside(points[ends[0]], points[ends[1]], points[order[i]]):
                    if len(found):
                        found[write + count] = order[i]
                    count += 1
    return count


@kernel
def _walk(grid, edges, shift, offsets, found):  # type: ignore[no-untyped-def]
    """Number of vertices inside each edge; stores them when `found` has room."""
    points = grid[0]
    counts = np.zeros(len(edges), np.int64)
    for e in range(len(edges)):
        p, q = points[edges[e, 0]], points[edges[e, 1]]
        axis = 0
        for k in range(1, 3):
            if abs(q[k] - p[k]) > abs(q[axis] - p[axis]):
                axis = k
        slab_first = min(p[axis], q[axis]) >> shift
        slab_last = max(p[axis], q[axis]) >> shift
        for slab in range(slab_first, slab_last + 1):
            low, high = _slab_ranges(p, q, axis, slab << shift, ((slab + 1) << shift) - 1)
            write = offsets[e] + counts[e]
            counts[e] += _scan(grid, edges[e], low >> shift, high >> shift, write, found)
    return counts
