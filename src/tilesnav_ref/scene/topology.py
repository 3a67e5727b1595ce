"""Counts of what is not a clean surface, and connected components."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components


@dataclass(frozen=True)
class Topology:
    """Numbers of irregular edges and faces."""

    components: int
    boundary_edges: int
    non_manifold_edges: int
    doubled_faces: int


def edge_keys(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """One number an undirected edge: (F, 3), the edges of a face from corners 0 to 1, 1 to 2 and 2 to 0.

    The number is ``lesser vertex * 2**32 + greater vertex``.
    """
    start = faces.astype(np.int64)
    end = np.roll(start, -1, axis=1)
    return (np.minimum(start, end) << 32) | np.maximum(start, end)


def face_components(vertex_count: int, faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """(F,) number of the component of every face; faces that share a vertex are in one component.

    Components are numbered by their first face.
    """
    if not len(faces):
        return np.zeros(0, np.int64)
    rows = np.concatenate((faces[:, 0], faces[:, 1]))
    columns = np.concatenate((faces[:, 1], faces[:, 2]))
    graph = coo_matrix((np.ones(len(rows), np.int8), (rows, columns)), (vertex_count, vertex_count))
    _, label = connected_components(graph, directed=False)
    return first_seen_numbers(np.asarray(label[faces[:, 0]], np.int64))


def first_seen_numbers(labels: NDArray[np.int64]) -> NDArray[np.int64]:
    """Renumber labels 0, 1, ... in the order of their first appearance."""
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return np.asarray(rank[inverse])


def count_topology(vertex_count: int, faces: NDArray[np.int64]) -> Topology:
    """Count components, edges of one face, edges of three or more faces, and repeated faces."""
    if not len(faces):
        return Topology(0, 0, 0, 0)
    _, uses = np.unique(edge_keys(faces), return_counts=True)
    different = len(np.unique(np.sort(faces, axis=1), axis=0))
    return Topology(
        components=int(face_components(vertex_count, faces).max()) + 1,
        boundary_edges=int((uses == 1).sum()),
        non_manifold_edges=int((uses > 2).sum()),
        doubled_faces=len(faces) - different,
    )
