"""The tables of all sectors as one, with global numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator.navfile import NavFile
from tilesnav_validator.ragged import IntArray


@dataclass(frozen=True)
class Ragged:
    """Ragged list: the elements of list i are ``values[offsets[i]:offsets[i + 1]]``."""

    offsets: IntArray
    values: NDArray[Any]

    def row(self, index: int) -> NDArray[Any]:
        """Elements of one list."""
        return self.values[self.offsets[index] : self.offsets[index + 1]]


@dataclass(frozen=True)
class Tables:
    """Tables of n cells, m directed portals and q polygons of all sectors, in the order of the sectors.

    Attributes
    ----------
    planes : ndarray of float64, shape (n, 6, 4)
    kinds, proven : ndarray, shape (n,)
    targets : Ragged
        Directed portals of each cell.
    polygons : ndarray of int64, shape (m,)
        Index into ``vertices``; those of later sectors follow those of earlier ones.
    polygon_range : ndarray of int64, shape (m, 2)
        First and one past the last polygon of the sector that the portal is stored in.
    vertices : Ragged
        Vertices of each polygon, float64, shape (k, 3), nav frame.
    faces, objects, codes : Ragged
        State of each cell.
    digests : ndarray of uint8, shape (n, 32)
    entered, left, switch_objects, switch_codes : Ragged
        Delta of each directed portal.
    """

    planes: NDArray[np.float64]
    kinds: NDArray[np.uint8]
    targets: Ragged
    polygons: IntArray
    polygon_range: IntArray
    vertices: Ragged
    faces: Ragged
    proven: IntArray
    digests: NDArray[np.uint8]
    objects: Ragged
    codes: Ragged
    entered: Ragged
    left: Ragged
    switch_objects: Ragged
    switch_codes: Ragged

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return len(self.planes)

    @property
    def portal_sources(self) -> IntArray:
        """Cell that each directed portal leaves, shape (m,)."""
        counts = np.diff(self.targets.offsets)
        return np.repeat(np.arange(self.cell_count, dtype=np.int64), counts)


def _joined(sectors: Sequence[NavFile], name: str) -> NDArray[Any]:
    """One table of all sectors; a single sector is not copied."""
    parts = [sector.table(name) for sector in sectors]
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _joined_offsets(sectors: Sequence[NavFile], name: str) -> IntArray:
    """Offsets of all sectors, those of later ones moved behind those of earlier ones."""
    joined = [np.zeros(1, np.int64)]
    for sector in sectors:
        joined.append(sector.table(name)[1:].astype(np.int64) + joined[-1][-1])
    return np.concatenate(joined)


def join(sectors: Sequence[NavFile]) -> Tables:
    """Join the tables of all sectors; lengths and offsets must have been checked."""

    def ragged(offsets: str, values: str) -> Ragged:
        return Ragged(_joined_offsets(sectors, offsets), _joined(sectors, values))

    polygons, ranges, first = [], [], 0
    for sector in sectors:
        own = sector.table("portals/polygons").astype(np.int64) + first
        last = first + sector.count("polygons")
        polygons.append(own)
        ranges.append(np.broadcast_to(np.array([first, last], np.int64), (len(own), 2)))
        first = last
    return Tables(
        planes=_joined(sectors, "cells/planes"),
        kinds=_joined(sectors, "cells/kinds"),
        targets=ragged("portals/offsets", "portals/targets"),
        polygons=np.concatenate(polygons),
        polygon_range=np.concatenate(ranges),
        vertices=ragged("portals/polygonOffsets", "portals/vertices"),
        faces=ragged("pvs/offsets", "pvs/faces"),
        proven=_joined(sectors, "pvs/provenVisible").astype(np.int64),
        digests=_joined(sectors, "pvs/digests"),
        objects=ragged("lod/offsets", "lod/objects"),
        codes=ragged("lod/offsets", "lod/codes"),
        entered=ragged("deltas/enteredOffsets", "deltas/entered"),
        left=ragged("deltas/leftOffsets", "deltas/left"),
        switch_objects=ragged("deltas/switchOffsets", "deltas/switchObjects"),
        switch_codes=ragged("deltas/switchOffsets", "deltas/switchCodes"),
    )
