"""The sender: key frame or change, what is left with a vehicle, and what it remembers."""

from __future__ import annotations

import numpy as np
import pytest
from packet_fixture import part
from packet_world import Wanted, World

from tilesnav_ref.packet.client import PacketClient, Verdict
from tilesnav_ref.packet.model import ObjectFaces, PacketError
from tilesnav_ref.packet.wire import read_packet
from tilesnav_ref.stream.policy import LevelPolicy
from tilesnav_ref.stream.retention import choose_finer, new_faces, retained
from tilesnav_ref.stream.sender import REMEMBERED, Sender

ALL = frozenset(range(8))
WORLD = World(
    {
        0: {1: ALL, 2: frozenset({0, 1})},
        1: {1: ALL - {0}, 3: frozenset({4})},
        2: {1: frozenset({5})},
        3: {},
    }
)


def walk(world: World, cells: list[int], retain: int = 0) -> tuple[Sender, PacketClient, list[bytes]]:
    sender, client, packets = Sender(world, Wanted(), retain), PacketClient(world.map_name), []
    for cell in cells:
        packets.append(sender.packet(cell))
        assert client.receive(packets[-1]).verdict is not Verdict.REFUSED
        assert sender.acknowledge(client.holds)
    return sender, client, packets


def holding(client: PacketClient) -> dict[int, tuple[int, list[int]]]:
    assert client.state is not None
    return {one.object: (one.level, one.faces.tolist()) for one in client.state.parts}


def test_the_first_packet_is_a_key_frame_and_a_small_change_is_not() -> None:
    _, client, packets = walk(WORLD, [0, 1])
    assert [read_packet(data).is_key_frame for data in packets] == [True, False]
    assert len(packets[1]) < len(Sender(WORLD, Wanted()).packet(1))
    assert holding(client) == {1: (0, list(range(1, 8))), 3: (0, [4])}


def test_where_a_key_frame_is_no_larger_it_is_sent() -> None:
    _, client, packets = walk(WORLD, [0, 3])
    assert read_packet(packets[1]).is_key_frame
    assert holding(client) == {}


def test_packets_go_on_from_what_was_acknowledged() -> None:
    sender, client, _ = walk(WORLD, [0])
    ahead = sender.packet(1)
    assert read_packet(sender.packet(2)).before_cell in (0, None)
    client.receive(ahead)
    assert sender.acknowledged is not None
    assert sender.acknowledged.cell == 0
    sender.acknowledge(client.holds)
    assert sender.acknowledged.cell == 1
    sender.acknowledge(None)
    assert sender.acknowledged is None
    assert read_packet(sender.packet(1)).is_key_frame


def test_a_state_that_the_sender_does_not_know_makes_the_next_packet_a_key_frame() -> None:
    sender, client, _ = walk(WORLD, [0])
    assert client.holds is not None
    assert not sender.acknowledge((client.holds[0], bytes(8)))
    assert read_packet(sender.packet(1)).is_key_frame
    assert sender.acknowledge(client.holds)


def test_a_sender_remembers_a_bounded_number_of_states() -> None:
    many = World({cell: {1: frozenset({cell % 8}), 2: ALL} for cell in range(REMEMBERED + 2)})
    sender = Sender(many, Wanted())
    names = []
    for cell in range(REMEMBERED + 2):
        packet = read_packet(sender.packet(cell))
        names.append((packet.cell, packet.mark))
    assert [sender.acknowledge(name) for name in names] == [False, False, *[True] * REMEMBERED]
    for cell in range(REMEMBERED + 1):
        sender.packet(cell)
    assert sender.acknowledge(names[-1]), "what is acknowledged is remembered"


