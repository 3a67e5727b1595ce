"""Share of the reachable free volume that the cells cover, measured by random points.

Notes
-----
The points are uniform over the domain. A point is *free* when the open box of half size ``clearance`` about
it meets no face (exact). It is *reachable* when it lies in, or is joined by a clear box to, a voxel that a
flood reached from the same seeds: a box spanned by the point and the nearest point of one of the 27 voxels
around, inflated by the clearance, meets no face. The flood is independent of the cells and finer: its
voxels have a quarter of the smallest cell size, or more where VOXEL_LIMIT asks for it. Free points in
pockets that only a finer flood could reach are therefore left out of the measure; with ``keep_interiors``
all free points are in. The coverage is the share of the free and reachable points that lie in a (closed)
cell; without such points it is 0.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.buckets import FaceBuckets, gather, make_buckets
from tilesnav_ref.cells.flood import CLEAR, REACHED, VoxelFlood, spread
from tilesnav_ref.cells.overlap import meets_box
from tilesnav_ref.cells.prisms import holds_point, prism_bounds
from tilesnav_ref.kernels import kernel
from tilesnav_ref.processors import thread_count

_POINTS_A_TASK = 20_000


@kernel
def _joined(
    corners: NDArray[np.int64],
    near: NDArray[np.int64],
    point: NDArray[np.int64],
    voxels: tuple[NDArray[np.int64], int, int, NDArray[np.uint8]],
    state: int,
    hits: NDArray[np.int64],
) -> int:
    """Number of voxels in the given state that a clear box joins to a point; they go to hits (27, 3)."""
    origin, size, clearance, states = voxels
    home = (point - origin) // size
    box, voxel, normal, count = np.empty((2, 3), np.int64), np.empty(3, np.int64), np.empty(3, np.int64), 0
    for code in range(27):
        voxel[0], voxel[1], voxel[2] = (
            home[0] + code // 9 - 1,
            home[1] + code // 3 % 3 - 1,
            home[2] + code % 3 - 1,
        )
        inside = True
        for k in range(3):
            inside = inside and 0 <= voxel[k] < states.shape[k]
        if not inside or states[voxel[0], voxel[1], voxel[2]] != state:
            continue
        for k in range(3):
            low = origin[k] + voxel[k] * size
            nearest = min(max(point[k], low), low + size)
            box[0, k], box[1, k] = min(point[k], nearest) - clearance, max(point[k], nearest) + clearance
        clear = True
        for f in near:
            if meets_box(corners[f], box[0], box[1], normal):
                clear = False
                break
        if clear:
            hits[count] = voxel
            count += 1
    return count


@kernel
def _in_reached_voxel(
    point: NDArray[np.int64], voxels: tuple[NDArray[np.int64], int, int, NDArray[np.uint8]]
) -> bool:
    """Whether the point's voxel is reached: its inflation is clear, so the point is free and joined to it."""
    origin, size, _, states = voxels
    place, inside = (point - origin) // size, True
    for k in range(3):
        inside = inside and 0 <= place[k] < states.shape[k]
    return bool(inside and states[place[0], place[1], place[2]] == REACHED)


@kernel
def _classify(
    corners: NDArray[np.int64],
    frame: tuple[NDArray[np.int64], int, NDArray[np.int64]],
    lists: tuple[NDArray[np.int64], NDArray[np.int64]],
    voxels: tuple[NDArray[np.int64], int, int, NDArray[np.uint8]],
    points: NDArray[np.int64],
) -> NDArray[np.uint8]:
    """0 a point that is not free, 1 free, 2 free and reachable."""
    size, clearance = voxels[1], voxels[2]
    result = np.zeros(len(points), np.uint8)
    marks, room = np.full(len(corners), -1, np.int64), np.empty(len(corners), np.int64)
    box, hits, normal = np.empty((2, 3), np.int64), np.empty((27, 3), np.int64), np.empty(3, np.int64)
    for p in range(len(points)):
        if _in_reached_voxel(points[p], voxels):
            result[p] = 2
            continue
        box[0], box[1] = points[p] - clearance - size, points[p] + clearance + size
        near = room[: gather(frame, lists, box, (marks, p), room)]
        box[0], box[1] = points[p] - clearance, points[p] + clearance
        free = True
        for f in near:
            if meets_box(corners[f], box[0], box[1], normal):
                free = False
                break
        if free:
            result[p] = 1 + (_joined(corners, near, points[p], voxels, REACHED, hits) > 0)
    return result


