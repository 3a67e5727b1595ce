"""Codec 0: what goes in comes out, and what is broken is refused with its reason."""

from __future__ import annotations

import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from packet_fixture import part, world_corners

from tilesnav_ref.packet.model import Limits, ObjectFaces, PacketError
from tilesnav_ref.packet.plain import decode_plain, encode_plain
from tilesnav_ref.packet.state import check_parts

HELD = (part(2, (0, 3, 5)), part(7, (1, 2), level=3, flags=2))


def inflated(raw: bytes, stated: int | None = None) -> bytes:
    return struct.pack("<I", len(raw) if stated is None else stated) + zlib.compress(raw)


def numbers(*values: int) -> bytes:
    return struct.pack(f"<{len(values)}I", *values)


def change(number: int, mode: int, leave: tuple[int, ...], enter: tuple[int, ...], level: int = 0) -> bytes:
    corners = world_corners(number, level, enter).astype("<i4").tobytes()
    head = struct.pack("<IBBH", number, level, 2 if number == 7 else 0, mode)
    return head + numbers(len(leave), *leave, len(enter), *enter) + corners


def body(gone: tuple[int, ...], *changes: bytes) -> bytes:
    return inflated(numbers(len(gone), *gone, len(changes)) + b"".join(changes))


def as_lists(parts: tuple[ObjectFaces, ...]) -> list[tuple[object, ...]]:
    return [(p.object, p.level, p.flags, p.faces.tolist(), p.corners.tolist()) for p in parts]


@pytest.mark.parametrize(
    "after",
    [
        (),
        HELD,
        (HELD[0],),
        (part(2, (0, 4, 5)), HELD[1]),
        (part(2, (3,)), part(3, (0, 9)), part(7, (1, 2), level=0, flags=2)),
        (part(0, range(12)), part(2, range(12)), part(2**32 - 1, (2**32 - 1,))),
    ],
)
def test_what_is_encoded_is_decoded(after: tuple[ObjectFaces, ...]) -> None:
    for before in ((), HELD, after):
        found = decode_plain(encode_plain(before, after), before, Limits())
        check_parts(found, Limits())
        assert as_lists(found) == as_lists(after)
        assert all(one.faces.dtype == np.uint32 and one.corners.dtype == np.int32 for one in found)


def test_an_object_that_stays_is_the_same_object() -> None:
    found = decode_plain(encode_plain(HELD, (*HELD, part(9, (1,)))), HELD, Limits())
    assert found[0] is HELD[0]
    assert found[1] is HELD[1]


def test_a_face_whose_corners_are_others_is_sent_anew() -> None:
    other = ObjectFaces(2, 0, 0, HELD[0].faces, HELD[0].corners + np.int32(1))
    assert as_lists(decode_plain(encode_plain(HELD, (other,)), HELD, Limits())) == as_lists((other,))


