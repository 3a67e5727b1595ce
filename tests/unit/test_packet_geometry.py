"""The body of packets: what goes in comes out, and what is not a body is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tilesnav_ref.packet.coder import (
    NUMBER_CONTEXTS,
    ONE,
    PATIENCE,
    SHARES,
    code_numbers,
    finish,
    is_finished,
    new_coder,
)
from tilesnav_ref.packet.geometry import decode_body, encode_body
from tilesnav_ref.packet.geometry_order import canonical
from tilesnav_ref.packet.model import Limits, ObjectFaces, PacketError

LIMIT = 1 << 23


def box(x: int, y: int, z: int, size: int = 4096) -> np.ndarray:
    """(12, 3, 3) faces of a cube."""
    quads = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
    faces = [(q[0], q[i], q[i + 1]) for q in quads for i in (1, 2)]
    corners = np.array([((v >> 2) & 1, (v >> 1) & 1, v & 1) for v in range(8)]) * size + (x, y, z)
    return corners[np.array(faces)]


def part(number: int, faces: list[int], corners: np.ndarray, level: int = 0, flags: int = 0) -> ObjectFaces:
    turned = canonical(np.asarray(corners, np.int32).reshape(-1, 3, 3))
    return ObjectFaces(number, level, flags, np.array(faces, np.uint32), turned)


def listed(parts: tuple[ObjectFaces, ...]) -> list[tuple[int, int, int, list[int], list[int]]]:
    return [(p.object, p.level, p.flags, p.faces.tolist(), p.corners.ravel().tolist()) for p in parts]


def some(number: int, keep: slice, level: int = 0, flags: int = 0) -> ObjectFaces:
    """Some of the faces of three boxes."""
    corners = np.concatenate([box(9000 * i, 700 * i, 0) for i in range(3)])
    return part(number, list(range(36))[keep], corners[keep], level, flags)


BEFORE = (some(1, slice(0, 20)), some(4, slice(0, 36, 3)), some(5, slice(3, 9)), some(9, slice(0, 12)))
AFTER = (
    some(0, slice(5, 9)),
    some(1, slice(4, 36)),
    some(5, slice(0, 36), level=2),
    some(6, slice(1, 2), flags=3),
    some(9, slice(0, 12)),
)


def test_every_kind_of_change_comes_out_again() -> None:
    data = encode_body(BEFORE, AFTER)
    assert listed(decode_body(data, BEFORE)) == listed(AFTER)
    assert len(data) < 12 * sum(len(p.faces) for p in AFTER) / 4


@st.composite
def soups(draw: st.DrawFn) -> tuple[ObjectFaces, ...]:
    """Objects of random faces, many of which share corners, are degenerate or lie at the rim of the grid."""
    value = st.one_of(
        st.integers(-3, 3), st.sampled_from((-LIMIT + 1, LIMIT - 1)), st.integers(-LIMIT + 1, LIMIT - 1)
    )
    places = draw(st.lists(st.tuples(value, value, value), min_size=1, max_size=8))
    found = []
    for number in sorted(draw(st.sets(st.integers(0, 5), max_size=3))):
        corner = st.sampled_from(places)
        faces = draw(st.dictionaries(st.integers(0, 1 << 20), st.tuples(corner, corner, corner), max_size=12))
        level, flags = draw(st.integers(0, 2)), draw(st.integers(0, 1))
        found.append(part(number, sorted(faces), [faces[f] for f in sorted(faces)], level, flags))
    return tuple(found)


def with_same_corners(
    before: tuple[ObjectFaces, ...], after: tuple[ObjectFaces, ...]
) -> tuple[ObjectFaces, ...]:
    """`after` with the corners that `before` has for faces in both."""
    held = {(p.object, p.level, p.flags): dict(zip(p.faces.tolist(), p.corners, strict=True)) for p in before}
    parts = []
    for p in after:
        known = held.get((p.object, p.level, p.flags), {})
        corners = [known.get(f, c) for f, c in zip(p.faces.tolist(), p.corners, strict=True)]
        parts.append(part(p.object, p.faces.tolist(), corners, p.level, p.flags))
    return tuple(parts)


@settings(max_examples=150, deadline=None)
@given(soups(), soups())
def test_random_soups_come_out_again(before: tuple[ObjectFaces, ...], after: tuple[ObjectFaces, ...]) -> None:
    after = with_same_corners(before, after)
    assert listed(decode_body(encode_body(before, after), before)) == listed(after)


def test_a_body_larger_than_was_thought_comes_out_again() -> None:
    generator = np.random.default_rng(3)
    far = generator.integers(1 - LIMIT, LIMIT, (400, 3, 3))
    body = (part(3, list(range(0, 4000, 10)), far),)
    data = encode_body((), body)
    assert len(data) > 4096 + 16 * 400
    assert listed(decode_body(data, ())) == listed(body)


@pytest.mark.parametrize("before", [(), BEFORE], ids=["key frame", "change"])
def test_every_truncation_and_every_extension_is_refused(before: tuple[ObjectFaces, ...]) -> None:
    data = encode_body(before, AFTER)
    for length in range(len(data)):
        with pytest.raises(PacketError):
            decode_body(data[:length], before)
    for more in (b"\0", b"\xff", b"\0" * 9):
        with pytest.raises(PacketError):
            decode_body(data + more, before)


def test_other_corners_for_a_held_face_are_refused() -> None:
    held, other = part(1, [3], box(0, 0, 0)[:1]), part(1, [3], box(1, 0, 0)[:1])
    with pytest.raises(PacketError, match="object 1: a face has other corners"):
        encode_body((held,), (other,))


RECTANGLE = (((0, 0, 0), (1024, 0, 0), (1024, 0, 512)), ((0, 0, 0), (1024, 0, 512), (0, 0, 512)))
ROOF = ((0, 0, 512), (1024, 0, 512), (1024, 700, 900))
TWO = (part(5, [0, 1], np.array(RECTANGLE)),)
THREE = (part(5, [0, 1, 4], np.array((*RECTANGLE, ROOF))),)
REST = (part(5, [1, 4], np.array((RECTANGLE[1], ROOF))),)


@pytest.mark.parametrize(
    ("before", "after", "body"),
    [
        ((), (), "00"),
        ((), TWO, "9cc3d02d9078eb722026"),
        (TWO, THREE, "4460544a565a01ad"),
        (THREE, REST, "4880"),
    ],
)
def test_bodies_byte_by_byte(
    before: tuple[ObjectFaces, ...], after: tuple[ObjectFaces, ...], body: str
) -> None:
    assert encode_body(before, after).hex() == body
    assert listed(decode_body(bytes.fromhex(body), before)) == listed(after)


def test_the_number_a_coder_writes_is_the_one_it_reads() -> None:
    numbers = np.array([0, 1, 2, 255, 256, (1 << 25) - 2, 0, 7], np.int64)
    chances = np.full(NUMBER_CONTEXTS, 1 << 15, np.int64)
    writer = new_coder(np.zeros(100, np.uint8), False, chances)
    code_numbers(writer, 0, numbers)
    data = finish(writer)
    reader = new_coder(np.frombuffer(data, np.uint8).copy(), True, chances)
    found = np.zeros(len(numbers), np.int64)
    code_numbers(reader, 0, found)
    assert found.tolist() == numbers.tolist()
    assert is_finished(reader)


def test_shares_divide_exactly() -> None:
    """Every value that a probability can have, twice, over every number of bits seen."""
    values = 2 * np.arange(ONE + 1, dtype=np.int64)
    for n in range(PATIENCE + 1):
        assert np.array_equal((values * SHARES[n]) >> 32, values // (2 * n + 3))


def test_equal_input_gives_equal_bytes() -> None:
    assert encode_body(BEFORE, AFTER) == encode_body(tuple(BEFORE), tuple(AFTER))


def test_nothing_to_nothing_is_short() -> None:
    data = encode_body((), ())
    assert len(data) <= 2
    assert decode_body(data, ()) == ()


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=200))
def test_random_bytes_are_refused_or_are_a_body(data: bytes) -> None:
    limits = Limits(faces=500, objects=50)
    try:
        found = decode_body(data, BEFORE, limits)
    except PacketError:
        return
    assert len(found) <= 50
    assert all(
        np.all(np.abs(p.corners) < LIMIT) and np.all(np.diff(p.faces.astype(np.int64)) > 0) for p in found
    )


def test_limits_are_kept() -> None:
    data = encode_body((), AFTER)
    with pytest.raises(PacketError, match="faces enter; allowed: 50"):
        decode_body(data, (), Limits(faces=50))
    with pytest.raises(PacketError, match="5 more objects; allowed: 4"):
        decode_body(data, (), Limits(objects=4))


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (
            ObjectFaces(1 << 24, 0, 0, np.zeros(0, np.uint32), np.zeros((0, 3, 3), np.int32)),
            "object 16777216",
        ),
        (part(1, [3, 3], np.zeros((2, 3, 3))), "ascending"),
        (part(1, [1 << 24], np.zeros((1, 3, 3))), "face numbers"),
        (part(1, [3], np.full((1, 3, 3), LIMIT)), "coordinates"),
        (part(1, [3], np.zeros((2, 3, 3))), "shape"),
        (ObjectFaces(1, 0, 0, np.zeros(1, np.uint32), box(0, 0, 0)[:1, ::-1].astype(np.int32)), "rotations"),
    ],
)
def test_what_cannot_be_encoded_is_refused(bad: ObjectFaces, message: str) -> None:
    with pytest.raises(PacketError, match=message):
        encode_body((), (bad,))


def test_objects_that_do_not_ascend_are_refused() -> None:
    with pytest.raises(PacketError, match="allowed: ascending"):
        encode_body((), (some(2, slice(0, 2)), some(1, slice(0, 2))))
