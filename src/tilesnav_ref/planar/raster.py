"""Points drawn into an image, the nearer ones over the farther ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LARGEST_DOT = 6
"""Pixels."""
BLOCK = 12
"""Pixels: the points of half of the squares of this edge that have any should fill them."""
FULL = 2.0
"""Times the mean distance of points: they lie in lines rather than evenly."""
POINTS_DRAWN = 2_000_000
"""Of more points evenly chosen ones are drawn; an image has about as many pixels."""


@dataclass(frozen=True)
class Image:
    """A picture of points and where it lies."""

    pixels: NDArray[np.float64]
    """(H, W, 3) red, green, blue from 0 to 1; the first row is the highest."""
    extent: tuple[float, float, float, float]
    """Left, right, bottom, top in metres."""


def rasterise(
    flat: NDArray[np.float64], depth: NDArray[np.float64], colours: NDArray[np.float64], width: int
) -> Image:
    """Draw points as squares that are large enough to close the gaps between them, where they are even.

    Parameters
    ----------
    flat : (N, 2) float64
        Metres to the right and up; one point or more.
    depth : (N,) float64
        Larger is farther.
    colours : (N, 3) float64
    width : int
        Pixels along the longer side.
    """
    step = -(-len(flat) // POINTS_DRAWN)
    flat, depth, colours = flat[::step], depth[::step], colours[::step]
    low, high = flat.min(axis=0), flat.max(axis=0)
    pitch = max(float((high - low).max()) / width, 1e-6)
    columns, rows = (np.ceil((high - low) / pitch).astype(np.int64) + 1).tolist()
    x, y = np.floor((flat - low) / pitch).astype(np.int64).T
    _, counts = np.unique(y // BLOCK * columns + x // BLOCK, return_counts=True)
    dot = min(max(round(FULL * BLOCK / float(np.median(counts)) ** 0.5), 1), LARGEST_DOT)
    far_first = np.argsort(-depth, kind="stable")
    nearest = np.full((rows, columns), -1, np.int64)
    for dx in range(dot):
        for dy in range(dot):
            down = np.minimum(y + dy - dot // 2, rows - 1).clip(0)
            right = np.minimum(x + dx - dot // 2, columns - 1).clip(0)
            layer = np.full((rows, columns), -1, np.int64)
            layer[down[far_first], right[far_first]] = np.arange(len(flat))  # the last one written stays
            np.maximum(nearest, layer, out=nearest)
    pixels = np.ones((rows, columns, 3))
    drawn = nearest >= 0
    pixels[drawn] = colours[far_first[nearest[drawn]]]
    extent = (low[0], low[0] + columns * pitch, low[1], low[1] + rows * pitch)
    return Image(pixels[::-1], extent)
