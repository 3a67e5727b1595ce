"""The figures of a tileset: counts, sets, deltas and bytes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tilesnav_ref.stream.fields import JSON_LIMIT, parse_object
from tilesnav_ref.stream.reader import NavTileset
from tilesnav_ref.stream.uris import read_bytes
from tilesnav_ref.stream.volume import cell_volumes

REPORT_NAME = "encode-report.json"
Figures = dict[str, Any]


def figures(tileset: NavTileset) -> Figures:
    """Work out the figures of a tileset.

    Returns
    -------
    dict
        JSON values: metres, cubic metres, bytes, seconds; what a tileset does not state is None.
    """
    run = _run_report(tileset.path.parent / REPORT_NAME)
    kinds = np.concatenate([sector.kinds for sector in tileset.sectors])
    provenance = tileset.provenance
    update = provenance.get("update")
    return {
        "encoder": provenance.get("encoder"),
        "cells": tileset.cell_count,
        "ground_cells": int(np.count_nonzero(kinds)),
        "portals": tileset.portal_count,
        "faces": tileset.face_count,
        "objects": tileset.object_count,
        "contents": len(tileset.contents),
        "coarse_levels": len(tileset.coarse),
        "volume": float(sum(cell_volumes(sector.planes).sum() for sector in tileset.sectors)),
        "clearance": tileset.clearance,
        "grid_step": tileset.step,
        "coverage": provenance.get("coverage"),
        "max_range": tileset.max_range,
        "porous_objects": len(tileset.porous_objects),
        "one_sided_objects": len(tileset.one_sided_objects),
        "pvs": _pvs(tileset),
        "delta": _delta(tileset),
        "bytes": _bytes(tileset),
        "seconds": run.get("seconds"),
        "peak_memory": run.get("peakMemory"),
        "peak_memory_child": run.get("peakMemoryChild"),
        "scene": provenance.get("scene"),
        "undecided": provenance.get("undecided"),
        "update": update if isinstance(update, dict) else None,
    }


def _pvs(tileset: NavTileset) -> Figures:
    sizes = np.concatenate([np.diff(sector.faces.offsets.astype(np.int64)) for sector in tileset.sectors])
    proven = int(sum(sector.proven_visible.sum(dtype=np.int64) for sector in tileset.sectors))
    return {
        "mean": float(sizes.mean()),
        "p95": float(np.percentile(sizes, 95)),
        "max": int(sizes.max()),
        "proven_mean": proven / len(sizes),
        "overestimate": int(sizes.sum()) / proven if proven else None,
    }


def _delta(tileset: NavTileset) -> Figures:
    portals = max(tileset.portal_count, 1)
    return {
        "mean_entered": sum(len(sector.entered.values) for sector in tileset.sectors) / portals,
        "mean_left": sum(len(sector.left.values) for sector in tileset.sectors) / portals,
        "mean_switched": sum(len(sector.switched.values) for sector in tileset.sectors) / portals,
        "bytes": sum(sector.table_bytes["deltas"] for sector in tileset.sectors),
    }


def _bytes(tileset: NavTileset) -> Figures:
    groups = tileset.sectors[0].table_bytes.keys()
    nav = {group: sum(sector.table_bytes[group] for sector in tileset.sectors) for group in groups}
    files = sum(sector.path.stat().st_size for sector in tileset.sectors)
    # Headers, JSON parts and padding.
    nav["other"] = files - sum(nav.values())
    contents = sum(content.path.stat().st_size for content in tileset.contents)
    proofs = sum(path.stat().st_size for path in tileset.certificates)
    coarse = sum(path.stat().st_size for path in _coarse_files(tileset))
    json_bytes = tileset.path.stat().st_size
    return {
        "contents": contents,
        "coarse": coarse,
        "nav": nav,
        "certificates": proofs,
        "json": json_bytes,
        "total": contents + coarse + files + proofs + json_bytes,
    }


def _coarse_files(tileset: NavTileset) -> list[Path]:
    """Contents and face maps of the coarse levels."""
    contents = [content for level in tileset.coarse.values() for content in level]
    maps = [content.face_map.path for content in contents if content.face_map is not None]
    return [*(content.path for content in contents), *maps]


def _run_report(path: Path) -> Figures:
    """Read the side file of the encoder; a tileset need not have one."""
    return parse_object(read_bytes(path, JSON_LIMIT), str(path)).members if path.is_file() else {}
