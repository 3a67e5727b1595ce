"""Greedy decomposition of a tile of space into prisms.

Notes
-----
The best prisms of a tile are found by `slices.best_slices` and judged by `meeting.is_clear`. A tile whose
worth, sample points that a flood has reached, is not used up by them is cut in two, where the best prisms of
both parts together are worth most, and both parts go on in the same way. A cell costs a price in samples;
at the end, from the leaves up, a tile keeps its own prisms unless those of its parts are worth more.

The samples and the cuts only guide: what is kept is clear because the exact test says so.

References
----------
The greedy division into parent tiles, cut lines in a projection and recursion follow the study that the
extension rests on; pruning from the leaves is that of L. Breiman et al., "Classification and regression
trees", 1984.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.clipping import VERTICES, cut_to_box
from tilesnav_ref.cells.meeting import is_clear
from tilesnav_ref.cells.prisms import WIDTH
from tilesnav_ref.cells.slices import MOST, best_slices, count_inside
from tilesnav_ref.cells.splits import SPLITS, propose_splits
from tilesnav_ref.kernels import kernel

_DEPTH = 64
"""Pending tiles. A cut leaves at least one part that is smaller by a smallest cell, and most cuts halve."""
NODES = 4096
"""Most tiles of one root; beyond them tiles keep what they have."""
_SAMPLES = 12
"""Samples along each edge of a tile, at most: enough to tell prisms apart by a twelfth of the tile."""
_COMPARED = 1536
"""Polygons that all cuts of a tile together look at: tiles with many faces compare fewer cuts."""


@kernel
def write_samples(
    tile: NDArray[np.int64],
    voxels: tuple[NDArray[np.int64], int, NDArray[np.uint8], int],
    samples: NDArray[np.float64],
) -> tuple[int, float]:
    """Points of a lattice in the tile whose voxel has at least a state; their number and the volume of each.

    ``voxels`` = origin, size, states, least state.
    """
    origin, size, states, least = voxels
    number = np.empty(3, np.int64)
    for k in range(3):
        number[k] = min(max((tile[1, k] - tile[0, k]) // size, 1), _SAMPLES)
    count, place = 0, np.empty(3, np.int64)
    pitch = (tile[1] - tile[0]) / number
    for i in range(number[0]):
        x = tile[0, 0] + (i + 0.5) * pitch[0]
        place[0] = int((x - origin[0]) // size)
        for j in range(number[1]):
            y = tile[0, 1] + (j + 0.5) * pitch[1]
            place[1] = int((y - origin[1]) // size)
            for k in range(number[2]):
                z = tile[0, 2] + (k + 0.5) * pitch[2]
                place[2] = int((z - origin[2]) // size)
                a, b, c = (
                    min(place[0], states.shape[0] - 1),
                    min(place[1], states.shape[1] - 1),
                    min(place[2], states.shape[2] - 1),
                )
                if states[a, b, c] >= least:
                    samples[count, 0], samples[count, 1], samples[count, 2] = x, y, z
                    count += 1
    return count, pitch[0] * pitch[1] * pitch[2]


@kernel
def _value_of_part(
    part: NDArray[np.int64],
    polygons: tuple[NDArray[np.float64], NDArray[np.int64]],
    span: tuple[int, int],
    samples: NDArray[np.float64],
    context: tuple[int, int, int, float, NDArray[np.float64], NDArray[np.int64]],
) -> float:
    """Worth of the best prisms of a part of a tile; ``context`` = sizes, price and rooms."""
    least, end_width, clearance, price, room, best = context
    for k in range(3):
        if part[1, k] - part[0, k] < least:
            return 0.0
    inside = np.ones(len(samples), np.bool_)
    for k in range(3):
        inside &= (samples[:, k] >= part[0, k]) & (samples[:, k] <= part[1, k])
    chosen = samples[inside]
    if len(chosen) <= price:
        return 0.0
    box = np.empty((2, 3))
    box[0], box[1] = part[0] - clearance, part[1] + clearance
    end = cut_to_box(polygons, span, box, room)
    shapes = (polygons[0], polygons[1], span[1], end)
    return float(best_slices(part, shapes, chosen, (least, end_width, clearance, price), best)[1])


@kernel
def choose_split(
    tile: NDArray[np.int64],
    polygons: tuple[NDArray[np.float64], NDArray[np.int64]],
    span: tuple[int, int],
    samples: NDArray[np.float64],
    context: tuple[int, int, int, float, NDArray[np.float64], NDArray[np.int64]],
) -> tuple[int, int]:
    """Axis and place of the cut whose two parts hold the most worth; axis -1 where no cut leaves a cell."""
    splits = np.empty((SPLITS, 2), np.int64)
    few = _COMPARED // max(span[1] - span[0], 1)
    count = propose_splits(tile, polygons, span, (context[0], context[2], few), splits)
    axis, place, best = -1, 0, -1.0
    part = np.empty((2, 3), np.int64)
    for s in range(count):
        value = 0.0
        for side in range(2):
            part[:] = tile
            part[1 - side, splits[s, 0]] = splits[s, 1]
            value += _value_of_part(part, polygons, span, samples, context)
        if value > best:
            axis, place, best = splits[s, 0], splits[s, 1], value
    return axis, place


@kernel
def _keep_clear(
    corners: NDArray[np.int64],
    clearance: int,
    rows: NDArray[np.int64],
    rooms: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]],
) -> int:
    """Move the clear ones of the rows to the front; returns how many."""
    kept = 0
    for r in range(len(rows)):
        if is_clear(corners, rows[r], clearance, rooms):
            rows[kept] = rows[r]
            kept += 1
    return kept


@kernel
def value_of(samples: NDArray[np.float64], rows: NDArray[np.int64], price: float) -> float:
    """Samples in some prisms less what these pay."""
    value = 0.0
    for r in range(len(rows)):
        value += count_inside(samples, rows[r]) - price
    return value


@kernel
def _as_polygons(corners: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The faces as polygons of three vertices, with room behind them."""
    room = 4 * len(corners) + 64
    vertices, counts = np.empty((room, VERTICES, 3)), np.empty(room, np.int64)
    for s in range(len(corners)):
        vertices[s, :3], counts[s] = corners[s].astype(np.float64), 3
    return vertices, counts


