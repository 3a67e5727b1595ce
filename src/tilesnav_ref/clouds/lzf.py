"""Expansion of LZF blocks.

References
----------
M. Lehmann, liblzf 3.6, lzf_d.c: runs of literals (a byte below 32: count less one) and copies (three bits of
length less two, thirteen of distance less one; length 7 takes another byte).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel


@kernel
def expand(block: NDArray[np.uint8], out: NDArray[np.uint8]) -> int:
    """Write what a block stands for; return the number of bytes, -1 for a broken block.

    Nothing is read or written outside of the arrays, whatever the block holds.
    """
    at = done = 0
    while at < len(block):
        control = int(block[at])
        at += 1
        if control < 32:
            count = control + 1
            if at + count > len(block) or done + count > len(out):
                return -1
            out[done : done + count] = block[at : at + count]
            at += count
            done += count
            continue
        length = control >> 5
        if length == 7:
            if at >= len(block):
                return -1
            length += int(block[at])
            at += 1
        if at >= len(block):
            return -1
        source = done - ((control & 31) << 8) - int(block[at]) - 1
        at += 1
        if source < 0 or done + length + 2 > len(out):
            return -1
        for k in range(length + 2):  # byte by byte: a copy may read what it has just written
            out[done + k] = out[source + k]
        done += length + 2
    return done
