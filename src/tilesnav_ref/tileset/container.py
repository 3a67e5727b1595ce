"""The nav file's container: a header of 24 bytes, a JSON part and a binary part of tables."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Buffer = bytes | memoryview

MAGIC = b"nav1"
VERSION = 1
ALIGNMENT = 8
COUNT_LIMIT = 1 << 31
"""Readers refuse larger counts."""


class TablePool:
    """Collects tables as buffer views of one buffer, each at a multiple of 8 bytes."""

    def __init__(self) -> None:
        self.chunks: list[Buffer] = []
        """The buffer in parts; tables that have the type of the file already are not copied."""
        self.length = 0
        """Bytes of the buffer, before padding."""
        self.views: list[dict[str, int]] = []

    def add(self, table: NDArray[Any], dtype: str) -> int:
        """Append a table and return the number of its buffer view.

        Parameters
        ----------
        table : array of any shape, C order in the file
        dtype : str
            Little-endian element type such as ``"<u4"``.

        Raises
        ------
        OverflowError
            When an element does not fit the type.
        """
        elements = np.asarray(table)
        stored = np.ascontiguousarray(elements, dtype=dtype)
        if not np.array_equal(stored, elements):
            raise OverflowError(f"a table of the nav file has an element that does not fit {dtype}")
        gap = -self.length % ALIGNMENT
        self.views.append({"buffer": 0, "byteOffset": self.length + gap, "byteLength": stored.nbytes})
        self.chunks += [b"\0" * gap, stored.reshape(-1).view(np.uint8).data]
        self.length += gap + stored.nbytes
        return len(self.views) - 1


def nav_file_parts(pool: TablePool, members: Mapping[str, Any], magic: bytes = MAGIC) -> list[Buffer]:
    """Put header, JSON part and binary part together.

    Parameters
    ----------
    pool : TablePool
        The tables.
    members : mapping
        ``sector``, ``cells``, ``portals``, ``pvs``, ``lod`` and ``deltas`` with buffer view numbers for
        tables.
    magic : bytes
        The first four bytes.

    Returns
    -------
    list of bytes or memoryview
        The nav file, to be written one behind the other.
    """
    document = {"buffers": [{"byteLength": pool.length}], "bufferViews": pool.views, **members}
    text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % ALIGNMENT)
    padding = b"\0" * (-pool.length % ALIGNMENT)
    header = struct.pack("<4sIQQ", magic, VERSION, len(text), pool.length + len(padding))
    return [header, text, *pool.chunks, padding]
