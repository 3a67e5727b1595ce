"""The client: what it does with a packet, and why."""

from __future__ import annotations

import pytest
from packet_fixture import MAP, part, state

from tilesnav_ref.packet.change import make_packet
from tilesnav_ref.packet.client import TRIES, ClientSettings, PacketClient, Verdict
from tilesnav_ref.packet.early import EarlyPackets
from tilesnav_ref.packet.model import Limits
from tilesnav_ref.packet.state import HeldState
from tilesnav_ref.packet.wire import HEADER

A, B, C, D = (state(cell, part(1, range(3 + cell)), part(2, (cell,))) for cell in range(4))
OTHER_B = state(1, part(1, range(9)), exact=False)


def packet(before: HeldState | None, after: HeldState) -> bytes:
    return make_packet(before, after).to_bytes()


def client_with(held: HeldState | None = None, here: int | None = None, **settings: int) -> PacketClient:
    client = PacketClient(MAP, ClientSettings(**settings))
    if here is not None:
        client.enter(here)
    if held is not None:
        assert client.receive(packet(None, held)).verdict is Verdict.APPLIED
    return client


def test_a_client_begins_with_nothing() -> None:
    client = client_with()
    assert (client.state, client.holds, client.here, client.is_current) == (None, None, None, False)
    outcome = client.receive(packet(A, B))
    assert outcome.verdict is Verdict.KEPT
    assert outcome.reason == f"it applies to cell 0, mark {A.mark.hex()}; held: nothing"


def test_a_key_frame_brings_what_was_kept_with_it() -> None:
    client = client_with()
    client.receive(packet(B, C))
    client.receive(packet(A, B))
    outcome = client.receive(packet(None, A))
    assert (outcome.verdict, outcome.applied) == (Verdict.APPLIED, 3)
    assert client.holds == (2, C.mark)


def test_a_copy_changes_nothing() -> None:
    client = client_with(A)
    client.receive(packet(A, B))
    before = client.state
    for data in (packet(A, B), packet(None, B)):
        assert client.receive(data).verdict is Verdict.REPEATED
    assert client.state is before


def test_reasons_are_exact() -> None:
    client = client_with(A)
    broken = bytearray(packet(A, B))
    broken[-1] ^= 1
    assert client.receive(bytes(broken)).verdict is Verdict.REFUSED
    foreign = HeldState(bytes(8), 1, True, B.parts)
    outcome = client.receive(packet(None, foreign))
    assert (outcome.verdict, outcome.reason) == (Verdict.REFUSED, f"map {'0' * 16}; allowed: {MAP.hex()}")
    outcome = client.receive(packet(OTHER_B, C))
    assert outcome.verdict is Verdict.KEPT
    applies_to = f"it applies to cell 1, mark {OTHER_B.mark.hex()}"
    assert outcome.reason == f"{applies_to}; held: cell 0, mark {A.mark.hex()}"
    assert client.holds == (0, A.mark)


def test_a_packet_for_another_state_of_the_same_cell_does_not_apply() -> None:
    client = client_with(OTHER_B)
    assert client.receive(packet(B, C)).verdict is Verdict.KEPT
    assert client.holds == (1, OTHER_B.mark)


def test_a_client_that_knows_where_it_is_stays_there() -> None:
    client = client_with(A, here=0)
    outcome = client.receive(packet(A, B))
    assert (outcome.verdict, outcome.reason) == (Verdict.KEPT, "it leads to cell 1; the vehicle is in cell 0")
    assert client.receive(packet(None, C)).verdict is Verdict.KEPT
    assert client.receive(packet(B, D)).verdict is Verdict.KEPT
    assert client.holds == (0, A.mark)
    assert client.is_current
    outcome = client.enter(3)
    assert (outcome.verdict, outcome.applied) == (Verdict.APPLIED, 2)
    assert client.holds == (3, D.mark)
    assert client.enter(3).verdict is Verdict.REPEATED
    assert client.enter(2).verdict is Verdict.APPLIED
    assert client.holds == (2, C.mark)