def test_faces_that_leave_are_kept_within_the_budget() -> None:
    _, client, packets = walk(WORLD, [0, 1, 0], retain=3)
    assert holding(client) == {1: (0, sorted(ALL)), 2: (0, [0, 1]), 3: (0, [4])}
    assert [read_packet(data).exact for data in packets] == [True, False, False]
    _, client, _ = walk(WORLD, [0, 1, 0, 2], retain=1000)
    assert holding(client) == {1: (0, sorted(ALL)), 2: (0, [0, 1]), 3: (0, [4])}


def test_nothing_is_sent_again_that_is_still_held() -> None:
    _, _, packets = walk(WORLD, [0, 1, 0, 1], retain=3)
    _, _, without = walk(WORLD, [0, 1, 0, 1])
    assert len(packets[2]) < len(without[2])
    assert len(packets[3]) < len(without[3])


def test_objects_needed_least_recently_go_first() -> None:
    cells = World({cell: {cell: frozenset({0, 1}), 9: ALL} for cell in range(4)})
    _, client, _ = walk(cells, [0, 1, 2, 3], retain=4)
    assert sorted(holding(client)) == [1, 2, 3, 9]
    _, client, _ = walk(cells, [0, 1, 0, 2, 3], retain=4)
    assert sorted(holding(client)) == [0, 2, 3, 9]


def test_an_object_that_does_not_fit_goes_and_a_smaller_one_stays() -> None:
    held = (part(1, (0,)), part(2, range(5)), part(3, (7,)))
    kept = retained((part(4, (0,)),), held, {1: 1, 2: 3, 3: 2}, budget=2)
    assert [one.object for one in kept] == [1, 3, 4]
    kept = retained((part(4, (0,)),), held, {1: 1, 2: 3, 3: 2}, budget=5)
    assert [one.object for one in kept] == [2, 4]


def test_a_finer_level_is_kept_where_it_costs_fewer_faces() -> None:
    world = World({0: {1: ALL}, 1: {1: frozenset({0, 2, 4, 6})}}, {(1, 1): 1})
    _, client, packets = walk(world, [0, 1], retain=8)
    assert holding(client) == {1: (0, sorted(ALL))}
    assert read_packet(packets[1]).exact is False
    _, client, _ = walk(world, [0, 1])
    assert holding(client) == {1: (1, [0, 1, 2, 3])}
    _, client, packets = walk(world, [0, 1], retain=3)
    assert holding(client) == {1: (0, [0, 2, 4, 6])}, "the finer faces that are called for, and no more"
    assert read_packet(packets[1]).exact


def test_a_finer_level_that_costs_more_is_given_up() -> None:
    needed = part(1, (0, 1), level=1)
    finer = part(1, range(8))
    assert choose_finer((needed,), (finer,), (part(1, range(3)),), 100) == (needed,)
    assert choose_finer((needed,), (finer,), (part(1, range(7)),), 100) == (finer,)
    assert choose_finer((needed,), (finer,), (part(1, range(7)),), 5) == (needed,)
    assert new_faces(finer, None) == 8
    assert new_faces(finer, part(1, range(7), level=1)) == 8


def test_a_coarser_level_is_never_kept() -> None:
    world = World({0: {1: ALL}, 1: {1: ALL}}, {(0, 1): 2})
    _, client, _ = walk(world, [0, 1], retain=10**6)
    assert holding(client) == {1: (0, sorted(ALL))}


def test_less_than_no_faces_cannot_be_retained() -> None:
    with pytest.raises(ValueError, match="retain: found -1; allowed: 0 or more faces"):
        Sender(WORLD, Wanted(), -1)


def test_faces_that_a_packet_cannot_carry_are_not_sent() -> None:
    class Broken(World):
        def held(self, cell: int, policy: LevelPolicy) -> tuple[ObjectFaces, ...]:
            (one, *_) = super().held(cell, policy)
            return (ObjectFaces(one.object, 256, 0, one.faces, np.asarray(one.corners)),)

    with pytest.raises(PacketError, match="level 256"):
        Sender(Broken(WORLD.listed), Wanted()).packet(0)
