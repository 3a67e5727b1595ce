"""Prisms by their eight corners alone, to compare rows of eight numbers with."""

from __future__ import annotations

from itertools import permutations, product
from typing import Any

import numpy as np
from hypothesis import strategies as st

from tilesnav_validator import prisms

Corners = list[list[int]]

SHAPES = {shape: axes for shape, axes in enumerate(prisms.AXES) if shape}


def corners_of(row: Any, shape: int) -> Corners:
    """Corners in the order of their bits, by the definition of a region."""
    numbers = [int(x) for x in row]
    u, v = SHAPES.get(shape, (0, 1))
    result = []
    for z, y, x in product((0, 1), repeat=3):
        side = (x, y, z)
        corner = [numbers[axis + 3 * side[axis]] for axis in range(3)]
        if shape and side[u]:
            corner[v] = numbers[6 + side[v]]
        result.append(corner)
    return result


def halves(corners: Corners, axis: int) -> tuple[Corners, Corners] | None:
    """Corners above and below the middles of the four edges along an axis; None where a middle that has to be
    is not an integer, or is an end of its edge."""
    above, below = [list(c) for c in corners], [list(c) for c in corners]
    for low in (i for i in range(8) if not i >> axis & 1):
        one, other = corners[low], corners[low | 1 << axis]
        slanted = any(one[k] != other[k] for k in range(3) if k != axis)
        if slanted and any((a + b) % 2 for a, b in zip(one, other, strict=True)):
            return None
        middle = [(a + b) // 2 for a, b in zip(one, other, strict=True)]
        if middle in (one, other):
            return None
        above[low], below[low | 1 << axis] = middle, list(middle)
    return above, below


def sides(corners: Corners) -> list[tuple[Any, Any]]:
    """Inward normals of the six facets of a prism, whole numbers, each with a corner on it."""
    middle = np.sum(corners, axis=0)
    found = []
    for axis, side in product(range(3), (0, 1)):
        a, b, c = [np.array(corners[i]) for i in range(8) if i >> axis & 1 == side][:3]
        normal = np.cross(b - a, c - a)
        found.append((normal if normal @ (middle - 8 * a) > 0 else -normal, a))
    return found


@st.composite
def rows(draw: st.DrawFn, size: int = 4, step: int = 1) -> tuple[tuple[int, ...], int]:
    """A row of eight numbers, multiples of ``step``, that slants, and its shape."""
    number = st.integers(-size, size)
    pair = st.tuples(number, number).filter(lambda p: p[0] < p[1])
    bounds = [draw(pair) for _ in range(3)]
    shape = draw(st.sampled_from(sorted(SHAPES)))
    p, q = draw(pair.filter(lambda p: p != bounds[SHAPES[shape][1]]))
    row = (*(low for low, _ in bounds), *(high for _, high in bounds), p, q)
    return tuple(step * value for value in row), shape


assert sorted(SHAPES.values()) == sorted(permutations(range(3), 2))
