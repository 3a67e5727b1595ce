"""The command `tilesnav cells`: cells of a scene, their figures, and a picture of them."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tilesnav_ref.cells import KIND_GROUND, CellComplex, CellError, CellSettings, decompose
from tilesnav_ref.cells.picture import check_picture, draw
from tilesnav_ref.scene import SceneSettings
from tilesnav_ref.survey import SurveySettings, open_scene
from tilesnav_ref.tileset.errors import OutputError
from tilesnav_ref.tileset.run_report import StageProgress


def cell_figures(
    source: Path,
    settings: tuple[SceneSettings, CellSettings, SurveySettings],
    plot: Path | None,
    progress: StageProgress,
) -> dict[str, Any]:
    """Divide the free space of a scene, draw it where asked, and return the figures as JSON values.

    Raises
    ------
    SceneError, CellError, OutputError
        The scene cannot be read, has no cells, or the picture cannot be made.
    """
    if plot is not None:
        try:
            check_picture(plot)
        except CellError as error:
            raise OutputError(str(error)) from error
    times = [time.perf_counter()]
    progress("scene", 0, 1)
    scene, _ = open_scene(source, settings[0], settings[2])
    progress("scene", 1, 1)
    times.append(time.perf_counter())
    cells = decompose(scene, settings[1], lambda done, total: progress("cells", done, total))
    times.append(time.perf_counter())
    if plot is not None:
        draw(scene, cells, plot)
    times.append(time.perf_counter())
    stages = dict(zip(("scene", "cells", "plot"), np.diff(times).tolist(), strict=True))
    return {"faces": scene.face_count, **_figures(cells, scene.step), "seconds": stages}


def _figures(cells: CellComplex, step: float) -> dict[str, Any]:
    return {
        "cells": cells.count,
        "ground_cells": int(np.count_nonzero(cells.kinds == KIND_GROUND)),
        "portals": cells.portal_count,
        "parts": _parts(cells),
        "sectors": max(len(cells.sector_offsets) - 1, 1),
        "clearance": cells.clearance * step,
        "coverage": cells.coverage,
        "coverage_by_height": [
            {
                "from": band.lower,
                "to": None if math.isinf(band.upper) else band.upper,
                "points": band.points,
                "coverage": band.covered / band.points,
            }
            for band in cells.bands
        ],
    }


def _parts(cells: CellComplex) -> list[int]:
    """Cells of each connected part, the largest first."""
    sources = np.repeat(np.arange(cells.count), np.diff(cells.portal_offsets))
    links = coo_array(
        (np.ones(cells.portal_count, np.int8), (sources, cells.portal_targets)), shape=(cells.count,) * 2
    )
    _, part = connected_components(links, directed=False)
    return sorted(np.bincount(part).tolist(), reverse=True)


def print_cells(console: Console, found: dict[str, Any]) -> None:
    """Print the figures that :func:`cell_figures` gives."""
    parts = found["parts"]
    shown = ", ".join(f"{part:,}" for part in parts[:5]) + (", ..." if len(parts) > 5 else "")
    table = _table("figure", "value")
    for row in (
        ("faces of the scene", f"{found['faces']:,}"),
        ("cells", f"{found['cells']:,} ({found['ground_cells']:,} ground)"),
        ("portals, directed", f"{found['portals']:,}"),
        ("connected parts, cells", f"{len(parts):,} ({shown})"),
        ("sectors with cells", f"{found['sectors']:,}"),
        ("clearance", f"{found['clearance']:g} m"),
        ("coverage", f"{100 * found['coverage']:.2f} %"),
        *((f"{stage}, seconds", f"{seconds:,.2f}") for stage, seconds in found["seconds"].items()),
    ):
        table.add_row(*row)
    console.print(table)
    bands = _table("height above the ground", "coverage")
    for band in found["coverage_by_height"]:
        upper = "and above" if band["to"] is None else f"to {band['to']:g} m"
        bands.add_row(
            f"{band['from']:g} {upper}", f"{100 * band['coverage']:.2f} % of {band['points']:,} points"
        )
    console.print(bands)


def _table(left: str, right: str) -> Table:
    table = Table()
    table.add_column(left)
    table.add_column(right, justify="right")
    return table
