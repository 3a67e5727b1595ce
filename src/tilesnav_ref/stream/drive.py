"""Driving a route: a packet at the entry of each cell, applied by a client."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.packet.client import ClientSettings, PacketClient, Verdict
from tilesnav_ref.packet.model import PacketError
from tilesnav_ref.packet.state import Parts
from tilesnav_ref.packet.wire import read_packet
from tilesnav_ref.stream.bandwidth import Series
from tilesnav_ref.stream.delivery import Delivery
from tilesnav_ref.stream.policy import LevelPolicy
from tilesnav_ref.stream.retention import new_faces
from tilesnav_ref.stream.route import Passage, Route
from tilesnav_ref.stream.sender import LIMITS, Sender

SPEED_LIMITS = (0.01, 1000.0)
"""m/s that a route is driven at."""
UNLIMITED = LIMITS.faces
"""Faces to retain for a vehicle that drops nothing."""


@dataclass(frozen=True)
class DriveSettings:
    """How a route is driven."""

    policy: LevelPolicy = field(default_factory=LevelPolicy)
    speed: float = 20.0
    """m/s."""
    retain: int = 0
    """Faces that the vehicle may hold beyond what its cell calls for."""

    def __post_init__(self) -> None:
        """ValueError naming the setting that is out of range."""
        check_speed(self.speed)
        if not 0 <= self.retain <= UNLIMITED:
            raise ValueError(f"setting retain: found {self.retain}; allowed: 0 to {UNLIMITED} faces")


def check_speed(speed: float) -> None:
    """Refuse a speed that no vehicle has: ValueError."""
    low, high = SPEED_LIMITS
    if not low <= speed <= high:
        raise ValueError(f"setting speed: found {speed}; allowed: {low} to {high} m/s")


@dataclass(frozen=True)
class Drive:
    """What was sent along a route."""

    series: Series
    """One entry a cell."""
    cells: NDArray[np.int64]
    """(S,) entered."""
    key_frames: NDArray[np.bool_]
    """(S,)."""
    new_faces: NDArray[np.int64]
    """(S,) faces held after a packet that were not held before it."""
    apply_seconds: NDArray[np.float64]
    """(S,) processor time that the client took for each packet."""
    make_seconds: NDArray[np.float64]
    """(S,) processor time that the sender took."""
    packets: tuple[bytes, ...]


def drive(delivery: Delivery, route: Route, settings: DriveSettings) -> Drive:
    """Drive a route, with one packet at the entry of each cell.

    Parameters
    ----------
    delivery : Delivery
        Of the tileset.
    route : Route
        Its cells are those of the tileset.

    Raises
    ------
    PacketError
        When the client does not take a packet: that is a defect of one of the two.

    Notes
    -----
    The first packet is a key frame; each other one is for the state that the client holds. Packets arrive
    at once and none is lost. The first one is given to another client beforehand, so that no time
    contains the compilation of kernels.
    """
    sender, client = Sender(delivery, settings.policy, settings.retain), _client(delivery)
    steps: list[_Step] = []
    for passage in route.passages:
        held = client.state.parts if client.state else ()
        begin = time.thread_time()
        packet = sender.packet(passage.cell)
        made = time.thread_time()
        if not steps:
            _client(delivery).receive(packet)
        applying = time.thread_time()
        outcome = client.receive(packet)
        applied = time.thread_time()
        state = client.state
        if outcome.verdict is not Verdict.APPLIED or state is None:
            raise PacketError(f"packet to cell {passage.cell}: {outcome.verdict.value}: {outcome.reason}")
        sender.acknowledge((state.cell, state.mark))
        new = _new_faces(held, state.parts)
        steps.append(_Step(passage, packet, state.face_count, new, made - begin, applied - applying))
    return _collect(steps, route.length / settings.speed, settings.speed)


@dataclass(frozen=True)
class _Step:
    passage: Passage
    packet: bytes
    held: int
    new: int
    making: float
    applying: float


def _collect(steps: list[_Step], duration: float, speed: float) -> Drive:
    return Drive(
        Series(
            np.array([step.passage.begin / speed for step in steps]),
            np.array([len(step.packet) for step in steps], np.int64),
            np.array([step.held for step in steps], np.int64),
            duration,
        ),
        np.array([step.passage.cell for step in steps], np.int64),
        np.array([read_packet(step.packet).is_key_frame for step in steps]),
        np.array([step.new for step in steps], np.int64),
        np.array([step.applying for step in steps]),
        np.array([step.making for step in steps]),
        tuple(step.packet for step in steps),
    )


def _client(delivery: Delivery) -> PacketClient:
    return PacketClient(delivery.map_name, ClientSettings(limits=LIMITS))


def _new_faces(before: Parts, after: Parts) -> int:
    known = {part.object: part for part in before}
    return sum(new_faces(part, known.get(part.object)) for part in after)
