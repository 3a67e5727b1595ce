"""Scenes and cases about what is porous, one-sided or out of range.

The fence: a cell looks through a porous fence and a porous hedge at the wall of a house, which hides a card
behind it. The one-sided wall: the cell before its front sees it, the one behind does not, and it hides the
poster on its front from the latter all the same. The range: of two panels, one is exactly as far away as the
range says, the other an eighth of a metre nearer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from casebuilder.assemble import Case
from casebuilder.edits import Edits, edits, setting
from casebuilder.invalid_core import CHILD_1, FACTS
from casebuilder.state import State, lower_pvs
from casebuilder.world import IDENTITY, Object, World, box_cell, quad
from casebuilder.worlds import GROUND, POSTER, SINGLE, WALL

FENCE = Object(0, (quad((0, -4, 0), (0, 4, 0), (0, 4, 4), (0, -4, 4)),), porous=True)
HOUSE = Object(1, (quad((-2, -1, 0.5), (-2, 1, 0.5), (-2, 1, 3.5), (-2, -1, 3.5)),))
CARD = Object(1, (quad((-3, -0.25, 1), (-3, 0.25, 1), (-3, 0.25, 2), (-3, -0.25, 2)),))
HEDGE = Object(1, (quad((-1, -2, 0), (-1, 2, 0), (-1, 2, 1.5), (-1, -2, 1.5)),), porous=True)
BEHIND_THE_FENCE = replace(SINGLE, objects=(GROUND, FENCE, HOUSE, CARD, HEDGE))
FENCE_FACE, HOUSE_FACE, HEDGE_FACE = 2, 4, 8

BOTH_SIDES = World(
    (GROUND, replace(WALL, one_sided=True), POSTER),
    (box_cell((1, -1, 0.5), (3, 1, 2)), box_cell((-3, -1, 0.5), (-1, 1, 2))),
    transform=IDENTITY,
)
FRONT, WALL_FACE = 0, 2

AT_THE_RANGE = Object(0, (quad((8, 0, 0.5), (8, 1, 0.5), (8, 1, 2), (8, 0, 2)),))
WITHIN = Object(0, (quad((7.875, -1, 0.5), (7.875, 0, 0.5), (7.875, 0, 2), (7.875, -1, 2)),))
FIVE_METRES = replace(SINGLE, objects=(GROUND, AT_THE_RANGE, WITHIN), max_range=5.0)
WITHIN_FACE = 4


def valid_cases() -> Iterator[Case]:
    """Valid cases of this module."""
    yield Case(
        "porous-fence",
        BEHIND_THE_FENCE,
        "A wall behind two porous objects is listed, what is behind that is not; a porous object is the last "
        "of its content.",
        "A validator that takes what is porous for opaque, or all that is behind it for visible.",
        near=("core/object-flags",),
    )
    yield Case(
        "one-sided-wall",
        BOTH_SIDES,
        "A cell behind a one-sided wall lists neither the wall nor the poster on its front.",
        "A validator that sees one-sided faces from behind, or through them.",
    )
    yield Case(
        "max-range",
        FIVE_METRES,
        "A panel that is exactly as far from the cell as `visibility.maxRange` says is not listed.",
        "A validator that looks beyond the range, or counts a distance that is equal to it.",
    )
    yield Case(
        "least-range",
        replace(SINGLE, max_range=1e-300),
        "A range within which there is nothing: every PVS is empty.",
        "A reader that asks for more of the range than to be greater than 0.",
        near=("pvs/max-range",),
    )


def _dropped(world: World, cell: int, face: int) -> Callable[[list[State]], None]:
    return lambda states: lower_pvs(world, states, cell, face)


def _flags(member: str, *indices: int) -> Edits:
    change = setting(*CHILD_1, *FACTS, member, value=list(indices))
    return edits(world=BEHIND_THE_FENCE, tileset=change)


CASES: dict[str, Edits] = {
    "core/object-flags/twice": _flags("porous", 2, 2),
    "core/object-flags/no-such-primitive": _flags("porous", 3),
    "core/object-flags/descending": _flags("oneSided", 1, 0),
    "pvs/max-range/zero": edits(entry=setting("visibility", value={"maxRange": 0})),
    "pvs/conservative/behind-a-porous-fence": edits(
        world=BEHIND_THE_FENCE, states=_dropped(BEHIND_THE_FENCE, 0, HOUSE_FACE)
    ),
    "pvs/conservative/porous-fence-missing": edits(
        world=BEHIND_THE_FENCE, states=_dropped(BEHIND_THE_FENCE, 0, FENCE_FACE)
    ),
    "pvs/conservative/hedge-behind-a-fence": edits(
        world=BEHIND_THE_FENCE, states=_dropped(BEHIND_THE_FENCE, 0, HEDGE_FACE)
    ),
    "pvs/conservative/front-of-a-one-sided-wall": edits(
        world=BOTH_SIDES, states=_dropped(BOTH_SIDES, FRONT, WALL_FACE)
    ),
    "pvs/conservative/just-within-the-range": edits(
        world=FIVE_METRES, states=_dropped(FIVE_METRES, 0, WITHIN_FACE)
    ),
}
