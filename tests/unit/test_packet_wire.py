"""Headers, sequences, and applying packets: what is not sound is refused and changes nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from packet_fixture import MAP, part, state

from tilesnav_ref.packet.change import apply_packet, make_packet
from tilesnav_ref.packet.model import Limits, ObjectFaces, PacketError
from tilesnav_ref.packet.state import check_parts
from tilesnav_ref.packet.wire import HEADER, NO_CELL, NO_MARK, Packet, read_packet, read_sequence

FIRST = state(4, part(2, (0, 3, 5)), part(7, (1, 2), level=3, flags=2))
SECOND = state(9, part(2, (0, 4, 5)), exact=False)
KEY_FRAME = make_packet(None, FIRST)
CHANGE = make_packet(FIRST, SECOND)


def with_byte(place: int, value: int, packet: Packet = KEY_FRAME) -> bytes:
    data = bytearray(packet.to_bytes())
    data[place] = value
    return bytes(data)


def test_a_packet_is_read_as_it_was_written() -> None:
    for packet in (KEY_FRAME, CHANGE):
        assert read_packet(packet.to_bytes()) == packet
    assert read_sequence(KEY_FRAME.to_bytes() + CHANGE.to_bytes()) == (KEY_FRAME, CHANGE)
    assert read_sequence(b"") == ()


def test_the_header_is_what_the_text_lays_down() -> None:
    data = CHANGE.to_bytes()
    assert data[:8] == b"vep1\0" + bytes([CHANGE.codec]) + b"\0\0"
    assert data[8:24] == MAP + (4).to_bytes(4, "little") + (9).to_bytes(4, "little")
    assert data[24:40] == FIRST.mark + SECOND.mark
    assert data[40:48] == len(CHANGE.body).to_bytes(4, "little") + bytes(4)
    assert KEY_FRAME.to_bytes()[4] == 3
    assert KEY_FRAME.to_bytes()[16:32] == b"\xff" * 4 + (4).to_bytes(4, "little") + bytes(8)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "0 bytes; allowed: a header of 48"),
        (KEY_FRAME.to_bytes()[:47], "47 bytes; allowed: a header of 48"),
        (with_byte(3, 0x32), "magic b'vep2'; allowed: b'vep1'"),
        (with_byte(4, 7), "flags 0x07"),
        (with_byte(5, 2), "codec 2"),
        (with_byte(6, 1), "1 and 0 in place of zeros"),
        (with_byte(47, 1), "0 and 16777216 in place of zeros"),
        (with_byte(16, 1), f"a key frame that applies to cell {NO_CELL - 254}"),
        (with_byte(24, 1), "a key frame that applies to cell 4294967295; allowed: 4294967295 and mark 0"),
        (with_byte(4, 1, CHANGE), "a key frame that applies to cell 4"),
        (replace(KEY_FRAME, cell=NO_CELL).to_bytes(), f"cell {NO_CELL}; allowed: numbers of cells"),
        (with_byte(4, 2), f"cell {NO_CELL}; allowed: numbers of cells"),
        (KEY_FRAME.to_bytes()[:-1], f"a body of {len(KEY_FRAME.body)} bytes"),
        (with_byte(43, 255), "a body of 42781"),
        (KEY_FRAME.to_bytes() + b"\0", "1 bytes behind the body"),
    ],
)
def test_a_header_that_is_not_sound_is_refused(data: bytes, message: str) -> None:
    with pytest.raises(PacketError, match=message):
        read_packet(data)


def test_a_sequence_names_the_packet_that_is_broken() -> None:
    with pytest.raises(PacketError, match=f"packet 1, byte {KEY_FRAME.size}: 47 bytes"):
        read_sequence(KEY_FRAME.to_bytes() + bytes(47))


def test_a_packet_leads_to_its_state() -> None:
    first = apply_packet(KEY_FRAME, None, Limits())
    assert first.canonical_bytes() == FIRST.canonical_bytes()
    assert apply_packet(CHANGE, first, Limits()).canonical_bytes() == SECOND.canonical_bytes()
    assert apply_packet(KEY_FRAME, SECOND, Limits()).mark == FIRST.mark


@pytest.mark.parametrize(
    ("packet", "held", "limits", "message"),
    [
        (CHANGE, None, Limits(), "another state of cell 4"),
        (CHANGE, SECOND, Limits(), "another state of cell 4"),
        (CHANGE, replace(FIRST, exact=False), Limits(), "another state of cell 4"),
        (replace(CHANGE, before_cell=5), FIRST, Limits(), "another state of cell 5"),
        (replace(KEY_FRAME, cell=5), None, Limits(), "mark .* of what results"),
        (replace(KEY_FRAME, exact=False), None, Limits(), "mark .* of what results"),
        (replace(KEY_FRAME, map_name=bytes(8)), None, Limits(), "mark .* of what results"),
        (replace(KEY_FRAME, mark=NO_MARK), None, Limits(), "mark .* of what results; allowed: 0{16}"),
        (KEY_FRAME, None, Limits(faces=4), "5 faces.*; allowed: 4"),
        (KEY_FRAME, None, Limits(objects=1), "2 .*objects.*; allowed: 1"),
        (make_packet(FIRST, state(4, *FIRST.parts, part(9, (1,)))), FIRST, Limits(faces=5), "6 faces held"),
    ],
)
def test_a_packet_that_does_not_fit_is_refused(
    packet: Packet, held: object, limits: Limits, message: str
) -> None:
    with pytest.raises(PacketError, match=message):
        apply_packet(packet, held, limits)  # type: ignore[arg-type]


def wrong(**members: object) -> ObjectFaces:
    return replace(part(2, (0, 3, 5)), **members)  # type: ignore[arg-type]


FAR = part(2, (0,)).corners.copy()
FAR[0, 2] = 2**23


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ((part(2, (1,)), part(2, (1,))), "object 2 after object 2"),
        ((part(3, (1,)), part(2, (1,))), "object 2 after object 3"),
        ((wrong(object=2**32),), "level 0; allowed: objects below 2\\^32"),
        ((wrong(level=256),), "level 256"),
        ((wrong(flags=4),), "flags 0x04"),
        ((part(2, ()),), "0 faces with corners"),
        ((wrong(faces=np.array((0, 3), np.uint32)),), "2 faces with corners of shape \\(3, 3, 3\\)"),
        ((wrong(faces=np.array((0, 5, 3), np.uint32)),), "do not ascend"),
        ((wrong(faces=np.array((0, 3, 3), np.uint32)),), "do not ascend"),
        ((ObjectFaces(2, 0, 0, np.array([0], np.uint32), FAR),), "a coordinate of 8388608 steps"),
        ((ObjectFaces(2, 0, 0, np.array([0], np.uint32), -FAR),), "a coordinate of -8388608 steps"),
        ((wrong(corners=part(2, (0, 3, 5)).corners[:, [1, 2, 0]]),), "in another order"),
    ],
)
def test_parts_that_are_not_sound_are_refused_even_with_their_mark(
    parts: tuple[ObjectFaces, ...], message: str
) -> None:
    with pytest.raises(PacketError, match=message):
        check_parts(parts, Limits())


def test_a_sender_of_bad_faces_with_the_right_mark_is_refused() -> None:
    bad = state(4, wrong(corners=part(2, (0, 3, 5)).corners[:, [1, 2, 0]]))
    with pytest.raises(PacketError, match="in another order"):
        apply_packet(make_packet(None, bad), None, Limits())


def test_states_of_two_maps_have_no_packet() -> None:
    with pytest.raises(ValueError, match="states of the maps"):
        make_packet(FIRST, replace(SECOND, map_name=bytes(8)))


def test_every_truncation_and_every_flipped_bit_is_refused_or_changes_nothing() -> None:
    for packet, held, after in ((KEY_FRAME, None, FIRST), (CHANGE, FIRST, SECOND)):
        whole = packet.to_bytes()
        for end in range(len(whole)):
            with pytest.raises(PacketError):
                read_packet(whole[:end])
        for bit in range(8 * len(whole)):
            data = bytearray(whole)
            data[bit // 8] ^= 1 << bit % 8
            try:
                found = apply_packet(read_packet(bytes(data)), held, Limits())
            except PacketError:
                continue
            assert found.canonical_bytes() == after.canonical_bytes()
            assert bit >= 8 * HEADER.size, "a bit of the header is bound by nothing"
