"""Deltas of a map small enough to work out by hand."""

from __future__ import annotations

import hashlib
from itertools import pairwise

import numpy as np
import pytest
from test_tileset_small_map import small_map

from tilesnav_ref.stream.errors import DeltaError
from tilesnav_ref.stream.state import Delta, State, apply_delta
from tilesnav_ref.tileset.delta import canonical_state, state_digests

OBJECT_OFFSETS = np.array([0, 2, 4, 5])


def _rows(offsets: np.ndarray, values: np.ndarray) -> list[list[int]]:
    return [values[a:b].tolist() for a, b in pairwise(offsets)]


def test_deltas_of_the_small_map() -> None:
    # Portals in order: 0 -> 1, 1 -> 0, 1 -> 2, 2 -> 1; sets {0 1 2}, {0 2 3 4}, {4}.
    deltas = small_map().deltas
    assert _rows(deltas.entered_offsets, deltas.entered) == [[3, 4], [1], [], [0, 2, 3]]
    assert _rows(deltas.left_offsets, deltas.left) == [[1], [3, 4], [0, 2, 3], []]
    # Object 0 keeps code 2 between cells 0 and 1, object 1 changes 3 -> 1, object 2 keeps 5 between 1 and 2.
    assert _rows(deltas.switch_offsets, deltas.switch_objects) == [[1, 2], [1], [], [0, 1]]
    assert _rows(deltas.switch_offsets, deltas.switch_codes) == [[1, 5], [3], [], [2, 1]]


def test_types_are_those_of_the_file() -> None:
    deltas = small_map().deltas
    assert (deltas.entered.dtype, deltas.left.dtype, deltas.switch_objects.dtype) == (np.uint32,) * 3
    assert deltas.switch_codes.dtype == np.uint8


def test_canonical_bytes_by_hand() -> None:
    one = small_map()
    by_hand = bytes.fromhex("03000000 00000000 01000000 02000000 02000000 00000000 01000000 02 03")
    assert canonical_state(one.pvs, one.lod, 0) == by_hand
    state = State(
        faces=np.array([0, 1, 2], dtype=np.uint32),
        objects=np.array([0, 1], dtype=np.uint32),
        codes=np.array([2, 3], dtype=np.uint8),
    )
    assert state.canonical_bytes() == by_hand
    assert state.digest() == hashlib.sha256(by_hand).digest()
    digests = state_digests(one.pvs, one.lod)
    assert digests.shape == (3, 32)
    assert digests[0].tobytes() == hashlib.sha256(by_hand).digest()
    assert len({d.tobytes() for d in digests}) == 3


def test_digest_of_an_empty_state() -> None:
    empty = State(np.empty(0, np.uint32), np.empty(0, np.uint32), np.empty(0, np.uint8))
    assert empty.canonical_bytes() == bytes(8)


def _state(faces: list[int], objects: list[int], codes: list[int]) -> State:
    return State(np.array(faces, np.uint32), np.array(objects, np.uint32), np.array(codes, np.uint8))


def _delta(entered: list[int], left: list[int], objects: list[int], codes: list[int]) -> Delta:
    return Delta(*(np.array(x, np.uint32) for x in (entered, left, objects)), np.array(codes, np.uint8))


def test_applying_drops_objects_without_a_face() -> None:
    after = apply_delta(_state([0, 2], [0, 1], [7, 8]), _delta([4], [2], [2], [9]), OBJECT_OFFSETS)
    assert (after.faces.tolist(), after.objects.tolist(), after.codes.tolist()) == ([0, 4], [0, 2], [7, 9])


@pytest.mark.parametrize(
    ("delta", "message"),
    [
        (_delta([], [1], [], []), "leaves that the state does not hold"),
        (_delta([2], [], [], []), "enters that the state holds already"),
        (_delta([4], [], [], []), "without a level code"),
    ],
)
def test_a_delta_of_another_portal_is_refused(delta: Delta, message: str) -> None:
    with pytest.raises(DeltaError, match=message):
        apply_delta(_state([0, 2], [0, 1], [7, 8]), delta, OBJECT_OFFSETS)
