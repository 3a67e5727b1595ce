"""A proven bound of the distance of one set of triangles from another, and which ones it is kept by.

The distance from a triangle c is a convex function, so over a convex piece t it is greatest at a corner of t,
and

    max over x in t of min over c of d(x, c)  <=  min over c of max over corners x of t of d(x, c).

The right side bounds the left one and tends to it when t is divided. So a triangle is divided until the
bound is near the greatest distance found at any corner so far, or below what matters. Where a piece is flat
over a triangle c, it is cut along the sides of c: what lies over c is settled then, and surfaces that
coincide cost as many pieces as they have faces, however they are divided.

References
----------
M. Guthe, P. Borodin, R. Klein, "Fast and accurate Hausdorff distance calculation between meshes", 2005
(bounds of parts of triangles, and division where they are too wide).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.levels.nearest import squared_distance
from tilesnav_ref.levels.pieces import CORNERS, Stack, cut, halve, heights, push

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

DEPTH = 48
"""Cuts at most that a piece comes from; its bound is then taken as it is."""
LOOSE = 1.02
"""A bound may be this many times the greatest distance found."""
THIN = 2.0**-10
"""Grid steps; a side of a triangle that leaves less of a piece on its other side is no place to cut it."""


@kernel
def boxes_of(triangles: Floats) -> Floats:
    """(N, 2, 3) least and greatest coordinates of triangles."""
    boxes = np.empty((len(triangles), 2, 3))
    for i in range(len(triangles)):
        for k in range(3):
            a, b, c = triangles[i, 0, k], triangles[i, 1, k], triangles[i, 2, k]
            boxes[i, 0, k] = min(a, b, c)
            boxes[i, 1, k] = max(a, b, c)
    return boxes


@kernel
def _box_square(lower: Floats, upper: Floats, box: Floats) -> float:
    """Square of the distance of two boxes."""
    total = 0.0
    for k in range(3):
        gap = max(lower[k] - box[1, k], box[0, k] - upper[k])
        if gap > 0:
            total += gap * gap
    return total


@kernel
def _corner_square(piece: Floats, triangle: Floats, limit: float) -> float:
    """Greatest square of the distance of a corner from a triangle; any larger one beyond a limit."""
    worst = 0.0
    for corner in piece:
        worst = max(worst, squared_distance(triangle, corner))
        if worst > limit:
            break
    return worst


@kernel
def _keep_near(
    piece: Floats, triangles: Floats, boxes: Floats, given: Ints, kept: Ints
) -> tuple[int, int, float]:
    """Find the triangle nearest to all of a piece, and all that are nearest to some point of it.

    Returns the number of those kept, the nearest, and the greatest square of the distance of a corner from
    it.
    """
    lower, upper = np.empty(3), np.empty(3)
    for k in range(3):
        lower[k] = upper[k] = piece[0, k]
        for i in range(1, len(piece)):
            lower[k], upper[k] = min(lower[k], piece[i, k]), max(upper[k], piece[i, k])
    best, nearest, count = np.inf, given[0], 0
    for index in given:
        if _box_square(lower, upper, boxes[index]) <= best:
            kept[count] = index
            count += 1
            square = _corner_square(piece, triangles[index], best)
            if square < best:
                best, nearest = square, index
    last = 0
    for i in range(count):  # some were kept before the best was known
        if _box_square(lower, upper, boxes[kept[i]]) <= best:
            kept[last] = kept[i]
            last += 1
    return last, nearest, best


@kernel
def _nearest(point: Floats, triangles: Floats, boxes: Floats, kept: Ints, enough: float) -> tuple[float, int]:
    """Square of the distance from the nearest triangle, and which it is; any that is near enough will do."""
    least, found = np.inf, kept[0]
    for index in kept:
        if _box_square(point, point, boxes[index]) < least:
            square = squared_distance(triangles[index], point)
            if square < least:
                least, found = square, index
                if least <= enough:
                    break
    return least, found


@kernel
def _greatest_nearest(piece: Floats, triangles: Floats, boxes: Floats, kept: Ints, enough: float) -> float:
    """Greatest over the corners of a piece of the square of the distance from the nearest triangle.

    It is `enough` or less, and no more is said of it, where all of them are that near.
    """
    greatest = enough
    for corner in piece:
        greatest = max(greatest, _nearest(corner, triangles, boxes, kept, greatest)[0])
    return greatest


@kernel
def _middle(piece: Floats) -> Floats:
    """Mean of the corners of a piece."""
    middle = np.zeros(3)
    for corner in piece:
        middle += corner
    return middle / len(piece)


@kernel
def _cut_around(stack: Stack, top: int, piece: Floats, triangle: Floats, limit: float, depth: int) -> int:
    """Cut a piece along the sides of a triangle that it is flat over; returns `top` where it is not."""
    normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
    values = np.empty(CORNERS)
    length = np.sqrt((normal * normal).sum())
    if length == 0.0:
        return top
    low, high = heights(piece, triangle[0], normal / length, values)
    if max(abs(low), abs(high)) > np.sqrt(limit):
        return top
    rest, inner = np.empty((CORNERS, 3)), np.empty((CORNERS, 3))
    size = len(piece)
    rest[:size] = piece
    before = top
    for k in range(3):
        inwards = np.cross(normal, triangle[(k + 1) % 3] - triangle[k])
        inwards /= np.sqrt((inwards * inwards).sum())
        low, high = heights(rest[:size], triangle[k], inwards, values)
        if low >= -THIN:
            continue
        if high <= THIN or size + 2 > CORNERS:
            return before
        outer = cut(rest[:size], values[:size], -1.0, inner)
        top = push(stack, top, inner[:outer], depth)
        size = cut(rest[:size], values[:size], 1.0, inner)
        rest[:size] = inner[:size]
    return push(stack, top, rest[:size], depth) if top > before else before


@kernel
def _divide(stack: Stack, top: int, piece: Floats, triangle: Floats, limit: float) -> int:
    """Put the parts of a piece, which has been taken off the stack at its top, on the stack.

    The triangle is that nearest to the middle of the piece.
    """
    depth = stack.depths[top] + 1
    reached = _cut_around(stack, top, piece, triangle, limit, depth)
    return int(reached if reached > top else halve(stack, top, piece, depth))


@kernel
def _new_stack() -> Stack:
    rows = 4 * DEPTH + 8
    return Stack(np.empty((rows, CORNERS, 3)), np.empty(rows, np.int64), np.empty(rows, np.int64))


@kernel
def bound_distance(sources: Floats, triangles: Floats, floor: float) -> float:
    """Bound the greatest distance of a point of some triangles from the nearest one of others.

    Parameters
    ----------
    sources, triangles : (N, 3, 3), (M, 3, 3) float64
        Corners, grid steps; M is 1 or more.
    floor : float
        Grid steps, greater than 0; smaller distances are not told apart.

    Returns
    -------
    float
        At least the distance, but for the rounding of the arithmetic, and at most the greater one of `floor`
        and LOOSE times the distance, unless DEPTH cuts do not suffice.
    """
    boxes = boxes_of(triangles)
    everything = np.arange(len(triangles))
    kept = np.empty((DEPTH + 1, len(triangles)), np.int64)
    counts = np.zeros(DEPTH + 1, np.int64)
    stack = _new_stack()
    piece = np.empty((CORNERS, 3))
    limit, bound = floor * floor, 0.0
    for source in sources:  # a great distance that is known early saves the division of what is nearer
        seen = _nearest(_middle(source), triangles, boxes, everything, limit)[0]
        seen = max(seen, _greatest_nearest(source, triangles, boxes, everything, limit))
        limit = max(limit, seen)
    limit *= LOOSE * LOOSE
    for source in sources:
        top = push(stack, 0, source, 0)
        while top > 0:
            top -= 1
            size, depth = stack.sizes[top], stack.depths[top]
            piece[:size] = stack.corners[top, :size]
            given = everything if depth == 0 else kept[depth - 1, : counts[depth - 1]]
            counts[depth], _, square = _keep_near(piece[:size], triangles, boxes, given, kept[depth])
            near = kept[depth, : counts[depth]]
            if square > limit:
                seen = _greatest_nearest(piece[:size], triangles, boxes, near, limit / (LOOSE * LOOSE))
                limit = max(limit, seen * LOOSE * LOOSE)
            if square <= limit or depth == DEPTH:
                bound = max(bound, square)
            else:
                found = _nearest(_middle(piece[:size]), triangles, boxes, near, 0.0)[1]
                top = _divide(stack, top, piece[:size], triangles[found], limit)
    return float(np.sqrt(bound))


@kernel
def _chosen(piece: Floats, triangles: Floats, near: Ints, chosen: Ints, limit: float) -> bool:
    """Whether one of the triangles near a piece that were chosen already is near all of it."""
    found = False
    for index in near:
        if chosen[index] and _corner_square(piece, triangles[index], limit) <= limit:
            found = True
            break
    return found


@kernel
def near_pairs(sources: Floats, triangles: Floats, bound: float) -> Ints:
    """Choose triangles so that every point of every source is within a bound of one chosen for it.

    Parameters
    ----------
    sources, triangles : (N, 3, 3), (M, 3, 3) float64
        Corners, grid steps; M is 1 or more.
    bound : float
        Grid steps; that of `bound_distance` or more.

    Returns
    -------
    (K, 2) int64
        Source and triangle, each pair once, in the order of the sources.
    """
    boxes = boxes_of(triangles)
    everything = np.arange(len(triangles))
    kept = np.empty((DEPTH + 1, len(triangles)), np.int64)
    counts = np.zeros(DEPTH + 1, np.int64)
    chosen = np.zeros(len(triangles), np.bool_)
    stack = _new_stack()
    piece = np.empty((CORNERS, 3))
    limit = bound * bound * (1 + 2.0**-48)  # the square of a rounded root may be the smaller one
    pairs = np.empty((2 * len(sources) + 16, 2), np.int64)
    count = 0
    for number in range(len(sources)):
        first = count
        top = push(stack, 0, sources[number], 0)
        while top > 0:
            top -= 1
            size, depth = stack.sizes[top], stack.depths[top]
            piece[:size] = stack.corners[top, :size]
            given = everything if depth == 0 else kept[depth - 1, : counts[depth - 1]]
            if count > first and _chosen(piece[:size], triangles, given, chosen, limit):
                continue
            counts[depth], nearest, square = _keep_near(piece[:size], triangles, boxes, given, kept[depth])
            if square > limit and depth < DEPTH:
                near = kept[depth, : counts[depth]]
                found = _nearest(_middle(piece[:size]), triangles, boxes, near, 0.0)[1]
                top = _divide(stack, top, piece[:size], triangles[found], limit)
                continue
            if chosen[nearest]:
                continue
            if count == len(pairs):
                longer = np.empty((2 * count, 2), np.int64)
                longer[:count] = pairs
                pairs = longer
            pairs[count, 0], pairs[count, 1] = number, nearest
            chosen[nearest] = True
            count += 1
        for i in range(first, count):
            chosen[pairs[i, 1]] = False
    return pairs[:count]
