"""The one form of a face: the least of its three rotations, faces without area included."""

from __future__ import annotations

from itertools import product

import numpy as np

from tilesnav_ref.packet.state import is_turned
from tilesnav_ref.stream.levels import smallest_first

POINTS = list(product((-1, 0), (0, 5), (-2, 3)))
FACES = np.array(list(product(POINTS, repeat=3)), np.int32)


def rotations(face: list[list[int]]) -> list[list[list[int]]]:
    return [face[k:] + face[:k] for k in range(3)]


def test_corners_are_turned_to_the_least_rotation() -> None:
    assert smallest_first(FACES).tolist() == [min(rotations(face)) for face in FACES.tolist()]


def test_only_the_least_rotation_counts_as_turned() -> None:
    assert is_turned(FACES).tolist() == [face == min(rotations(face)) for face in FACES.tolist()]


def test_coordinates_at_the_limit_are_compared() -> None:
    edge = 2**23 - 1
    face = [[edge, edge, edge], [edge, -edge, edge], [-edge, edge, -edge]]
    assert smallest_first(np.array([face], np.int32)).tolist() == [min(rotations(face))]
    assert is_turned(np.array(rotations(face), np.int32)).tolist() == [False, False, True]
