"""The best prisms of a tile: free slices between the faces in it, seen along one axis.

Notes
-----
The polygons of the faces in a tile are projected along axis w. For a few directions in the plane of u and v
(along u, and along the longest edges) their shadows on a line across that direction leave gaps. A gap says
which polygons lie below and which above; two cut lines over the whole length of the tile are then fitted to
them, and give a prism. Prisms of one direction lie above each other, so a tile with a thin wall gives two.

References
----------
The cut lines are those of the greedy decomposition into six planes; gaps by marks on a line of bins are the
usual way to find them without sorting.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.meeting import STEEPEST
from tilesnav_ref.cells.prisms import H0, H1, L0, L1, U0, U1, W0, W1, WIDTH, U, V, W
from tilesnav_ref.cells.tangents import lowest_line, pinned_line
from tilesnav_ref.kernels import kernel

MOST = 4
"""Most prisms of one tile."""
_BINS = 64
"""Marks across a tile: gaps below a bin or two, a thirtieth of the tile, are not seen before it is cut."""
_ANGLES = 24
"""Directions of edges that are told apart, over 120 degrees."""
_LOOKED_AT = 1.75
"""Largest slope of edges that are looked at; tan(60 degrees), and a little more."""
_FLAT = 1.0 / 48.0
"""A slant that gains less than this share of the prism is left out: flat sides make more portals."""


@kernel
def write_directions(
    polygons: tuple[NDArray[np.float64], NDArray[np.int64], int, int],
    axes: tuple[int, int],
    sums: NDArray[np.float64],
) -> None:
    """Length and length times slope of the projected edges by angle, to sums (2, _ANGLES)."""
    vertices, counts, start, end = polygons
    u, v = axes
    sums[:] = 0.0
    for s in range(start, end):
        for a in range(counts[s]):
            b = a + 1 if a + 1 < counts[s] else 0
            along, across = vertices[s, b, u] - vertices[s, a, u], vertices[s, b, v] - vertices[s, a, v]
            if abs(across) >= _LOOKED_AT * abs(along):
                continue
            slope = across / along
            if slope == 0.0:
                continue
            place = int((math.atan(slope) / math.pi * 3.0 + 1.0) / 2.0 * _ANGLES)
            length = math.sqrt(along * along + across * across)
            sums[0, place] += length
            sums[1, place] += length * slope


@kernel
def _mark(
    polygons: tuple[NDArray[np.float64], NDArray[np.int64], int, int],
    axes: tuple[int, int],
    line: tuple[float, float, float, float],
    middles: NDArray[np.float64],
    bins: NDArray[np.int64],
) -> None:
    """Count the polygons that begin or end in every bin; line = middle of u, slope, first value, bins a
    unit."""
    vertices, counts, start, end = polygons
    u, v = axes
    at, slope, first, scale = line
    bins[:] = 0
    for s in range(start, end):
        low, high = np.inf, -np.inf
        for a in range(counts[s]):
            value = vertices[s, a, v] - slope * (vertices[s, a, u] - at)
            low, high = min(low, value), max(high, value)
        middles[s - start] = (low + high) / 2.0
        i, j = int((low - first) * scale), int((high - first) * scale)
        bins[min(max(i, 0), _BINS)] += 1
        bins[min(max(j + 1, 0), _BINS)] -= 1


@kernel
def _collect(
    polygons: tuple[NDArray[np.float64], NDArray[np.int64], int, int],
    axes: tuple[int, int],
    split: tuple[NDArray[np.float64], float, float],
    points: NDArray[np.float64],
) -> int:
    """Points of the polygons on one side of a gap: sign * (middle - gap) < 0; v is turned by the sign."""
    vertices, counts, start, end = polygons
    u, v = axes
    middles, gap, sign = split
    count = 0
    for s in range(start, end):
        if sign * (middles[s - start] - gap) < 0.0:
            for a in range(counts[s]):
                points[0, count], points[1, count] = vertices[s, a, u], sign * vertices[s, a, v]
                count += 1
    return count


@kernel
def _fit_side(
    points: NDArray[np.float64], ends: tuple[float, float], floor: float, clearance: float, size: float
) -> tuple[float, float]:
    """The lowest line, or a flat one where that costs little; ``size`` is the height of the tile."""
    us, vs = points[0], points[1]
    y0, y1 = lowest_line((us, vs), ends, floor, clearance)
    flat = floor
    for p in range(len(vs)):
        flat = max(flat, vs[p] + clearance)
    if flat - (y0 + y1) / 2.0 <= _FLAT * size:
        return flat, flat
    return y0, y1


@kernel
def _fit_below(
    points: NDArray[np.float64],
    ends: tuple[float, float],
    roof: tuple[float, float],
    limits: tuple[float, float, float],
) -> tuple[float, float]:
    """Lower line under a roof; inf where there is none. ``limits`` = floor, clearance, least width."""
    floor, clearance, least = limits
    y0, y1 = _fit_side(points, ends, floor, clearance, max(roof[0], roof[1]) - floor)
    if y0 > roof[0] - least:
        y0 = roof[0] - least
        y1 = pinned_line((points[0], points[1]), (ends[0], y0, ends[1]), floor, clearance)
    elif y1 > roof[1] - least:
        y1 = roof[1] - least
        y0 = pinned_line((points[0], points[1]), (ends[1], y1, ends[0]), floor, clearance)
    if y0 > roof[0] - least or y1 > roof[1] - least or y0 < floor:
        return np.inf, np.inf
    return y0, y1


@kernel
def _write_prism(
    tile: NDArray[np.int64],
    axes: tuple[int, int, int],
    lines: tuple[float, float, float, float],
    sizes: tuple[int, int],
    row: NDArray[np.int64],
) -> bool:
    """Round the lines towards the inside; False where too little is left. ``sizes``: least mean and end
    width."""
    u, v, w = axes
    row[U], row[V], row[W] = u, v, w
    row[U0], row[U1], row[W0], row[W1] = tile[0, u], tile[1, u], tile[0, w], tile[1, w]
    # rounded ends turn a slanted line a little, and its move by the clearance is rounded once more
    low_margin = 0.0 if lines[0] == lines[1] else 2.0
    high_margin = 0.0 if lines[2] == lines[3] else 2.0
    for side in range(2):
        row[L0 + side] = max(math.ceil(lines[side] + low_margin - 1e-7), tile[0, v])
        row[H0 + side] = min(math.floor(lines[2 + side] - high_margin + 1e-7), tile[1, v])
    run = STEEPEST * (row[U1] - row[U0])
    if abs(row[L1] - row[L0]) > run or abs(row[H1] - row[H0]) > run:
        return False
    at_start, at_end = row[H0] - row[L0], row[H1] - row[L1]
    return bool(min(at_start, at_end) >= sizes[1] and at_start + at_end >= 2 * sizes[0])


@kernel
def count_inside(samples: NDArray[np.float64], row: NDArray[np.int64]) -> int:
    """Number of samples (S, 3) in a prism."""
    u, v, w = row[U], row[V], row[W]
    run = 1.0 / (row[U1] - row[U0])
    low, high = (row[L1] - row[L0]) * run, (row[H1] - row[H0]) * run
    count = 0
    for s in range(len(samples)):
        along = samples[s, u] - row[U0]
        count += (
            (samples[s, u] >= row[U0])
            and (samples[s, u] <= row[U1])
            and (samples[s, w] >= row[W0])
            and (samples[s, w] <= row[W1])
            and (samples[s, v] >= row[L0] + low * along)
            and (samples[s, v] <= row[H0] + high * along)
        )
    return count


@kernel
def _slices_of_direction(
    tile: NDArray[np.int64],
    polygons: tuple[NDArray[np.float64], NDArray[np.int64], int, int],
    view: tuple[int, int, int, float],
    sizes: tuple[int, int, int],
    room: tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64], NDArray[np.int64]],
) -> int:
    """Write the prisms between gaps of one direction to room[3]; returns how many. ``view`` = u, v, w,
    slope."""
    u, v, w, slope = view
    middles, bins, points, rows = room
    clearance = float(sizes[2])
    ends = (float(tile[0, u]), float(tile[1, u]))
    low, high = float(tile[0, v]), float(tile[1, v])
    half = abs(slope) * (ends[1] - ends[0]) / 2.0
    spread = clearance * math.sqrt(1.0 + slope * slope)
    first, scale = low - half - spread, _BINS / (high - low + 2.0 * (half + spread))
    _mark(polygons, (u, v), ((ends[0] + ends[1]) / 2.0, slope, first, scale), middles, bins)
    count, covered, b = 0, 0, 0
    needed = int(2.0 * spread * scale) + 1
    while b < _BINS and count < MOST:
        covered += bins[b]
        if covered > 0:
            b += 1
            continue
        start = b
        while b + 1 < _BINS and bins[b + 1] == 0:
            b += 1
        b += 1
        if b - start < needed:
            continue
        gap = first + (start + b) / 2.0 / scale
        above = _collect(polygons, (u, v), (middles, gap, -1.0), points)
        h0, h1 = _fit_side(points[:, :above], ends, -high, clearance, high - low)
        below = _collect(polygons, (u, v), (middles, gap, 1.0), points)
        l0, l1 = _fit_below(points[:, :below], ends, (-h0, -h1), (low, clearance, float(sizes[1])))
        if l0 == np.inf:
            continue
        good = _write_prism(tile, (u, v, w), (l0, l1, -h0, -h1), (sizes[0], sizes[1]), rows[count])
        if good and (
            count == 0 or (rows[count - 1, H0] <= rows[count, L0] and rows[count - 1, H1] <= rows[count, L1])
        ):
            count += 1
    return count


@kernel
def _slopes(sums: NDArray[np.float64], slopes: NDArray[np.float64]) -> int:
    """The slopes to try: zero and those of the two longest groups of edges."""
    slopes[0], count = 0.0, 1
    for _ in range(2):
        best = np.argmax(sums[0])
        if sums[0, best] > 0.0:
            slopes[count] = sums[1, best] / sums[0, best]
            sums[0, best] = 0.0
            count += 1
    return count


@kernel
def best_slices(
    tile: NDArray[np.int64],
    polygons: tuple[NDArray[np.float64], NDArray[np.int64], int, int],
    samples: NDArray[np.float64],
    sizes: tuple[int, int, int, float],
    best: NDArray[np.int64],
) -> tuple[int, float]:
    """The prisms of a tile that hold most of its samples.

    Parameters
    ----------
    tile
        (2, 3) grid.
    polygons
        (P, 9, 3) and (P,) numbers of vertices, and the span of those in the inflated tile.
    samples
        (S, 3) points that are worth holding.
    sizes
        Least mean and least end width across v and clearance, grid steps; samples that a prism must pay for.
    best
        (MOST, 11) room for the prisms.

    Returns
    -------
    count, value
        Number of prisms; samples in them less what they pay.
    """
    start, end = polygons[2], polygons[3]
    total, price = 0, sizes[3]
    if start == end:
        best[0, U], best[0, V], best[0, W] = 0, 1, 2
        best[0, U0], best[0, U1], best[0, W0], best[0, W1] = tile[0, 0], tile[1, 0], tile[0, 2], tile[1, 2]
        best[0, L0], best[0, L1], best[0, H0], best[0, H1] = tile[0, 1], tile[0, 1], tile[1, 1], tile[1, 1]
        return 1, len(samples) - price
    for s in range(start, end):
        total += polygons[1][s]
    rows, slopes = np.empty((MOST, WIDTH), np.int64), np.empty(3)
    room = (np.empty(end - start), np.empty(_BINS + 1, np.int64), np.empty((2, total)), rows)
    sums = np.empty((2, _ANGLES + 1))
    best_count, best_value = 0, 0.0
    for k in range(6):
        u, v, w = k % 3, (k + 1 + k // 3) % 3, (k + 2 - k // 3) % 3
        write_directions(polygons, (u, v), sums)
        for d in range(_slopes(sums, slopes)):
            count = _slices_of_direction(
                tile, polygons, (u, v, w, slopes[d]), (sizes[0], sizes[1], sizes[2]), room
            )
            kept, value = 0, 0.0
            for r in range(count):
                gain = count_inside(samples, rows[r]) - price
                if gain > 0.0:
                    value += gain
                    rows[kept] = rows[r]
                    kept += 1
            if value > best_value:
                best_count, best_value = kept, value
                best[:kept] = rows[:kept]
    return best_count, best_value
