"""Noding: edges are split at the vertices that lie exactly on them, so that neighbours share edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.junctions import find_junctions
from tilesnav_ref.scene.resplit import resplit
from tilesnav_ref.scene.topology import edge_keys


@dataclass(frozen=True)
class Noded:
    """Faces after noding."""

    faces: NDArray[np.int64]
    """(G, 3), the parts of a face in the place of the face."""
    source: NDArray[np.int64]
    """(G,) the face that each is a part of, ascending."""
    junctions: int
    """Pairs of an edge and a vertex on it that were there at first."""


def count_junctions(vertices: NDArray[np.int64], faces: NDArray[np.int64]) -> int:
    """Number of pairs of an edge and a vertex exactly inside it."""
    return len(find_junctions(vertices, _edges(np.unique(edge_keys(faces))))[0])


def node(vertices: NDArray[np.int64], faces: NDArray[np.int64], max_faces: int = 2**31 - 1) -> Noded:
    """Split every edge at the vertices exactly on it and divide the faces accordingly.

    Parameters
    ----------
    vertices : (V, 3) int64
        Different grid coordinates of magnitude below 2**23.
    faces : (F, 3) int64
        Faces with area.
    max_faces : int
        Refuse to make more.

    Raises
    ------
    SceneError
        When more than max_faces faces arise.

    Notes
    -----
    No vertex is new, so every part lies in the plane of its face, the parts cover the face exactly, and
    each has area. A cut through a face may itself run over a vertex that lies inside the face; so the step
    is repeated until no edge has a vertex on it, for the parts alone: no other edge is new. Every step
    divides areas that are multiples of half the least area of a lattice triangle, so it ends.
    """
    finished: list[NDArray[np.int64]] = []
    owners: list[NDArray[np.int64]] = []
    current, owner = np.asarray(faces, np.int64), np.arange(len(faces))
    first_count = -1
    while True:
        keys = edge_keys(current)
        unique = np.unique(keys)
        edge, vertex = find_junctions(vertices, _edges(unique))
        first_count = len(edge) if first_count < 0 else first_count
        starts = np.searchsorted(edge, np.arange(len(unique) + 1))
        slots = np.searchsorted(unique, keys)
        touched = (np.diff(starts)[slots] > 0).any(axis=1)
        finished.append(current[~touched])
        owners.append(owner[~touched])
        if not touched.any():
            source = np.concatenate(owners)
            order = np.argsort(source, kind="stable")
            return Noded(np.concatenate(finished)[order], source[order], first_count)
        rings, offsets = _rings(current[touched], slots[touched], starts, vertex)
        if sum(map(len, finished)) + len(rings) > max_faces:
            raise SceneError("scene", "noding", f"more than {max_faces} faces", "max_faces; or no noding")
        current, ring = resplit(vertices, rings, offsets)
        owner = owner[touched][ring]


def _edges(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.stack((keys >> 32, keys & 0xFFFFFFFF), axis=1)


def _rings(
    faces: NDArray[np.int64], slots: NDArray[np.int64], starts: NDArray[np.int64], vertex: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Border of every face with the points on its edges, in order; CSR."""
    counts = np.diff(starts)[slots]
    offsets = np.concatenate(([0], np.cumsum(counts.sum(axis=1) + 3)))
    rings = np.empty(int(offsets[-1]), np.int64)
    corner_at = offsets[:-1, None] + np.arange(3) + np.cumsum(counts, axis=1) - counts
    rings[corner_at] = faces
    forward = faces < np.roll(faces, -1, axis=1)
    total = counts.ravel()
    owner = np.repeat(np.arange(total.size), total)
    rank = np.arange(len(owner)) - np.repeat(np.cumsum(total) - total, total)
    ahead = forward.ravel()[owner]
    index = np.where(ahead, rank, total[owner] - 1 - rank)
    rings[corner_at.ravel()[owner] + 1 + rank] = vertex[starts[slots.ravel()[owner]] + index]
    return rings, offsets
