"""Stage binary: header, padding, buffer views, tables and counts of the nav files."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from tilesnav_validator.checks import check
from tilesnav_validator.findings import Finding
from tilesnav_validator.navfile import ALIGNMENT, TABLES, NavFile
from tilesnav_validator.subject import Subject
from tilesnav_validator.tiles import EXTENSION

WHOLE = ("container/table-lengths", "container/offsets", "container/sector-counts", "cell/exactly-six-planes")
"""What must hold before tables are used."""


@check("container/header", needs=("core/uri-inside", "core/sector-resolves"))
def header(subject: Subject) -> Iterator[Finding]:
    """Magic, version and lengths."""
    for sector in subject.sectors:
        fault = sector.header_fault()
        if fault:
            yield fault


@check("container/padding", needs=("container/json",))
def padding(subject: Subject) -> Iterator[Finding]:
    """Padding of both parts."""
    for sector in subject.sectors:
        yield from sector.padding_faults()


@check("container/buffer-views", needs=("container/json", "container/padding"))
def buffer_views(subject: Subject) -> Iterator[Finding]:
    """Bounds, alignment and overlap of the buffer views, and the length of the buffer."""
    for sector in subject.sectors:
        yield from view_faults(sector)


def view_faults(sector: NavFile) -> Iterator[Finding]:
    """Faults of the buffer views of one container."""
    length = int(sector.json["buffers"][0]["byteLength"])
    if -(-length // ALIGNMENT) * ALIGNMENT != sector.binary_bytes:
        allowed = f"at most {ALIGNMENT - 1} less than {sector.binary_bytes}, the binary part"
        yield Finding(f"{sector.name}#/buffers/0/byteLength", str(length), allowed)
        return
    taken = []
    for index in range(len(sector.json["bufferViews"])):
        offset, size = sector.view(index)
        where = f"{sector.name}#/bufferViews/{index}"
        room = length if size else sector.binary_bytes  # an empty view may begin where padding ends
        if offset + size > room:
            yield Finding(where, f"bytes {offset} to {offset + size}", f"within the buffer of {length} bytes")
        elif offset % ALIGNMENT:
            yield Finding(f"{where}/byteOffset", str(offset), f"a multiple of {ALIGNMENT}")
        elif size:
            taken.append((offset, offset + size, index))
    taken.sort()
    for (_, end, first), (start, _, second) in pairwise(taken):
        if start < end:
            yield Finding(
                f"{sector.name}#/bufferViews/{second}", f"begins at {start}", f"not within view {first}"
            )


@check("container/table-lengths", needs=("container/buffer-views",))
def table_lengths(subject: Subject) -> Iterator[Finding]:
    """Every table has the length that its count calls for; that of the planes has a requirement of its
    own."""
    for sector in subject.sectors:
        yield from table_faults(sector)


def table_faults(sector: NavFile) -> Iterator[Finding]:
    """Faults of the views that the tables of one container refer to."""
    users: dict[int, str] = {}
    for name, kind in sector.layout.tables.items():
        where, view = f"{sector.name}#/{name}", sector.view_of(name)
        if view >= len(sector.json["bufferViews"]):
            allowed = f"less than {len(sector.json['bufferViews'])}, the number of views"
            yield Finding(where, str(view), allowed)
        elif view in users:
            yield Finding(where, f"buffer view {view}, that of {users[view]}", "a buffer view of its own")
        elif name != "cells/planes":
            wanted = sector.count(kind.count) * kind.item_bytes
            if sector.view(view)[1] != wanted:
                yield Finding(where, f"{sector.view(view)[1]} bytes", f"{wanted} bytes")
        users.setdefault(view, name)


@check("cell/exactly-six-planes", needs=("container/table-lengths",))
def exactly_six_planes(subject: Subject) -> Iterator[Finding]:
    """The length of the table of planes."""
    for sector in subject.sectors:
        size = sector.view(sector.view_of("cells/planes"))[1]
        cells = sector.count("cells")
        if size != cells * TABLES["cells/planes"].item_bytes:
            measured = f"{size} bytes, {size / 32 / cells:.6g} planes for each of {cells} cells"
            yield Finding(f"{sector.name}#/cells/planes", measured, f"{cells * 192} bytes, 6 planes for each")


@check("container/offsets", needs=("container/table-lengths",))
def offsets(subject: Subject) -> Iterator[Finding]:
    """First, last and order of the offsets of ragged tables."""
    for sector in subject.sectors:
        yield from offset_faults(sector)


def offset_faults(sector: NavFile) -> Iterator[Finding]:
    """Faults of the offsets of one container."""
    for name, elements in sector.layout.ragged.items():
        values = sector.table(name).astype(np.int64)
        where, total = f"{sector.name} {name}", sector.count(elements)
        falls = np.flatnonzero(np.diff(values) < 0)
        if values[0] != 0:
            yield Finding(f"{where}[0]", str(values[0]), "0")
        elif falls.size:
            at = int(falls[0]) + 1
            measured = f"{values[at]} after {values[at - 1]}"
            yield Finding(f"{where}[{at}]", measured, "not less than the one before")
        elif values[-1] != total:
            yield Finding(f"{where}[{len(values) - 1}]", str(values[-1]), f"{total}, the number of elements")


@check("container/sector-counts", needs=("container/table-lengths",))
def sector_counts(subject: Subject) -> Iterator[Finding]:
    """Numbering of cells over the sectors, and the sum of portals."""
    next_cell, portals = 0, 0
    entry = f"{subject.entry_name}#/extensions/{EXTENSION}"
    for index, (sector, stated) in enumerate(zip(subject.sectors, subject.nav["sectors"], strict=True)):
        for name in ("firstCell", "cellCount"):
            if sector.json["sector"][name] != stated[name]:
                measured = f"{sector.json['sector'][name]} in the nav file"
                yield Finding(
                    f"{entry}/sectors/{index}/{name}", f"{stated[name]}, {measured}", "the same number"
                )
                return
        if stated["firstCell"] != next_cell:
            yield Finding(f"{entry}/sectors/{index}/firstCell", str(stated["firstCell"]), str(next_cell))
            return
        next_cell += int(stated["cellCount"])
        portals += sector.count("portals")
    for name, total in (("cellCount", next_cell), ("portalCount", portals)):
        if subject.nav[name] != total:
            yield Finding(f"{entry}/{name}", str(subject.nav[name]), f"{total}, the sum over the sectors")
