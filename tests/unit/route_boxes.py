"""Complexes of unit boxes, some of them left out, as gates and places."""

from __future__ import annotations

import itertools
from collections.abc import Set as AbstractSet

import numpy as np

from tilesnav_ref.stream.gates import Gates
from tilesnav_ref.stream.places import Places

SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
NORMALS = np.concatenate((-np.eye(3), np.eye(3)))


def boxes(shape: tuple[int, int, int], gone: AbstractSet[int] = frozenset()) -> tuple[Gates, Places]:
    """Unit boxes of a block, numbered without those that are gone (by their numbers in the whole block)."""
    corners = [c for k, c in enumerate(itertools.product(*map(range, shape))) if k not in gone]
    number = {corner: cell for cell, corner in enumerate(corners)}
    pairs, vertices = [], []
    for corner, cell in number.items():
        for axis in range(3):
            beyond = tuple(c + (k == axis) for k, c in enumerate(corner))
            if beyond in number:
                pairs.append((cell, number[beyond]))
                vertices.append([np.insert(np.array(s), axis, 1.0) + corner for s in SQUARE])
    planes = [
        np.column_stack((NORMALS, np.concatenate((corner, -np.array(corner) - 1.0)))) for corner in corners
    ]
    gates = Gates(
        np.array(pairs, np.int64).reshape(-1, 2),
        np.arange(len(pairs) + 1) * 4,
        np.array(vertices, np.float64).reshape(-1, 3),
        len(corners),
    )
    return gates, Places(np.array(planes))
