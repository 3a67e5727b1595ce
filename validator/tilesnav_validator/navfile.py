"""Containers, those of nav files above all: header, JSON part, binary part, tables. Bounds come before
everything."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator import strictjson
from tilesnav_validator.findings import Finding

HEADER = struct.Struct("<4sIQQ")
_JSON_PADDING = re.compile(rb"(\r?\n)? *")
"""A line end is part of the JSON text; only spaces may follow it."""
ALIGNMENT = 8


@dataclass(frozen=True)
class TableType:
    """Element type of a table and the name of its number of elements."""

    dtype: str
    shape: tuple[int, ...]
    count: str

    @property
    def item_bytes(self) -> int:
        """Bytes of one element."""
        return int(np.dtype(self.dtype).itemsize * np.prod(self.shape, dtype=np.int64))


TABLES = {
    "cells/planes": TableType("<f8", (6, 4), "cells"),
    "cells/kinds": TableType("u1", (), "cells"),
    "portals/offsets": TableType("<u4", (), "cells+1"),
    "portals/targets": TableType("<u4", (), "portals"),
    "portals/polygons": TableType("<u4", (), "portals"),
    "portals/polygonOffsets": TableType("<u4", (), "polygons+1"),
    "portals/vertices": TableType("<f8", (3,), "vertices"),
    "pvs/offsets": TableType("<u4", (), "cells+1"),
    "pvs/faces": TableType("<u4", (), "pvs"),
    "pvs/provenVisible": TableType("<u4", (), "cells"),
    "pvs/digests": TableType("u1", (32,), "cells"),
    "lod/offsets": TableType("<u4", (), "cells+1"),
    "lod/objects": TableType("<u4", (), "lod"),
    "lod/codes": TableType("u1", (), "lod"),
    "deltas/enteredOffsets": TableType("<u4", (), "portals+1"),
    "deltas/entered": TableType("<u4", (), "entered"),
    "deltas/leftOffsets": TableType("<u4", (), "portals+1"),
    "deltas/left": TableType("<u4", (), "left"),
    "deltas/switchOffsets": TableType("<u4", (), "portals+1"),
    "deltas/switchObjects": TableType("<u4", (), "switches"),
    "deltas/switchCodes": TableType("u1", (), "switches"),
}
"""Tables of a nav file by group and member, as the specification lists them."""

RAGGED = {
    "portals/offsets": "portals",
    "portals/polygonOffsets": "vertices",
    "pvs/offsets": "pvs",
    "lod/offsets": "lod",
    "deltas/enteredOffsets": "entered",
    "deltas/leftOffsets": "left",
    "deltas/switchOffsets": "switches",
}
"""Tables of offsets, with the name of the number that they end with."""

_COUNTS = {
    "cells": ("sector", "cellCount"),
    "portals": ("portals", "count"),
    "polygons": ("portals", "polygonCount"),
    "vertices": ("portals", "vertexCount"),
    "pvs": ("pvs", "count"),
    "lod": ("lod", "count"),
    "entered": ("deltas", "enteredCount"),
    "left": ("deltas", "leftCount"),
    "switches": ("deltas", "switchCount"),
}


@dataclass(frozen=True)
class Layout:
    """What tells one kind of container from another.

    Attributes
    ----------
    magic : bytes
        The first four bytes.
    tables : dict
        Tables by group and member.
    ragged : dict
        Tables of offsets, with the name of the number that they end with.
    counts : dict
        Group and member of the JSON part that state a number of elements.
    """

    magic: bytes
    tables: dict[str, TableType]
    ragged: dict[str, str]
    counts: dict[str, tuple[str, str]]


NAV = Layout(b"nav1", TABLES, RAGGED, _COUNTS)


class NavFile:
    """A nav file, or another container, in memory. Later members may be used only after the checks of
    earlier ones.

    Parameters
    ----------
    name : str
        Its uri, for findings.
    data : memoryview
        The whole file.
    layout : Layout
        Which kind of container it is said to be.
    """

    def __init__(self, name: str, data: memoryview, layout: Layout = NAV) -> None:
        self.name = name
        self.data = data
        self.layout = layout
        self.json: Any = None

    @property
    def json_bytes(self) -> int:
        """Length of the JSON part, from the header."""
        return int(HEADER.unpack_from(self.data)[2])

    @property
    def binary_bytes(self) -> int:
        """Length of the binary part with padding, from the header."""
        return int(HEADER.unpack_from(self.data)[3])

    def header_fault(self) -> Finding | None:
        """First fault of the header, if any."""
        if len(self.data) < HEADER.size:
            return Finding(self.name, f"{len(self.data)} bytes", f"at least {HEADER.size} bytes")
        magic, version, json_bytes, binary_bytes = HEADER.unpack_from(self.data)
        if magic != self.layout.magic:
            return Finding(f"{self.name} byte 0", f"magic {magic!r}", f"{self.layout.magic!r}")
        if version != 1:
            return Finding(f"{self.name} byte 4", f"version {version}", "1")
        if HEADER.size + json_bytes + binary_bytes != len(self.data):
            stated = f"24 + {json_bytes} + {binary_bytes} bytes in the header"
            return Finding(f"{self.name} byte 8", stated, f"{len(self.data)}, the length of the file")
        return None

    def parse(self) -> None:
        """Parse the JSON part into ``json``; zero bytes behind it are left to the check of padding.

        Raises
        ------
        strictjson.JsonError
            If it is not JSON.
        """
        stop = HEADER.size + self.json_bytes
        while stop > HEADER.size and self.data[stop - 1] in b" \0":
            stop -= 1
        self.json = strictjson.parse_view(self.data, HEADER.size, stop)

    def padding_faults(self) -> Iterator[Finding]:
        """Faults of the padding; that of the binary part begins where the buffer of the JSON part ends."""
        start = HEADER.size + self.json_bytes
        for part, length in (("JSON", self.json_bytes), ("binary", self.binary_bytes)):
            if length % ALIGNMENT:
                yield Finding(f"{self.name} {part} part", f"{length} bytes", f"a multiple of {ALIGNMENT}")
        tail = bytes(self.data[max(HEADER.size, start - 64) : start])
        padding = tail[len(tail.rstrip(b" \t\r\n\0")) :]
        if not _JSON_PADDING.fullmatch(padding):
            yield Finding(
                f"{self.name} byte {start - len(padding)}", f"padding {padding.hex(' ')}", "20 only"
            )
        end = int(self.json["buffers"][0]["byteLength"])
        if end <= self.binary_bytes < end + ALIGNMENT:
            padding = bytes(self.data[start + end :])
            if padding.strip(b"\0"):
                yield Finding(f"{self.name} byte {start + end}", f"padding {padding.hex()}", "zero bytes")

    def count(self, name: str) -> int:
        """Number of elements by its name in the layout; a name with ``+1`` is one more."""
        group, member = self.layout.counts[name.removesuffix("+1")]
        return int(self.json[group][member]) + name.endswith("+1")

    def view_of(self, table: str) -> int:
        """Index of the buffer view of a table."""
        group, member = table.split("/")
        return int(self.json[group][member])

    def view(self, index: int) -> tuple[int, int]:
        """Offset and length in bytes of a buffer view."""
        view = self.json["bufferViews"][index]
        return int(view["byteOffset"]), int(view["byteLength"])

    def table(self, name: str) -> NDArray[Any]:
        """Elements of a table, without a copy; only after the checks of views and lengths."""
        kind = self.layout.tables[name]
        offset, length = self.view(self.view_of(name))
        start = HEADER.size + self.json_bytes + offset
        flat = np.frombuffer(self.data[start : start + length], dtype=kind.dtype)
        return flat.reshape(-1, *kind.shape)
