"""Trees of cuts: from the codes of a certificate to the parts of its leaves."""

from __future__ import annotations

from collections.abc import Iterator

LEAF = 0
EDGES = (4, 5, 6)

Numbers = tuple[int, ...]
"""Lower and upper corner of a box (6), or the three corners of a triangle (9)."""


class TreeError(ValueError):
    """The codes are no tree."""


def leaves(codes: bytes, box: Numbers, triangle: Numbers) -> Iterator[tuple[Numbers, Numbers]]:
    """Yield the parts of the leaves of one tree, in order.

    Parameters
    ----------
    codes : bytes
        The cuts in preorder.
    box : tuple of six int
        Lower and upper corner of the region.
    triangle : tuple of nine int
        Corners of the target; empty where there are several targets, whose box is not cut.

    Raises
    ------
    TreeError
        When the codes are too many or too few, or a cut does not divide.

    Notes
    -----
    A cut leaves at least one unit on both sides of a box, and halves the doubled area of a triangle of
    integers. So no tree is deeper than 90 + 61 cuts, and the stack never holds more than 152 parts.
    """
    pending = [(box, triangle)]
    for index, code in enumerate(codes):
        if not pending:
            raise TreeError(f"code {index}: {len(codes) - index} codes after the last leaf")
        box, triangle = pending.pop()
        if code == LEAF:
            yield box, triangle
        elif code < EDGES[0] and triangle:
            above, below = _divided(box, code - 1, index)
            pending += (below, triangle), (above, triangle)
        elif code in EDGES and triangle:
            first, second = _halved(triangle, code - EDGES[0], index)
            pending += (box, second), (box, first)
        else:
            raise TreeError(f"code {index}: {code}, with {'one target' if triangle else 'several targets'}")
    if pending:
        raise TreeError(f"after {len(codes)} codes {len(pending)} parts are without a leaf")


def _divided(box: Numbers, axis: int, index: int) -> tuple[Numbers, Numbers]:
    """The parts of a box above and below the middle of an axis."""
    middle = (box[axis] + box[axis + 3]) // 2
    if middle == box[axis]:
        raise TreeError(f"code {index}: a cut across axis {axis} of a box one unit wide")
    above = (*box[:axis], middle, *box[axis + 1 :])
    below = (*box[: axis + 3], middle, *box[axis + 4 :])
    return above, below


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
