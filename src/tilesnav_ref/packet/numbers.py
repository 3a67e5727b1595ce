"""Which held faces leave, and which numbers the faces that enter have."""

from __future__ import annotations

from typing import Any

import numpy as np

from tilesnav_ref.kernels import plain_kernel
from tilesnav_ref.packet.coder import FAILED, NUMBER_CONTEXTS, code_bit, code_number

LEAVES_CONTEXTS = 2
PLACES_CONTEXTS = 2 * 8 + 8 * NUMBER_CONTEXTS
LARGEST_NUMBER = (1 << 24) - 1
"""Of faces and of objects."""


@plain_kernel
def code_leaving(coder: Any, first: Any, count: Any, leaves: Any) -> Any:
    """Code which faces leave.

    Parameters
    ----------
    coder : tuple
    first : int
        The first of LEAVES_CONTEXTS contexts.
    count : int
        Number of faces that leave.
    leaves : (H,) uint8
        1 for each held face that leaves, else 0; filled when reading.
    """
    last = np.int64(0)
    for i in range(len(leaves)):
        if count == 0:
            leaves[i] = 0
            continue
        if count == len(leaves) - i:
            leaves[i] = 1
            count -= 1
            continue
        bit = np.int64(code_bit(coder, first + last, np.int64(leaves[i])))
        leaves[i] = bit
        count -= bit
        last = bit


@plain_kernel
def code_place(coder: Any, first: Any, room: Any, difference: Any) -> Any:
    """Code how far the number of a face is from the one expected; returns it."""
    if not code_bit(coder, first + room, 1 if difference != 0 else 0):
        return 0
    negative = code_bit(coder, first + 8 + room, 1 if difference < 0 else 0)
    size = code_number(coder, first + 16 + room * NUMBER_CONTEXTS, abs(difference) - 1) + 1
    return -size if negative else size


@plain_kernel
def code_places(coder: Any, first: Any, held: Any, entering: Any) -> Any:
    """Code the numbers of entering faces among those of held ones, all in the order of their places in space.

    Parameters
    ----------
    coder : tuple
    first : int
        The first of PLACES_CONTEXTS contexts.
    held : tuple
        Numbers and places of held faces, (H,) and (H,) int64, and their order by place.
    entering : tuple
        Numbers (E,) int64, filled when reading, and places (E,) int64, in the order of their places.
    """
    held_numbers, held_places, order = held
    numbers, places = entering
    h, following, expected = 0, 0, np.int64(0)
    for i in range(len(numbers)):
        while h < len(order) and held_places[order[h]] <= places[i]:
            expected = held_numbers[order[h]] + 1
            h += 1
        room = 7
        if h < len(order):
            while following < len(numbers) and places[following] < held_places[order[h]]:
                following += 1
            room = min(max(held_numbers[order[h]] - expected - (following - i) + 1, 0), 6)
        expected += code_place(coder, first, room, numbers[i] - expected)
        numbers[i] = expected
        if expected < 0 or expected > LARGEST_NUMBER:
            coder[0][FAILED] = 1
            return
        expected += 1
