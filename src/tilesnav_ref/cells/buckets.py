"""Faces sorted into the buckets of a uniform grid, for exact tests of boxes against few candidates.

References
----------
J. Amanatides, A. Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics 1987 (uniform grids
as an index); the lists are stored by counting sort.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.overlap import meets_box
from tilesnav_ref.kernels import kernel
from tilesnav_ref.scene.unknown import UnknownSpace

_BUCKET_LIMIT = 1 << 21
"""Most buckets; 16 MiB of offsets."""


@dataclass(frozen=True)
class FaceBuckets:
    """Faces by the bucket that their bounds meet; buckets tile a box that holds everything of interest."""

    corners: NDArray[np.int64]
    """(F, 3, 3) grid coordinates."""
    origin: NDArray[np.int64]
    """(3,) lower corner of bucket (0, 0, 0)."""
    size: int
    """Edge of a bucket, grid steps."""
    shape: NDArray[np.int64]
    """(3,) number of buckets along each axis."""
    offsets: NDArray[np.int64]
    """(B + 1,) of faces, bucket (i, j, k) at (i * shape[1] + j) * shape[2] + k."""
    faces: NDArray[np.int64]
    """Face numbers, ascending in each bucket."""
    unknown: UnknownSpace | None = None
    """Space that no cell may be in."""
    real: int | None = None
    """Faces below this number are of the scene, the others are borders of unknown space; None: all of them
    are of the scene."""

    def of_scene(self, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Which of the chosen faces (F,) are of the scene."""
        return chosen if self.real is None else chosen & (np.arange(len(chosen)) < self.real)


@kernel
def bucket_range(low: int, high: int, origin: int, size: int, count: int) -> tuple[int, int]:
    """First and last bucket along one axis that the closed interval [low, high] meets; empty when first >
    last."""
    return max((low - origin) // size, 0), min((high - origin) // size, count - 1)


@kernel
def _visit(
    corners: NDArray[np.int64],
    frame: NDArray[np.int64],
    size: int,
    cursors: NDArray[np.int64],
    faces: NDArray[np.int64],
) -> None:
    """Count (faces empty) or store every face in every bucket that its bounds meet; cursors move on."""
    first, last = np.empty(3, np.int64), np.empty(3, np.int64)
    store = len(faces) > 0
    for f in range(len(corners)):
        for k in range(3):
            low = min(corners[f, 0, k], corners[f, 1, k], corners[f, 2, k])
            high = max(corners[f, 0, k], corners[f, 1, k], corners[f, 2, k])
            first[k], last[k] = bucket_range(low, high, frame[0, k], size, frame[1, k])
        for i in range(first[0], last[0] + 1):
            for j in range(first[1], last[1] + 1):
                for k in range(first[2], last[2] + 1):
                    bucket = (i * frame[1, 1] + j) * frame[1, 2] + k
                    if store:
                        faces[cursors[bucket]] = f
                    cursors[bucket] += 1


def make_buckets(corners: NDArray[np.int64], box: NDArray[np.int64], size: int) -> FaceBuckets:
    """Sort the faces that meet a box into buckets of about the given size.

    Parameters
    ----------
    corners
        (F, 3, 3) grid coordinates.
    box
        (2, 3) grid coordinates; faces outside of it are left out.
    size
        Edge of a bucket, grid steps; doubled until there are few enough buckets.
    """
    size = max(size, 1)
    while np.prod((box[1] - box[0]) // size + 1, dtype=np.float64) > _BUCKET_LIMIT:
        size *= 2
    frame = np.stack((box[0], (box[1] - box[0]) // size + 1))
    counts = np.zeros(int(np.prod(frame[1])), np.int64)
    _visit(corners, frame, size, counts, np.empty(0, np.int64))
    offsets = np.concatenate((np.zeros(1, np.int64), np.cumsum(counts)))
    faces = np.empty(int(offsets[-1]), np.int64)
    if len(faces):
        _visit(corners, frame, size, offsets[:-1].copy(), faces)
    return FaceBuckets(corners, frame[0], size, frame[1], offsets, faces)


@kernel
def gather(
    frame: tuple[NDArray[np.int64], int, NDArray[np.int64]],
    lists: tuple[NDArray[np.int64], NDArray[np.int64]],
    box: NDArray[np.int64],
    stamp: tuple[NDArray[np.int64], int],
    room: NDArray[np.int64],
) -> int:
    """Write the faces of all buckets that a (2, 3) box meets to room (F,), each once; returns how many.

    ``stamp`` is an array (F,) and a value that no earlier call has used with it.
    """
    origin, size, shape = frame
    offsets, faces = lists
    marks, value = stamp
    count = 0
    i0, i1 = bucket_range(box[0, 0], box[1, 0], origin[0], size, shape[0])
    j0, j1 = bucket_range(box[0, 1], box[1, 1], origin[1], size, shape[1])
    k0, k1 = bucket_range(box[0, 2], box[1, 2], origin[2], size, shape[2])
    for i in range(i0, i1 + 1):
        for j in range(j0, j1 + 1):
            for k in range(k0, k1 + 1):
                bucket = (i * shape[1] + j) * shape[2] + k
                for s in range(offsets[bucket], offsets[bucket + 1]):
                    if marks[faces[s]] != value:
                        marks[faces[s]] = value
                        room[count] = faces[s]
                        count += 1
    return count


@kernel
def _occupied(
    corners: NDArray[np.int64],
    frame: tuple[NDArray[np.int64], int, NDArray[np.int64]],
    lists: tuple[NDArray[np.int64], NDArray[np.int64]],
    boxes: NDArray[np.int64],
    chosen: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    result = np.zeros(len(boxes), np.bool_)
    marks, room, normal = (
        np.full(len(corners), -1, np.int64),
        np.empty(len(corners), np.int64),
        np.empty(3, np.int64),
    )
    for b in range(len(boxes)):
        count = gather(frame, lists, boxes[b], (marks, b), room)
        for s in range(count):
            f = room[s]
            if chosen[f] and meets_box(corners[f], boxes[b, 0], boxes[b, 1], normal):
                result[b] = True
                break
    return result


def boxes_with_faces(
    buckets: FaceBuckets, boxes: NDArray[np.int64], chosen: NDArray[np.bool_] | None = None
) -> NDArray[np.bool_]:
    """Which open boxes (B, 2, 3) meet a (chosen) face; exact for boxes inside the box of the buckets.

    Returns
    -------
    ndarray
        (B,) bool.
    """
    if chosen is None:
        chosen = np.ones(len(buckets.corners), np.bool_)
    frame = (buckets.origin, buckets.size, buckets.shape)
    return np.asarray(_occupied(buckets.corners, frame, (buckets.offsets, buckets.faces), boxes, chosen))
