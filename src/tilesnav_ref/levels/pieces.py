"""Convex pieces of triangles, and how they are cut."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CORNERS = 24
"""Corners of a piece at most."""


class Stack(NamedTuple):
    """Pieces that wait."""

    corners: Floats
    """(N, CORNERS, 3)."""
    sizes: Ints
    """(N,) number of corners."""
    depths: Ints
    """(N,) number of cuts that a piece comes from."""


@kernel
def heights(piece: Floats, origin: Floats, normal: Floats, out: Floats) -> tuple[float, float]:
    """Write the products of a normal and the corners less an origin; return the least and the greatest."""
    low, high = np.inf, -np.inf
    for i in range(len(piece)):
        height = 0.0
        for k in range(3):
            height += (piece[i, k] - origin[k]) * normal[k]
        out[i] = height
        low, high = min(low, height), max(high, height)
    return low, high


@kernel
def cut(piece: Floats, values: Floats, sign: float, out: Floats) -> int:
    """Write the part of a convex piece where sign * value is 0 or more; return the number of its corners.

    Notes
    -----
    Both sides of a cut get the same corners on it, computed from the same end points in the same order, so
    that nothing is lost between them.
    """
    count = 0
    size = len(piece)
    for i in range(size):
        j = i + 1 if i + 1 < size else 0
        a, b = values[i], values[j]
        if sign * a >= 0:
            for k in range(3):
                out[count, k] = piece[i, k]
            count += 1
        if (a > 0 and b < 0) or (a < 0 and b > 0):
            share = a / (a - b)
            for k in range(3):
                out[count, k] = piece[i, k] + share * (piece[j, k] - piece[i, k])
            count += 1
    return count


@kernel
def push(stack: Stack, top: int, piece: Floats, depth: int) -> int:
    """Put a piece on the stack; its neighbours cover one of fewer than three corners, which has no area."""
    size = len(piece)
    if size < 3:
        return top
    for i in range(size):
        for k in range(3):
            stack.corners[top, i, k] = piece[i, k]
    stack.sizes[top] = size
    stack.depths[top] = depth
    return top + 1


@kernel
def halve(stack: Stack, top: int, piece: Floats, depth: int) -> int:
    """Put the halves of a piece on the stack, cut across its longest diagonal or side."""
    longest, first, second = -1.0, 0, 0
    for i in range(len(piece)):
        for j in range(i):
            square = 0.0
            for k in range(3):
                square += (piece[i, k] - piece[j, k]) ** 2
            if square > longest:
                longest, first, second = square, j, i
    values, part = np.empty(CORNERS), np.empty((CORNERS, 3))
    heights(piece, (piece[first] + piece[second]) / 2, piece[second] - piece[first], values)
    for sign in (1.0, -1.0):
        size = cut(piece, values[: len(piece)], sign, part)
        top = push(stack, top, part[:size], depth)
    return top
