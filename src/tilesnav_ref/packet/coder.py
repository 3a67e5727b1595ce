"""Adaptive binary range coder: one set of kernels writes or reads, so that both sides follow the same models.

References
----------
G. N. N. Martin, Range encoding: an algorithm for removing redundancy from a digitised message, 1979.
R. Krichevsky, V. Trofimov, The performance of universal encoding, 1981 (estimates that learn fast at first).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tilesnav_ref.kernels import plain_inner_kernel, plain_kernel

LOW, RANGE, CODE, PLACE, LENGTH, READING, FAILED = range(7)
"""Words of a coder."""
TOP = 1 << 24
"""The range is kept at or above this, so that 16 bits of a probability never make it empty."""
ONE = 1 << 16
"""Probabilities are multiples of 1 / ONE."""
LEAST = 32
"""Probabilities stay this far from 0 and from ONE."""
PATIENCE = 60
"""Number of bits after which a probability learns no slower."""
SHARES = (1 << 32) // (2 * np.arange(PATIENCE + 1, dtype=np.int64) + 3) + 1
"""2^32 / (2 n + 3), made greater by one at most: (v * SHARES[n]) >> 32 is v // (2 n + 3) for 0 <= v <= 2^17,
as the product is greater than v 2^32 / (2 n + 3) by 2^17 at most. A division takes several times as long."""


def new_coder(data: Any, reading: bool, probabilities: Any) -> Any:
    """Return a coder: words, data, and (C, 2) the probability of zero and number of bits of each context.

    Parameters
    ----------
    data : (L,) uint8
        To read from, or to write to.
    reading : bool
    probabilities : (C,) int64
        At the beginning, of each context.
    """
    words = np.zeros(7, np.int64)
    words[RANGE] = (1 << 32) - 1
    words[LENGTH] = len(data)
    words[READING] = reading
    if reading:
        data = np.array(data)  # kernels want what can be written, reading or not
        for _ in range(4):
            words[CODE] = words[CODE] << 8 | _first_byte(words, data)
    contexts = np.zeros((len(probabilities), 2), np.int32)
    contexts[:, 0] = probabilities
    return words, data, contexts


def _first_byte(words: Any, data: Any) -> int:
    place = int(words[PLACE])
    words[PLACE] += 1
    return int(data[place]) if place < len(data) else 0


@plain_kernel
def shift(words: Any, data: Any) -> Any:
    """Move one byte out of the range, or into it."""
    place = words[PLACE]
    words[PLACE] = place + 1
    words[RANGE] <<= 8
    if words[READING]:
        byte = np.int64(0)
        if place < words[LENGTH]:
            byte = np.int64(data[place])
        elif place >= words[LENGTH] + 3:
            words[FAILED] = 1
        words[CODE] = words[CODE] << 8 | byte
        return
    if place >= words[LENGTH]:
        words[FAILED] = 1
        words[PLACE] = place
    else:
        data[place] = words[LOW] >> 24
    words[LOW] = (words[LOW] & (TOP - 1)) << 8


@plain_kernel
def carry(words: Any, data: Any) -> Any:
    """Add the bit that ran over the top of the range to the bytes already written."""
    words[LOW] &= (1 << 32) - 1
    place = words[PLACE] - 1
    while data[place] == 255:
        data[place] = 0
        place -= 1
    data[place] += 1


@plain_inner_kernel
def split(words: Any, data: Any, bound: Any, bit: Any) -> Any:
    """Code a bit whose zero has the lower `bound` of the range; returns it."""
    if words[READING]:
        bit = 1 if words[CODE] >= bound else 0
        if bit:
            words[CODE] -= bound
    elif bit:
        words[LOW] += bound
        if words[LOW] >> 32:
            carry(words, data)
    words[RANGE] = words[RANGE] - bound if bit else bound
    while words[RANGE] < TOP:
        shift(words, data)
    return bit


@plain_inner_kernel
def code_bit(coder: Any, context: Any, bit: Any) -> Any:
    """Code a bit in a context, and learn from it; returns it."""
    words, data, contexts = coder
    zero = np.int64(contexts[context, 0])
    bit = split(words, data, (words[RANGE] >> 16) * zero, bit)
    n = contexts[context, 1]
    if bit:
        zero -= (2 * zero * SHARES[n]) >> 32
    else:
        zero += (2 * (ONE - zero) * SHARES[n]) >> 32
    contexts[context, 0] = min(max(zero, LEAST), ONE - LEAST)
    if n < PATIENCE:
        contexts[context, 1] = n + 1
    return bit


NUMBER_CONTEXTS = 75
"""Contexts of a number: 25 of its width, 25 of its second bit, 25 of its bits by place."""


@plain_kernel
def code_number(coder: Any, first: Any, value: Any) -> Any:
    """Code a number from 0 to 2**25 - 2 in contexts from `first` on; returns it."""
    value += 1
    width = 0
    while width < 24:
        if not code_bit(coder, first + width, 1 if value >> width > 1 else 0):
            break
        width += 1
    found = 1
    for place in range(width - 1, -1, -1):
        context = first + 25 + width if place == width - 1 else first + 50 + place
        found = found << 1 | code_bit(coder, context, value >> place & 1)
    return found - 1


@plain_kernel
def code_numbers(coder: Any, first: Any, values: Any) -> Any:
    """Code numbers, each in the same contexts; `values` (N,) int64 is filled when reading."""
    for i in range(len(values)):
        values[i] = code_number(coder, first, values[i])


@plain_kernel
def code_signed(coder: Any, first: Any, value: Any) -> Any:
    """Code a number other than 0 of magnitude below 2**25; returns it."""
    negative = code_bit(coder, first, 1 if value < 0 else 0)
    magnitude = code_number(coder, first + 1, abs(value) - 1) + 1
    return -magnitude if negative else magnitude


def finish(coder: Any) -> bytes:
    """Bytes that were written.

    One byte behind those that were shifted out is enough: a multiple of TOP lies in every range.
    """
    words, data = coder[0], coder[1]
    words[LOW] += TOP - 1
    if words[LOW] >> 32:
        carry(words, data)
    return bytes(data[: int(words[PLACE])]) + bytes((int(words[LOW]) >> 24,))


def is_finished(coder: Any) -> bool:
    """Whether all that was read, and no more, was written by `finish`."""
    words = coder[0]
    return not words[FAILED] and bool(words[PLACE] == words[LENGTH] + 3)
