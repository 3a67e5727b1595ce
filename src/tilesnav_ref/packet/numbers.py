"""Which held faces leave, and which numbers the faces that enter have."""

from __future__ import annotations

from typing import Any

from tilesnav_ref.kernels import kernel
from tilesnav_ref.packet.coder import FAILED, NUMBER_CONTEXTS, code_bit, code_number

LEAVES_CONTEXTS = 2
PLACES_CONTEXTS = 2 * 8 + 8 * NUMBER_CONTEXTS
LARGEST_NUMBER = (1 << 24) - 1
"""Of faces and of objects."""


@kernel
def code_leaving(coder: Any, first: Any, count: Any, leaves: Any) -> Any:
    """Code which faces leave.

    Parameters
    ----------
    coder : tuple
    first : int
        The first of LEAVES_CONTEXTS contexts.
    count : int
        Number of faces that leave.
    leaves : (H,) int64
        1 for each held face that leaves, else 0; filled when reading.
    """
    last = 0
    for i in range(len(leaves)):
        if count == 0:
            leaves[i] = 0
            continue
        if count == len(leaves) - i:
            leaves[i] = 1
            count -= 1
            continue
        bit = code_bit(coder, first + last, leaves[i])
        leaves[i] = bit
        count -= bit
        last = bit


@kernel
def code_places(coder: Any, first: Any, held: Any, numbers: Any) -> Any:
    """Code the numbers of entering faces among those of held ones, all in the order of their places in space.

    Parameters
    ----------
    coder : tuple
    first : int
        The first of PLACES_CONTEXTS contexts.
    held : (N,) int64
        Number of a held face, or -1 for a face that enters.
    numbers : (N,) int64
        Number of each face; filled for those that enter when reading.
    """
    following, waiting = -1, 0
    expected = 0
    for i in range(len(held)):
        if held[i] >= 0:
            expected = held[i] + 1
            continue
        if following < i:
            following, waiting = i, 0
            while following < len(held) and held[following] < 0:
                following += 1
                waiting += 1
        room = 7
        if following < len(held):
            room = min(max(held[following] - expected - waiting + 1, 0), 6)
        waiting -= 1
        difference = numbers[i] - expected
        if code_bit(coder, first + room, 1 if difference != 0 else 0):
            negative = code_bit(coder, first + 8 + room, 1 if difference < 0 else 0)
            size = code_number(coder, first + 16 + room * NUMBER_CONTEXTS, abs(difference) - 1) + 1
            difference = -size if negative else size
        else:
            difference = 0
        numbers[i] = expected + difference
        if numbers[i] < 0 or numbers[i] > LARGEST_NUMBER:
            coder[0][FAILED] = 1
            return
        expected = numbers[i] + 1
