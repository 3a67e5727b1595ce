"""Invalid states: potentially visible sets, level codes and totals."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from casebuilder.edits import Edits, adding, edits, whole_table
from casebuilder.state import State, lower_pvs, object_codes
from casebuilder.world import World
from casebuilder.worlds import EAST, RING, SINGLE, SLANTED, SOUTH, TOUCHING, UPPER, WEST

States = list[State]
WALL_FACE, POSTER_FACE, BUILDING_FACE, ROOF_FACE = 2, 4, 6, 16
POSTER, BUILDING = 2, 3


def _swap_faces(states: States) -> None:
    faces = states[WEST].faces
    faces[0], faces[1] = faces[1], faces[0]


def _twice(states: States) -> None:
    states[WEST].faces.insert(0, states[WEST].faces[0])


def _off_by_one(states: States) -> None:
    moved = states[SOUTH].faces.pop(0)
    states[SOUTH].proven -= 1
    states[WEST].faces.append(moved)
    states[SOUTH].codes = object_codes(RING, RING.cells[SOUTH], states[SOUTH].faces)


def _no_such_face(states: States) -> None:
    states[0].faces[-1] = len(SINGLE.faces)


def _byte_swap(states: States) -> None:
    states[0].faces = np.array(states[0].faces, dtype="<u4").byteswap().tolist()


def _too_many_proven(states: States) -> None:
    states[WEST].proven = len(states[WEST].faces) + 1


def _swap_digests(digests: np.ndarray) -> np.ndarray:
    return np.concatenate((digests[32:64], digests[:32], digests[64:]))


def _flip_bit(digests: np.ndarray) -> np.ndarray:
    return np.concatenate((digests[:1] ^ 1, digests[1:]))


SETS: dict[str, Edits] = {
    "pvs/sorted-faces/not-ascending": edits(states=_swap_faces),
    "pvs/sorted-faces/listed-twice": edits(states=_twice),
    "pvs/sorted-faces/offset-off-by-one": edits(states=_off_by_one),
    "pvs/sorted-faces/no-such-face": edits(world=SINGLE, states=_no_such_face),
    "pvs/sorted-faces/big-endian": edits(world=SINGLE, states=_byte_swap),
    "pvs/proven-within-listed/more-than-listed": edits(states=_too_many_proven),
    "pvs/digest/one-bit": edits(tables=whole_table("pvs.digests", _flip_bit)),
    "pvs/digest/of-another-cell": edits(tables=whole_table("pvs.digests", _swap_digests)),
}


def _dropped(cell: int, face: int, world: World = RING) -> Callable[[States], None]:
    return lambda states: lower_pvs(world, states, cell, face)


MISSING: dict[str, Edits] = {
    "pvs/conservative/near-face-missing": edits(states=_dropped(EAST, POSTER_FACE)),
    "pvs/conservative/face-round-the-corner-missing": edits(states=_dropped(WEST, BUILDING_FACE)),
    "pvs/conservative/roof-missing": edits(states=_dropped(UPPER, ROOF_FACE)),
    "pvs/conservative/edge-on-wall-missing": edits(states=_dropped(SOUTH, WALL_FACE)),
    "pvs/conservative/slanted-cell": edits(world=SLANTED, states=_dropped(5, ROOF_FACE, SLANTED)),
    "pvs/conservative/touched-wall-missing": edits(
        world=TOUCHING, states=_dropped(WEST, WALL_FACE, TOUCHING)
    ),
}


def _code(cell: int, item: int, change: int) -> Callable[[States], None]:
    def edit(states: States) -> None:
        states[cell].codes[item] += change

    return edit


def _add_object(states: States) -> None:
    states[WEST].codes = dict(sorted({**states[WEST].codes, POSTER: 4}.items()))


def _drop_object(states: States) -> None:
    del states[EAST].codes[BUILDING]


def _reverse_objects(states: States) -> None:
    states[WEST].codes = dict(reversed(states[WEST].codes.items()))


def _all_finest(states: States) -> None:
    for state in states:
        state.codes = dict.fromkeys(state.codes, 0)


LEVELS: dict[str, Edits] = {
    "lod/objects-match/object-missing": edits(states=_drop_object),
    "lod/objects-match/object-too-many": edits(states=_add_object),
    "lod/objects-match/not-ascending": edits(states=_reverse_objects),
    "lod/code-range/code-16": edits(states=_code(WEST, BUILDING, 12)),
    "lod/fine-enough/one-too-large": edits(states=_code(EAST, BUILDING, 1)),
    "lod/fine-enough/from-the-centre": edits(states=_code(WEST, 0, 2)),
    "lod/fine-enough/slanted-cell": edits(world=SLANTED, states=_code(5, BUILDING, 1)),
    "lod/not-wasteful/two-too-small": edits(states=_code(WEST, BUILDING, -2)),
    "lod/not-wasteful/all-finest": edits(states=_all_finest),
}

TOTALS: dict[str, Edits] = {
    "provenance/totals/listed": edits(entry=adding("pvs", "listed", amount=1)),
    "provenance/totals/proven-visible": edits(entry=adding("pvs", "provenVisible", amount=-1)),
}

CASES = SETS | MISSING | LEVELS | TOTALS
