"""A link that loses, doubles, reorders and breaks packets: the state of the client is right, or none."""

from __future__ import annotations

import hashlib
import struct

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from packet_fixture import MAP
from packet_world import FACES, Wanted, World

from tilesnav_ref.packet.client import ClientSettings, Outcome, PacketClient, Verdict
from tilesnav_ref.packet.state import HeldState
from tilesnav_ref.packet.wire import read_packet
from tilesnav_ref.stream.sender import Sender

CELLS = range(4)
OBJECTS = range(5)
SETS = st.dictionaries(
    st.sampled_from(OBJECTS), st.frozensets(st.integers(0, FACES - 1), min_size=1), max_size=len(OBJECTS)
)
WORLDS = st.builds(
    World,
    st.fixed_dictionaries(dict.fromkeys(CELLS, SETS)),
    st.dictionaries(st.tuples(st.sampled_from(CELLS), st.sampled_from(OBJECTS)), st.integers(0, 2)),
)
RETAINED = st.sampled_from((0, 0, 3, 12, 1000))


def mark_by_the_text(state: HeldState) -> bytes:
    """Mark of a state, number by number."""
    data = state.map_name + struct.pack("<III", state.cell, 1 if state.exact else 0, len(state.parts))
    for part in state.parts:
        data += struct.pack("<IBBI", part.object, part.level, part.flags, len(part.faces))
        data += b"".join(struct.pack("<I", face) for face in part.faces.tolist())
        data += b"".join(struct.pack("<i", number) for number in part.corners.ravel().tolist())
    return hashlib.sha256(data).digest()[:8]


def plain(state: HeldState) -> list[object]:
    return [
        (part.object, part.level, part.flags, part.faces.tolist(), part.corners.tolist())
        for part in state.parts
    ]


class Link(RuleBasedStateMachine):
    """One vehicle and its sender."""

    @initialize(world=WORLDS, retain=RETAINED)
    def begin(self, world: World, retain: int) -> None:
        self.world = world
        self.retain = retain
        self.sender = Sender(world, Wanted(), retain)
        self.client = PacketClient(MAP, ClientSettings(early_packets=5, early_bytes=6000))
        self.sent: list[bytes] = []
        self.reports: list[tuple[int, bytes] | None] = [None]

    @rule(cell=st.sampled_from(CELLS))
    def send(self, cell: int) -> None:
        data = self.sender.packet(cell)
        assert len(data) <= len(Sender(self.world, Wanted()).packet(cell)), "larger than the key frame"
        self.sent.append(data)

    @precondition(lambda self: self.sent)
    @rule(data=st.data())
    def arrive(self, data: st.DataObject) -> None:
        """Any packet that was ever sent: late, early, again."""
        self.take(data.draw(st.sampled_from(self.sent[-8:])))

    @precondition(lambda self: self.sent)
    @rule()
    def arrive_at_once(self) -> None:
        self.take(self.sent[-1])

    @precondition(lambda self: self.sent)
    @rule(data=st.data())
    def arrive_broken(self, data: st.DataObject) -> None:
        packet = bytearray(data.draw(st.sampled_from(self.sent[-8:])))
        for _ in range(data.draw(st.integers(1, 3))):
            packet[data.draw(st.integers(0, len(packet) - 1))] ^= data.draw(st.integers(1, 255))
        self.take(bytes(packet[: data.draw(st.integers(0, len(packet)) | st.just(len(packet)))]))

    @rule(noise=st.binary(max_size=200))
    def noise(self, noise: bytes) -> None:
        assert self.take(noise).verdict is Verdict.REFUSED

    @rule(cell=st.sampled_from(CELLS))
    def move(self, cell: int) -> None:
        self.client.enter(cell)
        if self.client.is_current:
            assert self.client.state is not None
            assert self.client.state.cell == cell

    @rule()
    def report(self) -> None:
        self.reports.append(self.client.holds)
        self.sender.acknowledge(self.client.holds)

    @rule(data=st.data())
    def report_arrives_late(self, data: st.DataObject) -> None:
        self.sender.acknowledge(data.draw(st.sampled_from(self.reports)))

    @rule(cell=st.sampled_from(CELLS))
    def settle(self, cell: int) -> None:
        """The link works for a moment: one report and one packet do."""
        self.sender.acknowledge(self.client.holds)
        self.sent.append(self.sender.packet(cell))
        self.client.enter(cell)
        if not self.client.is_current:
            assert self.take(self.sent[-1]).verdict is Verdict.APPLIED
        assert self.client.is_current

    def take(self, data: bytes) -> Outcome:
        before = self.client.state
        outcome = self.client.receive(data)
        if outcome.verdict is Verdict.APPLIED:
            assert outcome.applied >= 1
        else:
            assert self.client.state is before, outcome
        return outcome

    @staticmethod
    def named(data: bytes) -> tuple[int, bytes]:
        packet = read_packet(data)
        return packet.cell, packet.mark

    @invariant()
    def state_is_right_or_none(self) -> None:
        if not hasattr(self, "world") or self.client.state is None:
            return
        state = self.client.state
        assert state.mark == mark_by_the_text(state)
        assert (state.cell, state.mark) in {self.named(data) for data in self.sent}
        assert self.world.lacks(state) == []
        assert state.exact == (self.world.surplus(state) == 0)
        wanted = self.world.held(state.cell, Wanted())
        assert state.face_count - sum(len(part.faces) for part in wanted) <= self.retain
        if not self.retain:
            assert plain(state) == plain(HeldState(MAP, state.cell, True, wanted))


Link.TestCase.settings = settings(
    max_examples=40, stateful_step_count=30, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
TestLink = Link.TestCase


@settings(max_examples=40, deadline=None)
@given(WORLDS, st.lists(st.sampled_from(CELLS), min_size=2, max_size=8))
def test_a_path_with_cycles_ends_where_a_leap_ends(world: World, path: list[int]) -> None:
    walker, leaper = (Sender(world, Wanted()) for _ in range(2))
    walking, leaping = (PacketClient(MAP) for _ in range(2))
    for cell in path:
        assert walking.receive(walker.packet(cell)).verdict is not Verdict.REFUSED
        assert walker.acknowledge(walking.holds)
    for cell in (path[0], path[-1]):
        leaping.receive(leaper.packet(cell))
        leaper.acknowledge(leaping.holds)
    fresh = PacketClient(MAP)
    fresh.receive(Sender(world, Wanted()).packet(path[-1]))
    assert walking.state is not None
    assert leaping.state is not None
    assert fresh.state is not None
    assert walking.holds == leaping.holds == fresh.holds
    assert plain(walking.state) == plain(leaping.state) == plain(fresh.state)


@settings(max_examples=30, deadline=None)
@given(WORLDS, st.permutations(list(CELLS)))
def test_packets_of_a_path_arrive_in_any_order(world: World, order: list[int]) -> None:
    sender, ahead, client = Sender(world, Wanted()), PacketClient(MAP), PacketClient(MAP)
    packets = []
    for cell in CELLS:
        packets.append(sender.packet(cell))
        ahead.receive(packets[-1])
        sender.acknowledge(ahead.holds)
    client.enter(CELLS[-1])
    for index in order:
        client.receive(packets[index])
    assert client.holds == ahead.holds
