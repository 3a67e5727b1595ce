"""Units: what a flood adds at a time, single faces or patches, with the edges between them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.visibility.geometry import Geometry
from tilesnav_ref.visibility.patches import label_patches


class Units(NamedTuple):
    """A division of the faces of a scene; constant."""

    of_face: NDArray[np.int32]
    """(F,) unit of each face."""
    offsets: NDArray[np.int64]
    """(U + 1,)."""
    faces: NDArray[np.int32]
    """Faces of each unit."""
    border_offsets: NDArray[np.int64]
    """(U + 1,)."""
    border: NDArray[np.int32]
    """Edges that an odd number of the faces of a unit share."""
    lower: NDArray[np.float64]
    """(U, 3) lower corner of each unit."""
    upper: NDArray[np.float64]
    """(U, 3)."""


class Division(NamedTuple):
    """The divisions of a scene that occluders are grown over; constant."""

    single: Units
    """Each face alone."""
    patches: Units
    """Pieces that occlude together (patches.py)."""
    sheets: Units
    """What is in one piece over edges of two faces."""
    inner: NDArray[np.int8]
    """(F,) side of the face (sign of the orientation) from which its sheet is likely to hide it, or 0."""


def divide(geometry: Geometry, faces: NDArray[np.int32]) -> Division:
    """Divide a geometry with the vertices (F, 3) of its faces; `inner` is left 0."""
    opaque = ~geometry.porous
    edges = geometry.face_edges
    labels = (
        np.arange(len(edges), dtype=np.int32),
        label_patches(geometry.corners, faces, edges, opaque),
        label_sheets(edges, opaque, len(geometry.edge_ends)),
    )
    single, patches, sheets = (make_units(label, edges, geometry.corners) for label in labels)
    return Division(single, patches, sheets, np.zeros(len(edges), np.int8))


FINE = 8
"""Faces of a patch, on average, from which on floods over patches are worth the time.

Munich has 4: 20 % more time for the same sets; the sample town in fine detail 36: a third of the faces left.
"""


def is_fine(division: Division) -> bool:
    """Whether walls are divided so finely that floods over patches are worth their time."""
    return len(division.single.offsets) - 1 >= FINE * (len(division.patches.offsets) - 1)


def make_units(
    labels: NDArray[np.int32],
    face_edges: NDArray[np.int32],
    corners: NDArray[np.float64],
) -> Units:
    """Units from the number of each face (F,), the edges (F, 3) and the corners (F, 3, 3) of the faces."""
    count = int(labels.max(initial=-1)) + 1
    edges = int(face_edges.max(initial=-1)) + 1
    order = np.argsort(labels, kind="stable").astype(np.int32)
    offsets = np.concatenate([[0], np.cumsum(np.bincount(labels, minlength=count))]).astype(np.int64)
    owner = np.repeat(labels[order].astype(np.int64), 3)
    keys, number = np.unique(owner * edges + face_edges[order].ravel(), return_counts=True)
    keys = keys[number % 2 == 1]
    border_offsets = np.searchsorted(keys, np.arange(count + 1) * edges).astype(np.int64)
    border = (keys % max(edges, 1)).astype(np.int32)
    lower = np.minimum.reduceat(corners[order].min(axis=1), offsets[:-1], axis=0)
    upper = np.maximum.reduceat(corners[order].max(axis=1), offsets[:-1], axis=0)
    return Units(labels, offsets, order, border_offsets, border, lower, upper)


@kernel
def label_sheets(face_edges, opaque, edges):  # type: ignore[no-untyped-def]
    """(F,) number of the sheet of each face: what is in one piece over edges of two opaque faces.

    Numbers are in the order of the first faces; a face that is not opaque is a sheet of its own.
    """
    count = len(face_edges)
    number = np.zeros(edges, np.int32)
    ends = np.zeros((edges, 2), np.int32)
    for face in range(count):
        if opaque[face]:
            for k in range(3):
                edge = face_edges[face, k]
                if number[edge] < 2:
                    ends[edge, number[edge]] = face
                number[edge] += 1
    labels = np.full(count, -1, np.int32)
    waiting = np.empty(count, np.int32)
    label = 0
    for seed in range(count):
        if labels[seed] >= 0:
            continue
        labels[seed] = label
        waiting[0] = seed
        top = 1 if opaque[seed] else 0
        while top > 0:
            top -= 1
            face = waiting[top]
            for k in range(3):
                edge = face_edges[face, k]
                if number[edge] != 2:
                    continue
                other = ends[edge, 0] + ends[edge, 1] - face
                if labels[other] < 0:
                    labels[other] = label
                    waiting[top] = other
                    top += 1
        label += 1
    return labels
