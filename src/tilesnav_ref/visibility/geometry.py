"""What the kernels see of a scene: corners in fine integer units, edges with their faces, a box hierarchy."""

from __future__ import annotations

from fractions import Fraction
from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.visibility.exact import COORDINATE_BITS

LEAST_BITS = 2
"""Inner points of a face are quarters at least, so a grid step is four fine units at least."""

LEAF_FACES = 4
"""A leaf holds at most so many faces; more would be tested one by one anyway."""


class Geometry(NamedTuple):
    """Arrays of one scene for the kernels; lengths in fine units, origin in the middle of the scene."""

    corners: NDArray[np.float64]
    """(F, 3, 3) integer-valued, below 2**29 in magnitude."""
    face_edges: NDArray[np.int32]
    """(F, 3) edge from corner k to corner k + 1."""
    edge_offsets: NDArray[np.int64]
    """(E + 1,)."""
    edge_faces: NDArray[np.int32]
    """Faces of each edge."""
    edge_ends: NDArray[np.float64]
    """(E, 2, 3) end points of each edge."""
    box_lower: NDArray[np.float64]
    """(B, 3) lower corner of each node of the hierarchy."""
    box_upper: NDArray[np.float64]
    """(B, 3)."""
    box_child: NDArray[np.int32]
    """(B,) first child; the second follows it; -1 in a leaf."""
    box_first: NDArray[np.int32]
    """(B,) first position in face_order."""
    box_count: NDArray[np.int32]
    """(B,) number of faces below the node."""
    face_order: NDArray[np.int32]
    """(F,) faces in the order of the leaves."""
    porous: NDArray[np.bool_]
    """(F,) the face is seen and hides nothing."""
    one_sided: NDArray[np.bool_]
    """(F,) the face is seen only from where its corners run counter-clockwise."""
    near: int
    """Whole fine units; what is at most so far away is within the range."""
    far: int
    """Whole fine units; what is at least so far away is out of range. UNLIMITED: nothing is."""


UNLIMITED = 2**31
"""Fine units; farther than any two points of a scene are apart."""


class FineFrame(NamedTuple):
    """The map from grid coordinates to fine units: fine = (grid - origin) * scale, exact."""

    origin: NDArray[np.int64]
    """(3,) grid coordinates of the middle of the scene."""
    scale: int
    """A power of two: fine units in a grid step; each factor of two is one exact bisection."""


def fine_frame(low: NDArray[np.int64], high: NDArray[np.int64]) -> FineFrame:
    """Finest frame in which every point of the box [low, high] (grid coordinates) stays below 2**29."""
    origin = (low + high) // 2
    reach = int(max((high - origin).max(), (origin - low).max(), 1)) + 1
    bits = COORDINATE_BITS - reach.bit_length()
    if bits < LEAST_BITS:
        raise ValueError(
            f"extent of {reach} grid steps about the origin;"
            f" less than 2**{COORDINATE_BITS - LEAST_BITS} is allowed"
        )
    return FineFrame(origin.astype(np.int64), 1 << bits)


def to_fine(points: NDArray[np.int64], frame: FineFrame) -> NDArray[np.float64]:
    """Grid coordinates (..., 3) in fine units, as integer-valued float64."""
    return ((points - frame.origin) * frame.scale).astype(np.float64)


def build_geometry(scene: Scene, frame: FineFrame, max_range: float | None = None) -> Geometry:
    """Corners, edges and box hierarchy of a scene in the fine units of `frame`; `max_range` in metres."""
    corners = np.ascontiguousarray(to_fine(scene.corners(), frame))
    ends, face_edges = _edges(scene.faces)
    order = np.argsort(face_edges.ravel(), kind="stable")
    edge_offsets = np.zeros(len(ends) + 1, np.int64)
    np.cumsum(np.bincount(face_edges.ravel(), minlength=len(ends)), out=edge_offsets[1:])
    edge_faces = (order // 3).astype(np.int32)
    edge_ends = np.ascontiguousarray(to_fine(scene.vertices[ends], frame))
    boxes = box_hierarchy(corners.min(axis=1), corners.max(axis=1), LEAF_FACES)
    edges = (face_edges, edge_offsets, edge_faces, edge_ends)
    flags = (scene.porous, scene.one_sided)
    return Geometry._make((corners, *edges, *boxes, *flags, *_reach(scene, frame, max_range)))


def _reach(scene: Scene, frame: FineFrame, max_range: float | None) -> tuple[int, int]:
    """Greatest whole number below a range in fine units, and least one that is not below it."""
    if max_range is None or max_range >= UNLIMITED * scene.step / frame.scale:
        return UNLIMITED, UNLIMITED
    reach = Fraction(max_range) / Fraction(scene.step) * frame.scale
    return ceil(reach) - 1, ceil(reach)


def _edges(faces: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    pairs = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    ends, inverse = np.unique(np.sort(pairs, axis=1), axis=0, return_inverse=True)
    return ends, np.ascontiguousarray(inverse.reshape(-1, 3).astype(np.int32))


@kernel
def box_hierarchy(face_lower, face_upper, leaf):  # type: ignore[no-untyped-def]
    """Median split on the longest axis of the centres, node children adjacent."""
    count = len(face_lower)
    order = np.arange(count).astype(np.int32)
    centre = face_lower + face_upper
    size = max(1, 2 * count)
    lower = np.empty((size, 3))
    upper = np.empty((size, 3))
    child = np.full(size, -1, np.int32)
    first = np.zeros(size, np.int32)
    number = np.zeros(size, np.int32)
    number[0] = count
    used = 1
    node = 0
    while node < used:
        begin, end = first[node], first[node] + number[node]
        _bound(face_lower, face_upper, order[begin:end], lower[node], upper[node])
        if number[node] > leaf:
            axis = _longest_axis(centre, order[begin:end])
            part = order[begin:end].copy()
            order[begin:end] = part[np.argsort(centre[part, axis], kind="mergesort")]
            half = number[node] // 2
            child[node] = used
            first[used], number[used] = begin, half
            first[used + 1], number[used + 1] = begin + half, number[node] - half
            used += 2
        node += 1
    return (
        lower[:used].copy(),
        upper[:used].copy(),
        child[:used].copy(),
        first[:used].copy(),
        number[:used].copy(),
        order,
    )


@kernel
def _bound(face_lower, face_upper, faces, lower, upper):  # type: ignore[no-untyped-def]
    for k in range(3):
        lower[k], upper[k] = np.inf, -np.inf
        for f in faces:
            lower[k] = min(lower[k], face_lower[f, k])
            upper[k] = max(upper[k], face_upper[f, k])


@kernel
def _longest_axis(centre, faces):  # type: ignore[no-untyped-def]
    best, axis = -1.0, 0
    for k in range(3):
        low, high = np.inf, -np.inf
        for f in faces:
            low, high = min(low, centre[f, k]), max(high, centre[f, k])
        if high - low > best:
            best, axis = high - low, k
    return axis
