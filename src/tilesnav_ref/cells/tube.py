"""Distances from a line of segments to boxes and to points.

Notes
-----
The distance from a box is convex along a segment, so that a golden section search finds its least. It ends at
2**-40 of the segment, so below 2**-15 grid steps, and 2**-10 steps are added to the radius: a box that
touches the tube is never left out, and one that is kept is nearer than the radius and a thousandth of a step.

References
----------
J. Kiefer, "Sequential minimax search for a maximum", Proceedings of the AMS 4(3), 1953.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

_GOLDEN = (5.0**0.5 - 1.0) / 2.0
_ROUNDS = 58
"""0.618 ** 58 is below 2**-40."""
_ALLOWANCE = 2.0**-10
"""Grid steps."""


def _distances(
    start: NDArray[np.float64],
    along: NDArray[np.float64],
    share: NDArray[np.float64],
    boxes: NDArray[np.int64],
) -> NDArray[np.float64]:
    places = start + share[:, None] * along
    return np.asarray(
        np.linalg.norm(np.maximum(np.maximum(boxes[:, 0] - places, places - boxes[:, 1]), 0.0), axis=1)
    )


def segment_distances(
    start: NDArray[np.float64], end: NDArray[np.float64], boxes: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Distance of a segment from each box (B, 2, 3); (B,) in the unit of the coordinates."""
    along = end - start
    low, high = np.zeros(len(boxes)), np.ones(len(boxes))
    for _ in range(_ROUNDS):
        inner = high - _GOLDEN * (high - low)
        outer = low + _GOLDEN * (high - low)
        nearer = _distances(start, along, inner, boxes) <= _distances(start, along, outer, boxes)
        low, high = np.where(nearer, low, inner), np.where(nearer, outer, high)
    return _distances(start, along, (low + high) / 2.0, boxes)


def boxes_in_tube(boxes: NDArray[np.int64], line: NDArray[np.float64], radius: float) -> NDArray[np.bool_]:
    """Which boxes (B, 2, 3) are within a radius of a line (P, 3); (B,) bool."""
    result = np.zeros(len(boxes), np.bool_)
    for start, end in pairwise(line):
        near = np.minimum(start, end) - 2.0 * radius, np.maximum(start, end) + 2.0 * radius
        asked = np.flatnonzero(~result & np.all((boxes[:, 1] >= near[0]) & (boxes[:, 0] <= near[1]), axis=1))
        result[asked] = segment_distances(start, end, boxes[asked]) <= radius + _ALLOWANCE
    return result


def points_in_tube(points: NDArray[np.int64], line: NDArray[np.float64], radius: float) -> NDArray[np.bool_]:
    """Which points (P, 3) are within a radius of a line; (P,) bool."""
    result = np.zeros(len(points), np.bool_)
    for start, end in pairwise(line):
        along = end - start
        length = float(along @ along)
        share = (
            np.clip(((points - start) @ along) / length, 0.0, 1.0) if length > 0.0 else np.zeros(len(points))
        )
        result |= np.linalg.norm(points - (start + share[:, None] * along), axis=1) <= radius
    return result
