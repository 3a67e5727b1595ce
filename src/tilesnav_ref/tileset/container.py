"""The nav file's container: a header of 24 bytes, a JSON part and a binary part of tables."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

MAGIC = b"nav1"
VERSION = 1
ALIGNMENT = 8
COUNT_LIMIT = 1 << 31
"""Readers refuse larger counts."""


class TablePool:
    """Collects tables as buffer views of one buffer, each at a multiple of 8 bytes."""

    def __init__(self) -> None:
        self._chunks: list[bytes] = []
        self._length = 0
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
        self._chunks.append(b"\0" * (-self._length % ALIGNMENT))
        self._length += len(self._chunks[-1])
        self.views.append({"buffer": 0, "byteOffset": self._length, "byteLength": stored.nbytes})
        self._chunks.append(stored.tobytes())
        self._length += stored.nbytes
        return len(self.views) - 1

    def binary(self) -> bytes:
        """The buffer, before padding."""
        return b"".join(self._chunks)


def pack_nav_file(pool: TablePool, members: Mapping[str, Any]) -> bytes:
    """Put header, JSON part and binary part together.

    Parameters
    ----------
    pool : TablePool
        The tables.
    members : mapping
        ``sector``, ``cells``, ``portals``, ``pvs``, ``lod`` and ``deltas`` with buffer view numbers for
        tables.

    Returns
    -------
    bytes
        The nav file.
    """
    binary = pool.binary()
    document = {"buffers": [{"byteLength": len(binary)}], "bufferViews": pool.views, **members}
    text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % ALIGNMENT)
    binary += b"\0" * (-len(binary) % ALIGNMENT)
    return struct.pack("<4sIQQ", MAGIC, VERSION, len(text), len(binary)) + text + binary