@kernel
def _locate(
    prisms: NDArray[np.int64],
    bounds: NDArray[np.int64],
    frame: tuple[NDArray[np.int64], int, NDArray[np.int64]],
    lists: tuple[NDArray[np.int64], NDArray[np.int64]],
    points: NDArray[np.int64],
) -> NDArray[np.int64]:
    result = np.full(len(points), -1, np.int64)
    offsets, members = lists
    origin, size, shape = frame
    for p in range(len(points)):
        bucket, inside = 0, True
        for k in range(3):
            place = (points[p, k] - origin[k]) // size
            inside = inside and 0 <= place < shape[k]
            bucket = bucket * shape[k] + place
        if not inside:
            continue
        for s in range(offsets[bucket], offsets[bucket + 1]):
            b, within = members[s], True
            for k in range(3):
                within = within and bounds[b, 0, k] <= points[p, k] <= bounds[b, 1, k]
            if within and holds_point(prisms[b], points[p]):
                result[p] = b
                break
    return result


def locate_points(prisms: NDArray[np.int64], points: NDArray[np.int64]) -> NDArray[np.int64]:
    """For each point (P, 3) the first closed prism (C, 11) that holds it, or -1; grid coordinates."""
    if len(prisms) == 0:
        return np.full(len(points), -1, np.int64)
    bounds = prism_bounds(prisms)
    hull = np.stack((bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)))
    size = max(int(np.max(bounds[:, 1] - bounds[:, 0])) // 2, 1)
    # a cell is sorted by its bounds, so their two corners stand for the three of a triangle
    buckets = make_buckets(bounds[:, [0, 1, 0]], hull, size)
    frame = (buckets.origin, buckets.size, buckets.shape)
    return np.asarray(_locate(prisms, bounds, frame, (buckets.offsets, buckets.faces), points))


def flood_from_points(
    flood: VoxelFlood, buckets: FaceBuckets, points: NDArray[np.int64], clearance: int
) -> None:
    """Spread a flood from all voxels that a clear box joins to one of the points (P, 3)."""
    frame, lists = (buckets.origin, buckets.size, buckets.shape), (buckets.offsets, buckets.faces)
    voxels = (flood.origin, flood.size, clearance, flood.states)
    marks, room = np.full(len(buckets.corners), -1, np.int64), np.empty(len(buckets.corners), np.int64)
    hits = np.empty((27, 3), np.int64)
    for p, point in enumerate(points):
        reach = clearance + flood.size
        near = room[: gather(frame, lists, np.stack((point - reach, point + reach)), (marks, p), room)]
        count = _joined(buckets.corners, near, point, voxels, CLEAR, hits)
        spread(flood.states, hits[:count])


def reachable_points(
    buckets: FaceBuckets, flood: VoxelFlood, points: NDArray[np.int64], limits: tuple[int, int]
) -> NDArray[np.bool_]:
    """Which points are free and reachable; see the module's notes.

    Parameters
    ----------
    buckets
        Faces; their box must hold the points inflated by clearance and one voxel.
    flood
        Voxels, with REACHED set.
    points
        (P, 3) grid.
    limits
        Clearance, grid steps; threads, 0: one for each usable processor.

    Returns
    -------
    ndarray
        (P,) bool.
    """
    clearance, threads = limits
    hull = np.stack((buckets.origin, buckets.origin + buckets.shape * buckets.size - 1))
    buckets = make_buckets(buckets.corners, hull, 2 * flood.size)  # a point has few faces around it
    frame, lists = (buckets.origin, buckets.size, buckets.shape), (buckets.offsets, buckets.faces)
    voxels = (flood.origin, flood.size, clearance, flood.states)
    parts = np.array_split(points, max(-(-len(points) // _POINTS_A_TASK), 1))
    with ThreadPoolExecutor(thread_count(threads)) as pool:
        states = list(pool.map(lambda part: _classify(buckets.corners, frame, lists, voxels, part), parts))
    return np.asarray(np.concatenate(states) == 2)
