"""Places on the curve and turned corners, against their definitions."""

from __future__ import annotations

from itertools import product

import numpy as np

from tilesnav_ref.morton import morton
from tilesnav_ref.packet.places import LIMIT, place_faces, turn_faces


def test_places_are_those_of_the_curve() -> None:
    rng = np.random.default_rng(2)
    corners = np.concatenate(
        (
            rng.integers(-LIMIT + 1, LIMIT, (200, 3, 3)),
            rng.integers(-20, 20, (200, 3, 3)),
            np.array(list(product((-LIMIT + 1, LIMIT - 1), repeat=3)))[:, None].repeat(3, axis=1),
        )
    )
    keys = np.empty(len(corners), np.int64)
    place_faces(corners, keys)
    assert keys.tolist() == morton(corners.sum(axis=1) // 3).tolist()
    x, y, z = ((corners[0].sum(axis=0) // 3 + LIMIT) >> 3).tolist()
    bits = [value >> k & 1 for k in reversed(range(21)) for value in (z, y, x)]
    assert keys[0] == int("".join(map(str, bits)), 2)


def test_faces_are_turned_to_the_least_rotation() -> None:
    points = list(product((0, 1), (-4, 2), (5, 6)))
    faces = [list(map(list, face)) for face in product(points, repeat=3)]
    turned = np.array(faces, np.int64)
    turn_faces(turned)
    assert turned.tolist() == [min(face[k:] + face[:k] for k in range(3)) for face in faces]
