"""Deltas of all directed portals, and the digests of the states that they lead to."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.lod.model import LodTable
from tilesnav_ref.tileset.difference_kernel import count_differences, fill_differences
from tilesnav_ref.tileset.model import DeltaTable
from tilesnav_ref.visibility.model import PvsTable

CODE_BITS = np.uint64(8)
"""An object and its code are compared as one number: the code fills the low byte."""


def make_deltas(cells: CellComplex, pvs: PvsTable, lod: LodTable) -> DeltaTable:
    """Find what enters, leaves and switches behind every directed portal.

    Parameters
    ----------
    cells : CellComplex
        N cells and M directed portals.
    pvs : PvsTable
        Faces of every cell, strictly ascending.
    lod : LodTable
        Objects of every cell with their codes, strictly ascending by object.

    Returns
    -------
    DeltaTable

    Notes
    -----
    The lists are the set differences themselves, so they are minimal, and deltas compose along every path.
    """
    targets = np.asarray(cells.portal_targets, dtype=np.int64)
    sources = np.repeat(np.arange(cells.count, dtype=np.int64), np.diff(cells.portal_offsets))
    faces = np.ascontiguousarray(pvs.pvs_faces, dtype=np.uint32)
    levels = lod.lod_objects.astype(np.uint64) << CODE_BITS | lod.lod_codes.astype(np.uint64)
    entered_offsets, entered = _differences(pvs.pvs_offsets, faces, targets, sources)
    left_offsets, left = _differences(pvs.pvs_offsets, faces, sources, targets)
    switch_offsets, switches = _differences(lod.lod_offsets, levels, targets, sources)
    return DeltaTable(
        entered_offsets=entered_offsets,
        entered=entered,
        left_offsets=left_offsets,
        left=left,
        switch_offsets=switch_offsets,
        switch_objects=(switches >> CODE_BITS).astype(np.uint32),
        switch_codes=(switches & np.uint64(0xFF)).astype(np.uint8),
    )


def state_digests(pvs: PvsTable, lod: LodTable) -> NDArray[np.uint8]:
    """SHA-256 of the canonical bytes of the state of every cell.

    Returns
    -------
    (N, 32) uint8
    """
    count = len(pvs.pvs_offsets) - 1
    digests = np.empty((count, 32), dtype=np.uint8)
    for cell in range(count):
        digest = hashlib.sha256(canonical_state(pvs, lod, cell)).digest()
        digests[cell] = np.frombuffer(digest, dtype=np.uint8)
    return digests


def canonical_state(pvs: PvsTable, lod: LodTable, cell: int) -> bytes:
    """Canonical bytes of the state of one cell: counted faces, counted objects, codes; little-endian."""
    faces = pvs.pvs_faces[pvs.pvs_offsets[cell] : pvs.pvs_offsets[cell + 1]]
    levels = slice(lod.lod_offsets[cell], lod.lod_offsets[cell + 1])
    objects, codes = lod.lod_objects[levels], lod.lod_codes[levels]
    parts = (np.uint32(len(faces)), faces, np.uint32(len(objects)), objects)
    return b"".join(np.asarray(part, dtype="<u4").tobytes() for part in parts) + codes.tobytes()


def _differences(
    offsets: NDArray[np.int64], values: NDArray[Any], kept: NDArray[np.int64], removed: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[Any]]:
    bounds = np.ascontiguousarray(offsets, dtype=np.int64)
    counts = count_differences(bounds, values, kept, removed)
    out_offsets = np.concatenate(([0], np.cumsum(counts, dtype=np.int64)))
    return out_offsets, fill_differences(bounds, values, kept, removed, int(out_offsets[-1]))