def test_a_change_within_the_level_takes_what_it_says() -> None:
    found = decode_plain(body((7,), change(2, 0, (3,), (1, 9))), HELD, Limits())
    assert as_lists(found) == as_lists((part(2, (0, 1, 5, 9)),))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"\0\0", "a body of 2 bytes"),
        (struct.pack("<I", 9) + b"not zlib", "no zlib stream"),
        (inflated(numbers(0, 0), 9), "inflates to 8 bytes, an end and 0 bytes behind it; allowed: 9"),
        (inflated(numbers(0, 0), 7), "inflates to 8 bytes"),
        (inflated(numbers(0, 0)) + b"x", "1 bytes behind it"),
        (inflated(numbers(0, 0))[:-1], "no end"),
        (struct.pack("<I", 2**28) + bytes(40), "a body of 268435456 bytes when inflated; allowed: 42312"),
        (inflated(b"\0\0\0"), "objects that go: 3 bytes left"),
        (inflated(numbers(2**32 - 1)), "objects that go: 4294967295, with 0 bytes left"),
        (inflated(numbers(0, 2**32 - 1)), "objects that change or come: 4294967295, with 0 bytes left"),
        (inflated(numbers(0, 1) + bytes(15)), "objects that change or come: 1, with 15 bytes left"),
        (inflated(numbers(0, 0, 0)), "4 bytes behind the last object"),
        (body((3,)), "object 3 goes; allowed: objects that are held"),
        (body((7, 2)), "numbers that do not ascend"),
        (body((2, 2)), "numbers that do not ascend"),
        (body((2,), change(2, 1, (), (1,))), "object 2 goes and changes"),
        (body((), change(7, 1, (), (1,)), change(2, 1, (), (1,))), "object 2 after object 7"),
        (body((), change(2, 1, (), (1,)), change(2, 1, (), (1,))), "object 2 after object 2"),
        (body((), change(2, 2, (), (1,))), "object 2: mode 2"),
        (body((), change(2, 1, (), ())), "0 faces leave, 0 enter anew"),
        (body((), change(2, 1, (0,), (1,))), "1 faces leave, 1 enter anew"),
        (body((), change(4, 0, (), (1,))), "object 4: nothing held"),
        (body((), change(7, 0, (), (5,))), "object 7: level 3, flags 2 held; the change is of level 0"),
        (body((), change(2, 0, (), ())), "0 faces leave, 0 enter, 3 are left"),
        (body((), change(2, 0, (0, 3, 5), ())), "3 faces leave, 0 enter, 0 are left"),
        (body((), change(2, 0, (1,), ())), "a face leaves that is not held"),
        (body((), change(2, 0, (), (3,))), "a face enters that is held"),
        (body((), change(2, 0, (3, 0), ())), "faces that do not ascend"),
        (body((), change(2, 0, (), (9, 8))), "faces that do not ascend"),
        (body((), change(2, 0, (), (9, 8, 1))[:-3]), "faces that enter: 3, with 117 bytes left"),
    ],
)
def test_a_broken_body_is_refused_with_its_reason(data: bytes, message: str) -> None:
    with pytest.raises(PacketError, match=message):
        decode_plain(data, HELD, Limits())


def test_a_body_is_refused_before_it_takes_room() -> None:
    bomb = zlib.compress(bytes(1 << 26), 9)
    claims = [struct.pack("<I", claim) + bomb for claim in (8, 1 << 26, (1 << 28) - 1, (1 << 32) - 1)]
    tracemalloc.start()
    for data in claims:
        with pytest.raises(PacketError):
            decode_plain(data, (), Limits(faces=1000, objects=10))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1 << 20


def test_every_truncation_and_every_flipped_bit_is_refused_or_gives_sound_parts() -> None:
    whole = body((7,), change(2, 0, (3,), (1, 9)), change(5, 1, (), (0, 4)))
    for end in range(len(whole)):
        with pytest.raises(PacketError):
            decode_plain(whole[:end], HELD, Limits())
    for bit in range(8 * len(whole)):
        data = bytearray(whole)
        data[bit // 8] ^= 1 << bit % 8
        try:
            found = decode_plain(bytes(data), HELD, Limits())
        except PacketError:
            continue
        assert as_lists(found) == as_lists((part(2, (0, 1, 5, 9)), part(5, (0, 4))))


def test_raw_bytes_without_a_checksum_are_refused_or_give_parts() -> None:
    """As the body is without the sum of zlib: whoever writes a packet on purpose gets that right."""
    raw = zlib.decompress(body((7,), change(2, 0, (3,), (1, 9)), change(5, 1, (), (0, 4)))[4:])
    for place in range(len(raw)):
        for value in (0, 1, 127, 255):
            data = raw[:place] + bytes([value]) + raw[place + 1 :]
            try:
                found = decode_plain(inflated(data), HELD, Limits())
                check_parts(found, Limits())
            except PacketError:
                continue
            assert len(found) <= 4
            assert all(len(one.faces) == len(one.corners) > 0 for one in found)
