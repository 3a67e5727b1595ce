"""The stream of bits of a coded body: an adaptive binary range decoder, and numbers made of its bits."""

from __future__ import annotations

from tilesnav_validator.packetparts import BodyError

NUMBER = 75
"""Contexts of a block of numbers."""
SIGNED = 1 + NUMBER
MAX_BITS = 2**26
"""Most bits of a body; a few bytes can stand for any number of bits, and each takes about a microsecond."""
_MAX_WIDTH = 24
_FIRST, _OTHERS = 25, 50
"""Where the contexts of the highest bit and of the others of a number begin."""
_LOW, _HIGH = 32, 65504
"""Bounds of a probability, in 2^-16."""
_SETTLED = 60
"""Greatest count of a context."""


class TooManyBitsError(Exception):
    """A body asks for more bits than anybody has time for."""


class Bits:
    """A body that is decoded bit by bit.

    Parameters
    ----------
    body : memoryview
    contexts : int
        Number of contexts.

    Raises
    ------
    BodyError
        Here and from every method, where more bytes are taken than there are.
    """

    def __init__(self, body: memoryview, contexts: int) -> None:
        if not len(body):
            raise BodyError("body", "0 bytes", "one at least")
        self.data = bytes(body) + bytes(3)
        self.taken = 4
        self.code = int.from_bytes(self.data[:4], "big")
        self.range = 2**32 - 1
        self.chances = [32768] * contexts
        self.counts = [0] * contexts
        self.left = MAX_BITS

    def bit(self, context: int) -> int:
        """The next bit, in a context."""
        self.left -= 1
        if self.left < 0:
            raise TooManyBitsError(f"a body of more than {MAX_BITS} bits")
        chance, count = self.chances[context], self.counts[context]
        bound = (self.range >> 16) * chance
        if self.code < bound:
            found = 0
            self.range = bound
            chance += 2 * (65536 - chance) // (2 * count + 3)
        else:
            found = 1
            self.code -= bound
            self.range -= bound
            chance -= 2 * chance // (2 * count + 3)
        while self.range < 2**24:
            self._byte()
        self.chances[context] = min(max(chance, _LOW), _HIGH)
        self.counts[context] = min(count + 1, _SETTLED)
        return found

    def _byte(self) -> None:
        if self.taken == len(self.data):
            raise BodyError("body", f"more than {self.taken - 3} bytes asked for", "no more than there are")
        self.range <<= 8
        self.code = self.code << 8 | self.data[self.taken]
        self.taken += 1

    def number(self, block: int) -> int:
        """A number from 0 to 2^25 - 2, in a block of contexts."""
        width = 0
        while width < _MAX_WIDTH and self.bit(block + width):
            width += 1
        value = 1
        for place in range(width - 1, -1, -1):
            context = _FIRST + width if place == width - 1 else _OTHERS + place
            value = 2 * value + self.bit(block + context)
        return value - 1

    def signed(self, block: int) -> int:
        """A number other than 0, in a block of contexts."""
        negative = self.bit(block)
        size = self.number(block + 1) + 1
        return -size if negative else size

    def need_end(self) -> None:
        """Refuse a body of which not all has been taken."""
        if self.taken != len(self.data):
            rest = len(self.data) - self.taken
            raise BodyError("body", f"{rest} bytes left over", "none")
