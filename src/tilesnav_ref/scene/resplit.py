"""Division of triangles at points of their border, without new points.

References
----------
G. H. Meisters, Polygons have ears, 1975. Every polygon here is a triangle with points on its sides, hence
convex, and an ear may be cut at every true corner as long as what remains has area.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel


def resplit(
    vertices: NDArray[np.int64], rings: NDArray[np.int64], offsets: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Divide convex rings into triangles of positive area whose corners are the points of the ring.

    Parameters
    ----------
    vertices : (V, 3) int64
        Grid coordinates of magnitude below 2**23.
    rings : (R,) int64
        Indices into vertices, ring after ring; each the border of a triangle with area, in order.
    offsets : (N + 1,) int64
        Where the rings begin.

    Returns
    -------
    faces : (T, 3) int64
        Triangles, oriented as their ring; a ring of k points gives k - 2.
    source : (T,) int64
        The ring of each.

    Notes
    -----
    The ear with the shortest cut goes first, ties by the number of its tip, so that two rings of the same
    points are divided in the same way whatever their orientation and first point.
    """
    sizes = np.diff(offsets)
    if len(offsets) < 1 or offsets[-1] != len(rings) or (sizes < 3).any():
        raise ValueError("offsets do not divide the rings into rings of three points or more")
    faces = np.empty((int((sizes - 2).sum()), 3), np.int64)
    _divide_all(vertices, rings, offsets, faces)
    return faces, np.repeat(np.arange(len(sizes)), sizes - 2)


@kernel
def _collinear(p, q, r):  # type: ignore[no-untyped-def]
    ax, ay, az = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    bx, by, bz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    return ax * by == ay * bx and ay * bz == az * by and az * bx == ax * bz


@kernel
def _remainder_flat(vertices, ring, count, tip):  # type: ignore[no-untyped-def]
    """Whether the ring without its point number `tip` lies on a line."""
    a = ring[(tip + 1) % count]
    b = ring[(tip + 2) % count]
    for k in range(3, count):
        if not _collinear(vertices[a], vertices[b], vertices[ring[(tip + k) % count]]):
            return False
    return True


@kernel
def _best_ear(vertices, ring, count):  # type: ignore[no-untyped-def]
    """Position of the tip of the ear with the shortest cut, or -1."""
    best, best_length = -1, np.int64(0)
    for k in range(count):
        before, after = vertices[ring[k - 1 if k else count - 1]], vertices[ring[(k + 1) % count]]
        if _collinear(before, vertices[ring[k]], after):
            continue
        length = np.int64(0)
        for i in range(3):
            length += (after[i] - before[i]) ** 2
        better = best < 0 or length < best_length or (length == best_length and ring[k] < ring[best])
        if better and (count == 3 or not _remainder_flat(vertices, ring, count, k)):
            best, best_length = k, length
    return best


@kernel
def _divide_all(vertices, rings, offsets, faces):  # type: ignore[no-untyped-def]
    row = 0
    for n in range(len(offsets) - 1):
        ring = rings[offsets[n] : offsets[n + 1]].copy()
        count = len(ring)
        while count >= 3:
            k = _best_ear(vertices, ring, count)
            if k < 0:
                raise ValueError("a ring without area")
            faces[row, 0] = ring[k - 1 if k else count - 1]
            faces[row, 1] = ring[k]
            faces[row, 2] = ring[(k + 1) % count]
            row += 1
            ring[k : count - 1] = ring[k + 1 : count].copy()
            count -= 1
