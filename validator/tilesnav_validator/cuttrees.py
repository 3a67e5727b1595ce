"""Trees of cuts: from the codes of a certificate to the parts of its leaves."""

from __future__ import annotations

from collections.abc import Iterator

from tilesnav_validator.prisms import AXES

LEAF = 0
EDGES = (4, 5, 6)

Numbers = tuple[int, ...]
"""A prism (8, see prisms.py), or the three corners of a triangle (9)."""


class TreeError(ValueError):
    """The codes are no tree."""


def leaves(
    codes: bytes, region: Numbers, shape: int, triangle: Numbers
) -> Iterator[tuple[Numbers, Numbers]]:
    """Yield the parts of the leaves of one tree, in order.

    Parameters
    ----------
    codes : bytes
        The cuts in preorder.
    region : tuple of eight int
        The region, with p and q of a box filled in.
    shape : int
        Which axes it slants along.
    triangle : tuple of nine int
        Corners of the target; empty where there are several targets, whose box is not cut.

    Raises
    ------
    TreeError
        When the codes are too many or too few, or a cut does not divide.

    Notes
    -----
    A cut across an axis leaves at least one unit on both sides and halves, rounding up at most, the greatest
    width along that axis; a cut across the run axis makes no width along the slanted one greater. A cut of a
    triangle of integers halves its doubled area. So no tree is deeper than 90 + 61 cuts, and the stack never
    holds more than 152 parts.
    """
    pending = [(region, triangle)]
    for index, code in enumerate(codes):
        if not pending:
            raise TreeError(f"code {index}: {len(codes) - index} codes after the last leaf")
        part, triangle = pending.pop()
        if code == LEAF:
            yield part, triangle
        elif code < EDGES[0] and triangle:
            above, below = _divided(part, code - 1, AXES[shape], index)
            pending += (below, triangle), (above, triangle)
        elif code in EDGES and triangle:
            first, second = _halved(triangle, code - EDGES[0], index)
            pending += (part, second), (part, first)
        else:
            raise TreeError(f"code {index}: {code}, with {'one target' if triangle else 'several targets'}")
    if pending:
        raise TreeError(f"after {len(codes)} codes {len(pending)} parts are without a leaf")


def _divided(part: Numbers, axis: int, axes: tuple[int, int], index: int) -> tuple[Numbers, Numbers]:
    """The parts of a prism above and below the middle of an axis."""
    u, v = axes
    middle = (part[axis] + part[axis + 3]) // 2
    above, below = list(part), list(part)
    above[axis] = below[axis + 3] = middle
    narrow = middle == part[axis]
    if axis == v:
        above[6] = below[7] = (part[6] + part[7]) // 2
        narrow = narrow or above[6] == part[6]
    elif axis == u and (part[v] != part[6] or part[v + 3] != part[7]):
        sums = part[u] + part[u + 3], part[v] + part[6], part[v + 3] + part[7]
        if any(value % 2 for value in sums):
            raise TreeError(f"code {index}: a cut across axis {u} through a middle that is not an integer")
        above[v] = below[6] = sums[1] // 2
        above[v + 3] = below[7] = sums[2] // 2
    if narrow:
        raise TreeError(f"code {index}: a cut across axis {axis} of a part that is one unit wide")
    return tuple(above), tuple(below)


def _halved(triangle: Numbers, edge: int, index: int) -> tuple[Numbers, Numbers]:
    """The halves of a triangle on either side of the middle of an edge: that which keeps the start of the
    edge comes first."""
    start, end = 3 * edge, 3 * ((edge + 1) % 3)
    sums = [triangle[start + k] + triangle[end + k] for k in range(3)]
    if any(value % 2 for value in sums):
        raise TreeError(f"code {index}: the middle of edge {edge} is not an integer")
    middle = tuple(value // 2 for value in sums)
    first = (*triangle[:end], *middle, *triangle[end + 3 :])
    second = (*triangle[:start], *middle, *triangle[start + 3 :])
    return first, second