def test_a_client_that_lacks_something_says_so_and_keeps_what_it_has() -> None:
    client = client_with(A, here=0)
    outcome = client.enter(3)
    assert (outcome.verdict, outcome.reason) == (Verdict.KEPT, "nothing has come that leads to cell 3")
    assert not client.is_current
    assert client.receive(packet(A, B)).verdict is Verdict.KEPT
    assert client.holds == (0, A.mark)
    outcome = client.receive(packet(B, D))
    assert (outcome.verdict, outcome.applied) == (Verdict.APPLIED, 2)
    assert client.holds == (3, D.mark)


def test_a_late_key_frame_does_not_take_a_client_back_that_knows_where_it_is() -> None:
    client = client_with(B, here=1)
    assert client.receive(packet(None, A)).verdict is Verdict.KEPT
    assert client.holds == (1, B.mark)
    assert client.receive(packet(None, OTHER_B)).verdict is Verdict.APPLIED
    assert client.holds == (1, OTHER_B.mark)
    told_nothing = client_with(B)
    told_nothing.receive(packet(None, A))
    assert told_nothing.holds == (0, A.mark)


def test_a_broken_packet_that_was_kept_is_found_out_and_the_whole_one_is_taken() -> None:
    client = client_with(A, here=0)
    broken = bytearray(packet(B, C))
    broken[-3] ^= 4
    client.receive(packet(A, B))
    client.receive(packet(B, C))
    client.receive(bytes(broken))
    assert client.enter(2).verdict is Verdict.APPLIED
    assert client.holds == (2, C.mark)


def test_a_chain_that_breaks_leaves_the_state_as_it_was() -> None:
    client = client_with(A, here=0)
    broken = bytearray(packet(B, C))
    broken[-3] ^= 4
    client.receive(packet(A, B))
    client.receive(bytes(broken))
    before = client.state
    assert client.enter(2).verdict is Verdict.KEPT
    assert client.state is before
    assert client.receive(packet(B, C)).verdict is Verdict.APPLIED


def test_many_broken_packets_cost_a_bounded_number_of_tries() -> None:
    client = client_with(A, here=0)
    for number in range(2 * TRIES):
        broken = bytearray(packet(A, C))
        broken[-1 - number] ^= 255
        client.receive(bytes(broken))
    assert client.enter(2).verdict is Verdict.KEPT
    assert client.enter(2).verdict is Verdict.KEPT
    assert client.receive(packet(A, C)).verdict is Verdict.APPLIED


def test_the_oldest_packets_go_first() -> None:
    store = EarlyPackets(2, 10**6)
    for before, after in ((A, B), (B, C), (C, D)):
        store.put(make_packet(before, after))
        store.put(make_packet(before, after))
    assert len(store) == 2
    assert store.byte_count == make_packet(B, C).size + make_packet(C, D).size
    assert store.path_to(3, (0, A.mark)) == []
    assert store.path_to(3, (1, B.mark)) == [make_packet(B, C), make_packet(C, D)]
    small = EarlyPackets(10, make_packet(B, C).size)
    small.put(make_packet(A, B))
    small.put(make_packet(B, C))
    assert (len(small), small.byte_count) == (1, make_packet(B, C).size)


def test_what_is_kept_is_bounded() -> None:
    size = len(packet(A, B))
    client = client_with(None, early_bytes=size - 1)
    outcome = client.receive(packet(A, B))
    assert (outcome.verdict, outcome.reason) == (
        Verdict.REFUSED,
        f"{size} bytes to keep; allowed: {size - 1} or less",
    )


def test_a_client_holds_no_more_than_it_was_set_to() -> None:
    client = PacketClient(MAP, ClientSettings(Limits(faces=4)))
    assert client.receive(packet(None, A)).verdict is Verdict.APPLIED
    outcome = client.receive(packet(A, B))
    assert (outcome.verdict, outcome.reason) == (Verdict.REFUSED, "5 faces held; allowed: 4 or less")
    assert client.holds == (0, A.mark)


def test_the_name_of_a_map_has_eight_bytes() -> None:
    with pytest.raises(ValueError, match="map_name: found 32 bytes; allowed: 8"):
        PacketClient(bytes(32))


def test_noise_is_refused() -> None:
    client = client_with(A)
    for data in (b"", b"vep1", bytes(HEADER.size), b"\xff" * 4000):
        assert client.receive(data).verdict is Verdict.REFUSED
    assert client.holds == (0, A.mark)
