"""Invalid deltas."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from casebuilder.edits import Edits, edits, in_table
from casebuilder.state import Tables
from casebuilder.worlds import RING


def _slice(table: Tables, name: str, portal: int) -> slice:
    begin, end = (int(v) for v in table[f"deltas.{name}Offsets"][portal : portal + 2])
    return slice(begin, end)


def _reverse(name: str, *lists: str) -> Callable[[list[Tables]], None]:
    def edit(sectors: list[Tables]) -> None:
        table = sectors[0]
        widths = table[f"deltas.{name}Offsets"][1:] - table[f"deltas.{name}Offsets"][:-1]
        part = _slice(table, name, next(i for i, width in enumerate(widths) if width > 1))
        for member in lists:
            table[f"deltas.{member}"][part] = table[f"deltas.{member}"][part][::-1].copy()

    return edit


def _remove(name: str, *lists: str) -> Callable[[list[Tables]], None]:
    def edit(sectors: list[Tables]) -> None:
        table = sectors[0]
        offsets = table[f"deltas.{name}Offsets"]
        portal = next(i for i in range(len(offsets) - 1) if offsets[i + 1] > offsets[i])
        part = _slice(table, name, portal)
        for member in lists:
            values = table[f"deltas.{member}"]
            table[f"deltas.{member}"] = values[
                [i for i in range(len(values)) if not part.start <= i < part.stop]
            ]
        offsets[portal + 1 :] -= offsets[portal + 1] - offsets[portal]

    return edit


def _swap_sides(sectors: list[Tables]) -> None:
    table = sectors[0]
    for a, b in (("deltas.entered", "deltas.left"), ("deltas.enteredOffsets", "deltas.leftOffsets")):
        table[a], table[b] = table[b], table[a]


def _send_again(sectors: list[Tables]) -> None:
    # The ground is in the PVS of every cell, so no delta says that it enters.
    table = sectors[0]
    entered, offsets = table["deltas.entered"], table["deltas.enteredOffsets"]
    table["deltas.entered"] = np.concatenate(([0], entered)).astype("<u4")
    offsets[1:] += 1


def _wrong_switch(sectors: list[Tables]) -> None:
    table = sectors[0]
    table["deltas.switchCodes"][0] += 1


CASES: dict[str, Edits] = {
    "delta/sorted/entered": edits(tables=_reverse("entered", "entered")),
    "delta/sorted/left": edits(tables=_reverse("left", "left")),
    "delta/sorted/switches": edits(tables=_reverse("switch", "switchObjects", "switchCodes")),
    "delta/sorted/no-such-face": edits(tables=in_table("deltas.entered", -1, len(RING.faces))),
    "delta/identity/delta-skipped": edits(tables=_remove("entered", "entered")),
    "delta/identity/left-skipped": edits(tables=_remove("left", "left")),
    "delta/identity/sides-swapped": edits(tables=_swap_sides),
    "delta/identity/sent-again": edits(tables=_send_again),
    "delta/switches/switch-skipped": edits(tables=_remove("switch", "switchObjects", "switchCodes")),
    "delta/switches/wrong-code": edits(tables=_wrong_switch),
}
