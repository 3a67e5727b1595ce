"""Certificate files: their tables, and what their numbers stand for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator import prisms, ragged
from tilesnav_validator.findings import Finding
from tilesnav_validator.navfile import Layout, NavFile, TableType
from tilesnav_validator.tables import Ragged

IntArray = NDArray[np.int64]

REACH = 2**29
"""Bound of the magnitude of coordinates, in units."""

TABLES = {
    "certificates/cellOffsets": TableType("<u4", (), "cells+1"),
    "certificates/uses": TableType("<u4", (), "uses"),
    "certificates/regions": TableType("<i4", (8,), "certificates"),
    "certificates/shapes": TableType("u1", (), "certificates"),
    "certificates/targetOffsets": TableType("<u4", (), "certificates+1"),
    "certificates/targets": TableType("<u4", (), "targets"),
    "certificates/cutOffsets": TableType("<u4", (), "certificates+1"),
    "certificates/cuts": TableType("u1", (), "cuts"),
    "certificates/leaves": TableType("<u4", (), "leaves"),
    "certificates/occluderOffsets": TableType("<u4", (), "occluders+1"),
    "certificates/occluders": TableType("<u4", (), "occluderFaces"),
}
"""Tables of a certificate file by group and member, as the specification lists them."""

_RAGGED = {
    "certificates/cellOffsets": "uses",
    "certificates/targetOffsets": "targets",
    "certificates/cutOffsets": "cuts",
    "certificates/occluderOffsets": "occluderFaces",
}

_COUNTS = {
    "cells": ("sector", "cellCount"),
    "certificates": ("certificates", "count"),
    "uses": ("certificates", "useCount"),
    "targets": ("certificates", "targetCount"),
    "cuts": ("certificates", "cutCount"),
    "leaves": ("certificates", "leafCount"),
    "occluders": ("certificates", "occluderCount"),
    "occluderFaces": ("certificates", "occluderFaceCount"),
}

CERT = Layout(b"cert", TABLES, _RAGGED, _COUNTS)


@dataclass(frozen=True)
class Certificates:
    """The certificates of a sector with n cells.

    Attributes
    ----------
    name : str
        Uri of the file.
    first_cell : int
        Global number of the cell 0 of the sector.
    origin : ndarray of int64, shape (3,)
        In grid steps.
    subdivision : int
    uses : Ragged
        Certificates of each cell.
    regions : ndarray of int64, shape (p, 8)
        Lower corner, upper corner, p and q of each region, in units.
    shapes : ndarray of int64, shape (p,)
        Which axes a region slants along; 0 for a box.
    targets, cuts : Ragged
        Of each certificate.
    leaves : ndarray of int64, shape (l,)
        Occluder of each leaf.
    occluders : Ragged
        Faces of each occluder.
    """

    name: str
    first_cell: int
    origin: IntArray
    subdivision: int
    uses: Ragged
    regions: IntArray
    shapes: IntArray
    targets: Ragged
    cuts: Ragged
    leaves: IntArray
    occluders: Ragged

    def in_units(self, grid: IntArray) -> IntArray:
        """Positions in grid steps as coordinates of this file, below 2^53 in magnitude."""
        return (grid - self.origin) << self.subdivision

    def corners(self, chosen: IntArray) -> IntArray:
        """Corners of regions, shape (k, 8, 3)."""
        return prisms.corners(self.regions[chosen], self.shapes[chosen])


def read(file: NavFile) -> Certificates:
    """Take the tables of a certificate file; views, lengths and offsets must have been checked."""

    def table(name: str) -> IntArray:
        return file.table(f"certificates/{name}").astype(np.int64)

    return Certificates(
        name=file.name,
        first_cell=int(file.json["sector"]["firstCell"]),
        origin=np.array([int(x) for x in file.json["frame"]["origin"]], dtype=np.int64),
        subdivision=int(file.json["frame"]["subdivision"]),
        uses=Ragged(table("cellOffsets"), table("uses")),
        regions=table("regions"),
        shapes=table("shapes"),
        targets=Ragged(table("targetOffsets"), table("targets")),
        cuts=Ragged(table("cutOffsets"), file.table("certificates/cuts")),
        leaves=table("leaves"),
        occluders=Ragged(table("occluderOffsets"), table("occluders")),
    )


def number_faults(found: Certificates, face_count: int) -> Iterator[Finding]:
    """Numbers out of range, lists that do not ascend, and lists without a member."""
    lists = (
        ("uses", "cell", found.uses, len(found.regions)),
        ("targets", "certificate", found.targets, face_count),
        ("occluders", "occluder", found.occluders, face_count),
    )
    for name, owner, values, limit in lists:
        rows = ragged.rows(values.offsets)
        for index in np.flatnonzero(values.values >= limit):
            where = f"{found.name} {name}[{index}], {owner} {rows[index]}"
            yield Finding(where, str(values.values[index]), f"less than {limit}")
        for index in ragged.not_ascending(values.values, values.offsets):
            where = f"{found.name} {name}[{index}], {owner} {rows[index]}"
            measured = f"{values.values[index]} after {values.values[index - 1]}"
            yield Finding(where, measured, "strictly ascending")
        if name != "uses":
            for row in np.flatnonzero(np.diff(values.offsets) == 0):
                yield Finding(f"{found.name} {owner} {row}", f"no {name}", "one at least")
    count = len(found.occluders.offsets) - 1
    for index in np.flatnonzero(found.leaves >= count):
        yield Finding(f"{found.name} leaves[{index}]", str(found.leaves[index]), f"less than {count}")


def region_faults(found: Certificates) -> Iterator[Finding]:
    """Regions without an inside, out of reach, or in a form that is not theirs."""
    for index in np.flatnonzero(found.shapes >= len(prisms.AXES)):
        where = f"{found.name} shapes[{index}]"
        yield Finding(where, str(found.shapes[index]), f"less than {len(prisms.AXES)}")
    low, high, ends = found.regions[:, :3], found.regions[:, 3:6], found.regions[:, 6:]
    wrong = ~(low < high).all(axis=1) | (np.abs(found.regions) >= REACH).any(axis=1)
    for index in np.flatnonzero(wrong):
        measured = f"from {low[index].tolist()} to {high[index].tolist()}, p and q {ends[index].tolist()}"
        allowed = "lower less than upper, magnitudes less than 2^29"
        yield Finding(f"{found.name} regions[{index}]", measured, allowed)
    box = found.shapes == 0
    for index in np.flatnonzero(box & ends.any(axis=1)):
        yield Finding(f"{found.name} regions[{index}]", f"p and q {ends[index].tolist()}", "0 for a box")
    slanted = np.flatnonzero(~box & (found.shapes < len(prisms.AXES)))
    v = prisms.SLANTED_AXIS[found.shapes[slanted]]
    starts = np.stack([low[slanted, v], high[slanted, v]], axis=1)
    flat = ends[slanted, 0] >= ends[slanted, 1]
    straight = (ends[slanted] == starts).all(axis=1)
    for index in slanted[flat | straight]:
        measured = f"shape {found.shapes[index]}, p and q {ends[index].tolist()}"
        yield Finding(f"{found.name} regions[{index}]", measured, "p less than q, and a side that slants")


def coordinate_faults(found: Certificates, grid: IntArray) -> Iterator[Finding]:
    """What is wrong with regions, and targets that are out of reach."""
    yield from region_faults(found)
    faces = np.unique(found.targets.values)
    corners = found.in_units(grid[faces])
    for index in np.flatnonzero((np.abs(corners) >= REACH).any(axis=(1, 2))):
        measured = f"corners {corners[index].tolist()}"
        yield Finding(f"{found.name} target {faces[index]}", measured, "magnitudes less than 2^29")
