"""The tables of one nav file: which array is stored under which name with which type."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.tileset.container import COUNT_LIMIT, Buffer, TablePool, nav_file_parts
from tilesnav_ref.tileset.errors import EncodeError
from tilesnav_ref.tileset.model import NavMap

Json = dict[str, Any]


@dataclass(frozen=True)
class CellArrays:
    """Per-cell arrays that are made for the file only."""

    planes: NDArray[np.float64]
    """(N, 6, 4) outward unit normal and d, inside is n.x + d <= 0, nav frame, metres."""
    digests: NDArray[np.uint8]
    """(N, 32) SHA-256 of the state."""


def nav_file(nav_map: NavMap, arrays: CellArrays, first: int, last: int) -> list[Buffer]:
    """Make the nav file of the cells from `first` to `last` - 1, in parts to be written one behind the other.

    Raises
    ------
    EncodeError
        When a table has more elements than readers accept.
    """
    pool = TablePool()
    members = {
        "sector": {"firstCell": first, "cellCount": last - first},
        "cells": {
            "planes": pool.add(arrays.planes[first:last], "<f8"),
            "kinds": pool.add(nav_map.cells.kinds[first:last], "u1"),
        },
        "portals": _portals(pool, nav_map, first, last),
        "pvs": _pvs(pool, nav_map, arrays, slice(first, last)),
        "lod": _lod(pool, nav_map, first, last),
        "deltas": _deltas(pool, nav_map, first, last),
    }
    return nav_file_parts(pool, members)


def _portals(pool: TablePool, nav_map: NavMap, first: int, last: int) -> Json:
    cells = nav_map.cells
    begin, end = cells.portal_offsets[first], cells.portal_offsets[last]
    used, polygons = np.unique(cells.portal_polygons[begin:end], return_inverse=True)
    sizes = np.diff(cells.polygon_offsets)[used]
    rows = np.repeat(cells.polygon_offsets[used] - np.cumsum(sizes) + sizes, sizes) + np.arange(sizes.sum())
    # Multiplying by a power of two is exact: the file's metres are the grid coordinates themselves.
    vertices = cells.polygon_vertices[rows] * nav_map.scene.step
    return {
        "count": _limited(end - begin, "directed portals"),
        "polygonCount": len(used),
        "vertexCount": len(vertices),
        "offsets": pool.add(_rebased(cells.portal_offsets, first, last), "<u4"),
        "targets": pool.add(cells.portal_targets[begin:end], "<u4"),
        "polygons": pool.add(polygons, "<u4"),
        "polygonOffsets": pool.add(np.concatenate(([0], np.cumsum(sizes))), "<u4"),
        "vertices": pool.add(vertices, "<f8"),
    }


def _pvs(pool: TablePool, nav_map: NavMap, arrays: CellArrays, cells: slice) -> Json:
    pvs = nav_map.pvs
    begin, end = pvs.pvs_offsets[cells.start], pvs.pvs_offsets[cells.stop]
    return {
        "count": _limited(end - begin, "faces in the sets of cells"),
        "offsets": pool.add(_rebased(pvs.pvs_offsets, cells.start, cells.stop), "<u4"),
        "faces": pool.add(pvs.pvs_faces[begin:end], "<u4"),
        "provenVisible": pool.add(pvs.proven_counts[cells], "<u4"),
        "digests": pool.add(arrays.digests[cells], "u1"),
    }


def _lod(pool: TablePool, nav_map: NavMap, first: int, last: int) -> Json:
    lod = nav_map.lod
    begin, end = lod.lod_offsets[first], lod.lod_offsets[last]
    return {
        "count": _limited(end - begin, "objects in the sets of cells"),
        "offsets": pool.add(_rebased(lod.lod_offsets, first, last), "<u4"),
        "objects": pool.add(lod.lod_objects[begin:end], "<u4"),
        "codes": pool.add(lod.lod_codes[begin:end], "u1"),
    }


def _deltas(pool: TablePool, nav_map: NavMap, first: int, last: int) -> Json:
    deltas = nav_map.deltas
    portals = _portal_range(nav_map.cells, first, last)
    entered = slice(*deltas.entered_offsets[portals])
    left = slice(*deltas.left_offsets[portals])
    switches = slice(*deltas.switch_offsets[portals])
    return {
        "enteredCount": _limited(entered.stop - entered.start, "faces entered"),
        "leftCount": _limited(left.stop - left.start, "faces left"),
        "switchCount": _limited(switches.stop - switches.start, "objects switched"),
        "enteredOffsets": pool.add(_rebased(deltas.entered_offsets, *portals), "<u4"),
        "entered": pool.add(deltas.entered[entered], "<u4"),
        "leftOffsets": pool.add(_rebased(deltas.left_offsets, *portals), "<u4"),
        "left": pool.add(deltas.left[left], "<u4"),
        "switchOffsets": pool.add(_rebased(deltas.switch_offsets, *portals), "<u4"),
        "switchObjects": pool.add(deltas.switch_objects[switches], "<u4"),
        "switchCodes": pool.add(deltas.switch_codes[switches], "u1"),
    }


def _portal_range(cells: CellComplex, first: int, last: int) -> list[int]:
    return [int(cells.portal_offsets[first]), int(cells.portal_offsets[last])]


def _rebased(offsets: NDArray[np.int64], first: int, last: int) -> NDArray[np.int64]:
    return np.asarray(offsets[first : last + 1] - offsets[first], dtype=np.int64)


def _limited(count: int, what: str) -> int:
    if count > COUNT_LIMIT:
        raise EncodeError(
            f"one sector has {count} {what}, and readers accept at most {COUNT_LIMIT}: "
            "encode with fewer cells in a sector (--sector-cells)"
        )
    return int(count)