@kernel
def _with_room(
    polygons: tuple[NDArray[np.float64], NDArray[np.int64]], needed: int
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The polygons, copied to larger arrays where there is no room for the needed number."""
    vertices, counts = polygons
    if needed <= len(counts):
        return vertices, counts
    more_vertices, more_counts = np.empty((2 * needed, VERTICES, 3)), np.empty(2 * needed, np.int64)
    more_vertices[: len(counts)], more_counts[: len(counts)] = vertices, counts
    return more_vertices, more_counts


@kernel
def prune(
    children: NDArray[np.int64], values: NDArray[np.float64], count: int, keeps: NDArray[np.bool_]
) -> None:
    """Decide for every node whether its own prisms stay: nothing below it is worth more.

    Parameters
    ----------
    children
        (N,) first of two children, behind their parent; -1 for none.
    values
        (N,) worth of the own prisms; on return that of the best choice.
    count
        Nodes in use.
    keeps
        (N,) result.
    """
    for node in range(count - 1, -1, -1):
        keeps[node] = True
        if children[node] >= 0:
            below = values[children[node]] + values[children[node] + 1]
            if below > values[node]:
                keeps[node], values[node] = False, below


@kernel
def collect_kept(
    children: NDArray[np.int64],
    keeps: NDArray[np.bool_],
    spans: NDArray[np.int64],
    rows: NDArray[np.int64],
    result: NDArray[np.int64],
) -> int:
    """Prisms of the nodes that stay, in the order of space; returns how many."""
    # a chain of thin strips, each cut off and pending here, is as long as there are tiles
    stack, top, count = np.zeros(len(children), np.int64), 1, 0
    while top > 0:
        top -= 1
        node = stack[top]
        if keeps[node]:
            for r in range(spans[node, 0], spans[node, 1]):
                result[count] = rows[r]
                count += 1
        else:
            stack[top], stack[top + 1] = children[node] + 1, children[node]
            top += 2
    return count


@kernel
def _push_parts(
    tiles: NDArray[np.int64],
    numbers: tuple[int, int],
    cut: tuple[int, int, int],
    span: tuple[int, int],
    pending: tuple[NDArray[np.int64], int],
) -> int:
    """Make both parts of a tile; those that can hold a cell go on the stack. Returns its new top.

    ``numbers`` = the tile and the first of its parts; ``cut`` = axis, place and least edge.
    """
    node, first = numbers
    axis, place, least = cut
    stack, top = pending
    for side in range(2):
        tiles[first + side] = tiles[node]
        tiles[first + side, 1 - side, axis] = place
        if np.min(tiles[first + side, 1] - tiles[first + side, 0]) >= least:
            stack[top, 0], stack[top, 1], stack[top, 2] = first + side, span[0], span[1]
            top += 1
    return top


@kernel
def divide_tile(
    corners: NDArray[np.int64],
    extent: NDArray[np.int64],
    voxels: tuple[NDArray[np.int64], int, NDArray[np.uint8], int],
    sizes: tuple[int, int, int, float],
    result: NDArray[np.int64],
) -> int:
    """Prisms of one root.

    Parameters
    ----------
    corners
        (C, 3, 3) corners of the faces that can meet an inflated prism in the root, in grid steps from its
        lower corner: so a moved scene gives the moved prisms, in floating point too.
    extent
        (3,) of the root.
    voxels
        Origin (from that corner), edge and states of a flood, and the least state that counts.
    sizes
        Least edge, least end width across v and clearance, grid steps; volume that a cell must add.
    result
        (R, 11) room, R at least MOST * NODES, for prisms in steps from that corner.

    Returns
    -------
    int
        Number of prisms.
    """
    least, end_width, clearance, price_volume = sizes
    polygons = _as_polygons(corners)
    tiles, spans = np.empty((NODES, 2, 3), np.int64), np.zeros((NODES, 2), np.int64)
    children, values = np.full(NODES, -1, np.int64), np.zeros(NODES)
    stack = np.empty((_DEPTH, 3), np.int64)  # node, span of the faces of its parent
    rows, best = np.empty((NODES * MOST, WIDTH), np.int64), np.empty((MOST, WIDTH), np.int64)
    rooms = np.empty((11, 3), np.int64), np.empty(3, np.int64), np.empty(WIDTH, np.int64)
    samples_room, clip_room, box = (
        np.empty((_SAMPLES**3, 3)),
        np.empty((2, VERTICES + 1, 3)),
        np.empty((2, 3)),
    )
    tiles[0, 0], tiles[0, 1], nodes, row_count, top = 0, extent, 1, 0, 1
    stack[0, 0], stack[0, 1], stack[0, 2] = 0, 0, len(corners)
    while top > 0:
        top -= 1
        node, start, end = stack[top]
        tile = tiles[node]
        spans[node, 0] = spans[node, 1] = row_count
        number, volume = write_samples(tile, voxels, samples_room)
        price = price_volume / volume
        if number <= price:
            continue
        polygons = _with_room(polygons, 3 * end - 2 * start)
        box[0], box[1] = tile[0] - clearance, tile[1] + clearance
        new_end = cut_to_box(polygons, (start, end), box, clip_room)
        samples = samples_room[:number]
        shapes = polygons[0], polygons[1], end, new_end
        count, value = best_slices(tile, shapes, samples, (least, end_width, clearance, price), best)
        kept = _keep_clear(corners, clearance, best[:count], rooms)
        if kept < count:
            value = value_of(samples, best[:kept], price)
        rows[row_count : row_count + kept] = best[:kept]
        row_count += kept
        spans[node, 1], values[node] = row_count, value * volume
        if number - value - kept * price <= price or nodes + 2 > NODES or top + 2 > _DEPTH:
            continue
        context = (least, end_width, clearance, price, clip_room, best)
        axis, place = choose_split(tile, polygons, (end, new_end), samples, context)
        if axis < 0:
            continue
        children[node] = nodes
        top = _push_parts(tiles, (node, nodes), (axis, place, least), (end, new_end), (stack, top))
        nodes += 2
    keeps = np.empty(nodes, np.bool_)
    prune(children, values, nodes, keeps)
    return int(collect_kept(children, keeps, spans, rows, result))
