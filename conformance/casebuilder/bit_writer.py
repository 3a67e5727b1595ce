"""Bits in adaptive contexts, as Annex D has them, written into one long integer."""

from __future__ import annotations

from collections.abc import Hashable


class BitWriter:
    """Collects bits, as an interval [low, low + range) of whole numbers that grow by a byte at a shift."""

    def __init__(self) -> None:
        self.low = 0
        self.range = 2**32 - 1
        self.shifts = 0
        self.contexts: dict[Hashable, tuple[int, int]] = {}

    def bit(self, context: Hashable, value: int) -> None:
        """Write a bit in the context of a name."""
        p, n = self.contexts.get(context, (32768, 0))
        bound = (self.range >> 16) * p
        if value:
            self.low += bound
            self.range -= bound
            p -= (2 * p) // (2 * n + 3)
        else:
            self.range = bound
            p += (2 * (65536 - p)) // (2 * n + 3)
        self.contexts[context] = (min(max(p, 32), 65504), min(n + 1, 60))
        while self.range < 2**24:
            self.range <<= 8
            self.low <<= 8
            self.shifts += 1

    def number(self, block: Hashable, value: int) -> None:
        """Write a number of 0 or more in a block of contexts."""
        digits = bin(value + 1)[3:]
        for place in range(24):
            self.bit((block, "width", place), place < len(digits))
            if place == len(digits):
                break
        for place, digit in enumerate(digits):
            rest = len(digits) - 1 - place
            name = ("first", len(digits)) if place == 0 else ("other", rest)
            self.bit((block, *name), int(digit))

    def signed(self, block: Hashable, value: int) -> None:
        """Write a number other than 0."""
        self.bit((block, "sign"), value < 0)
        self.number((block, "size"), abs(value) - 1)

    def body(self) -> bytes:
        """The bytes: the least number of the interval that ends with three zero bytes, which are left out."""
        return (-(-self.low >> 24)).to_bytes(self.shifts + 1, "big")
