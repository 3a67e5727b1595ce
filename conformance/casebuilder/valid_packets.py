"""Valid cases with packets: each way to send a state, and limits that are only just kept."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from casebuilder.assemble import Case
from casebuilder.levels import faces_for_many, two_levels
from casebuilder.packets import CODED, KEY, Packet, Step, fixed_codes
from casebuilder.senses import BEHIND_THE_FENCE, BOTH_SIDES
from casebuilder.valid import scaled_world
from casebuilder.valid_proofs import in_a_box
from casebuilder.world import Shape, World, grid
from casebuilder.worlds import (
    BUILDING,
    EAST,
    GROUND,
    HIDING,
    NORTH,
    POSTER,
    RING,
    SINGLE,
    SOUTH,
    UPPER,
    WALL,
    WEST,
    with_degenerate_face,
)

WALK = "walk.vep"
AROUND = (Step(WEST, base=KEY), *(Step(cell) for cell in (SOUTH, EAST, UPPER, EAST, NORTH, WEST)))
"""A key frame and a delta for each portal of a way around the wall, with a look from above."""
LEVELS = (
    Step(WEST, base=KEY, levels={0: 2, 1: 1, 3: 1}),
    Step(SOUTH, levels={0: 1, 1: 1, 2: 2, 3: 1}),
    Step(EAST, levels={1: 1, 2: 2, 3: 0}),
    Step(UPPER, levels={0: 2, 1: 2, 2: 2, 3: 2}),
)
"""Objects at several levels, which some of them change on the way."""


def in_code(steps: tuple[Step, ...]) -> tuple[Step, ...]:
    """The same steps with coded bodies."""
    return tuple(replace(step, codec=CODED) for step in steps)


def with_points() -> World:
    """Ring whose poster has faces with two corners in one place, and with all three."""
    a, b = ((grid(0.125), grid(y), grid(1)) for y in (0.5, -0.5))
    ends = tuple(Shape((face,)) for face in ((a, b, a), (a, b, b), (a, a, b), (b, a, a), (a, a, a)))
    poster = replace(POSTER, shapes=(*POSTER.shapes, *ends))
    return replace(RING, objects=(GROUND, WALL, poster, BUILDING))


def _deflated(made: list[Packet]) -> None:
    for packet in made:
        packet.deflate = fixed_codes


def _both(case: Case) -> Iterator[Case]:
    """A case, and the same with coded bodies."""
    assert case.packets is not None
    yield case
    yield replace(
        case,
        name=f"{case.name}-coded",
        made=f"{case.made} The bodies are coded.",
        catches="A decoder of the coded body that has been tried on its own encoder only.",
        packets={name: in_code(steps) for name, steps in case.packets.items()},
    )


def way_cases() -> Iterator[Case]:
    """Ways to send states."""
    yield from _both(
        Case(
            "packets-key-frame",
            RING,
            "A key frame.",
            "A validator that refuses what is right.",
            packets={WALK: (Step(WEST, base=KEY),)},
        )
    )
    yield from _both(
        Case(
            "packets-along-portals",
            RING,
            "A key frame, and a packet for each portal of a way around the wall.",
            "A client that loses its state, or keeps what a packet takes away.",
            packets={WALK: AROUND},
        )
    )
    yield Case(
        "packets-leap",
        RING,
        "A packet that leaps over two cells, and one that applies to the key frame and not to the packet "
        "before it.",
        "A validator that takes cells for neighbours, or every packet for one that applies to the last.",
        packets={WALK: (Step(WEST, base=KEY), Step(EAST), Step(UPPER, base=0), Step(SOUTH, base=1))},
    )
    yield Case(
        "packets-faces-kept",
        RING,
        "A vehicle keeps faces that it does not need any more; the flag exact is not set. The last packet "
        "takes them away, and sets it.",
        "A validator that asks every state to be exact.",
        near=("packet/exact",),
        packets={WALK: (Step(EAST, base=KEY), Step(WEST, exact=False, kept=(4, 5)), Step(WEST))},
    )
    yield Case(
        "packets-exact-unsaid",
        RING,
        "States that hold nothing without need, in packets whose flag exact is not set.",
        "A reader that takes the flag for what it has to be where it may be set.",
        packets={WALK: tuple(replace(step, exact=False) for step in AROUND[:3])},
    )


def body_cases() -> Iterator[Case]:
    """Ways to write bodies and sequences."""
    yield Case(
        "packets-sent-anew",
        RING,
        "Objects that are held are sent whole, in place of a change or of no change at all.",
        "A client that adds to what it holds where it has to replace it.",
        packets={WALK: (Step(WEST, base=KEY), Step(SOUTH, anew=(0, 3)), Step(EAST, anew=(0, 1, 3)))},
    )
    yield Case(
        "packets-nothing-changes",
        RING,
        "A packet without a change from a cell to itself, then a key frame for it.",
        "A decoder that takes an empty list for the end of the file.",
        packets={WALK: (Step(WEST, base=KEY), Step(WEST), Step(WEST, base=KEY))},
    )
    yield Case(
        "packets-worked-example",
        HIDING,
        "A key frame with a sheet that cannot be seen, and a packet with which it goes.",
        "A reader whose bytes are others than those of the specification.",
        packets={WALK: (Step(0, base=KEY, exact=False, kept=(4, 5)), Step(0))},
        proofs=in_a_box,
    )
    yield Case(
        "packets-both-codecs",
        RING,
        "Plain and coded bodies in one sequence.",
        "A codec that keeps what it has learnt from one packet to the next.",
        packets={WALK: tuple(replace(step, codec=i % 2) for i, step in enumerate(AROUND))},
    )
    yield Case(
        "packets-deflated",
        RING,
        "Plain bodies in the fixed codes of deflate.",
        "A decoder that knows stored blocks only, as most of these cases have them.",
        packets={WALK: AROUND[:3]},
        packet=_deflated,
    )
    yield Case(
        "packets-two-files",
        RING,
        "Two sequences, each with a key frame of its own.",
        "A validator that follows the first file only, or carries the state of one over to the other.",
        packets={WALK: AROUND[:2], "other.vep": (Step(UPPER, base=KEY), Step(EAST))},
    )


def form_cases() -> Iterator[Case]:
    """What objects and faces may be like."""
    yield from _both(
        Case(
            "packets-levels",
            RING,
            "Objects at three levels, which some of them change on the way.",
            "A face that is sought in the content of level 0, whatever its level.",
            coarse=two_levels,
            packets={WALK: LEVELS},
        )
    )
    yield Case(
        "packets-faces-stand-for-many",
        RING,
        "Coarse faces of which each stands for every face of its object: one visible face asks for all.",
        "A packet with one coarse face for each face of the set.",
        coarse=faces_for_many,
        packets={WALK: (Step(WEST, base=KEY, levels=dict.fromkeys(range(4), 1)),)},
    )
    yield from _both(
        Case(
            "packets-porous",
            BEHIND_THE_FENCE,
            "Porous objects have their flag.",
            "Flags that are counted over a content in place of the tileset.",
            packets={WALK: (Step(0, base=KEY),)},
        )
    )
    yield Case(
        "packets-one-sided",
        BOTH_SIDES,
        "A one-sided wall that comes and goes.",
        "Flags that are left out with the first key frame that has none.",
        packets={WALK: (Step(1, base=KEY), Step(0), Step(1))},
    )
    yield from _both(
        Case(
            "packets-corners-coincide",
            with_points(),
            "Faces with two corners, or three, in one place.",
            "Corners that are sorted in place of turned, or turned to another of the smallest ones.",
            packets={
                WALK: (Step(EAST, base=KEY, exact=False, kept=(6, 7, 8, 9, 10)), Step(EAST), Step(WEST))
            },
        )
    )
    yield Case(
        "packets-degenerate-face",
        with_degenerate_face(),
        "A face without area in the middle of its object.",
        "A sender that drops such faces and so shifts the numbers behind them.",
        packets={WALK: (Step(EAST, base=KEY, exact=False, kept=(4,)), Step(EAST))},
    )


def limit_cases() -> Iterator[Case]:
    """Limits that are only just kept."""
    far = (2**23 - 1) * 2.0**-10
    yield from _both(
        Case(
            "packets-grid-limit",
            scaled_world(-10, 1.0, far),
            "A corner of 2^23 - 1 steps.",
            "Differences of corners in 23 bits and a sign.",
            packets={WALK: (Step(0, base=KEY),)},
        )
    )
    yield Case(
        "packets-last-cell",
        RING,
        "The last cell, before and after.",
        "A limit that is drawn too tight.",
        near=("packet/cells",),
        packets={WALK: (Step(UPPER, base=KEY), Step(UPPER), Step(EAST))},
    )
    yield from _both(
        Case(
            "packets-empty-state",
            replace(SINGLE, max_range=0.25),
            "A cell from which nothing can be seen: a state without an object.",
            "A state without objects that is taken for no state.",
            packets={WALK: (Step(0, base=KEY, exact=False, kept=(0,)), Step(0))},
        )
    )


def valid_cases() -> Iterator[Case]:
    """All valid cases with packets."""
    yield from way_cases()
    yield from body_cases()
    yield from form_cases()
    yield from limit_cases()
