"""The command `tilesnav path`: the bandwidth of a route, as tables, JSON and pictures."""

from __future__ import annotations

import json
from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from tilesnav_ref.cells import CellError
from tilesnav_ref.cells.picture import check_picture
from tilesnav_ref.stream.bandwidth import Series
from tilesnav_ref.stream.drive import Drive
from tilesnav_ref.stream.path import PathResult, PathSettings, Progress, run_path
from tilesnav_ref.stream.path_picture import draw
from tilesnav_ref.stream.reader import open_tileset
from tilesnav_ref.tileset.errors import OutputError

Figures = dict[str, Any]


def path_figures(given: Namespace, settings: PathSettings, progress: Progress) -> Figures:
    """Drive a route, write what was asked for, and return the figures as JSON values.

    Raises
    ------
    TilesetError, RouteError, PacketError, OutputError
        When the tileset or the route is of no use, or an output cannot be written.
    """
    _check_outputs(given)
    tileset = open_tileset(given.tileset)
    result = run_path(tileset, settings, progress)
    found = _figures(tileset.path, result, settings)
    if given.packets is not None:
        (driven,) = result.drives.values()
        _write(given.packets, b"".join(driven.packets))
    if given.json is not None:
        _write(given.json, (json.dumps(found, indent=1, allow_nan=False) + "\n").encode())
    if given.plot is not None:
        with _appearing(given.plot) as part:
            draw(tileset, result, part, _heading(found))
    return found


def _check_outputs(given: Namespace) -> None:
    """Refuse what cannot be written, before any work is done."""
    if given.plot is not None:
        try:
            check_picture(given.plot)
        except CellError as error:
            raise OutputError(str(error)) from error
    outputs = [path for path in (given.plot, given.json, given.packets) if path is not None]
    for path in outputs:
        if path.is_dir() or not path.parent.is_dir():
            raise OutputError(f"{path}: found no place for a file; allowed: a file in a folder that is there")
    if len({path.resolve() for path in outputs}) != len(outputs):
        raise OutputError("--plot, --json, --packets: found one file twice; allowed: a file for each")


def _write(path: Path, data: bytes) -> None:
    with _appearing(path) as part:
        part.write_bytes(data)


@contextmanager
def _appearing(path: Path) -> Iterator[Path]:
    """Write a file under another name and rename it, so that it is there as a whole or not at all."""
    part = path.with_name(f".part-{path.name}")
    try:
        yield part
        part.replace(path)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror}") from error
    finally:
        part.unlink(missing_ok=True)


def _figures(path: Path, result: PathResult, settings: PathSettings) -> Figures:
    route = result.route
    comparison, screen = settings.comparison, settings.comparison.screen
    return {
        "tileset": str(path),
        "settings": {
            "speed": settings.speed,
            "retain": settings.retain,
            "maximum_screen_error": screen.maximum_error,
            "screen_height": screen.screen_height,
            "field_of_view": screen.field_of_view,
            "sensor_range": comparison.sensor_range,
            "spacing": comparison.spacing,
        },
        "route": {
            "name": settings.route if isinstance(settings.route, str) else None,
            "length": route.length,
            "duration": route.length / settings.speed,
            "points": route.points.tolist(),
            "passages": [[one.cell, one.begin, one.end] for one in route.passages],
        },
        "packets": {name: _drive(one, route.length) for name, one in result.drives.items()},
        "packets_keeping_all": {name: _drive(one, route.length) for name, one in result.keeping.items()},
        "rivals": [
            {
                "name": rival.name,
                "title": rival.title,
                "memory": rival.memory,
                "coded": _series(rival.coded, route.length),
                "files": None if rival.files is None else _series(rival.files, route.length),
            }
            for rival in result.rivals
        ],
    }


def _series(series: Series, length: float) -> Figures:
    return {
        "summary": series.summary(length),
        "times": series.times.tolist(),
        "bytes": series.sizes.tolist(),
        "faces_held": series.held.tolist(),
    }


def _drive(one: Drive, length: float) -> Figures:
    found = _series(one.series, length)
    later = one.series.sizes[1:].sum()
    found["summary"] |= {
        "packets": len(one.packets),
        "key_frames": int(one.key_frames.sum()),
        "apply_ms_median": float(np.median(one.apply_seconds) * 1e3),
        "apply_ms_p95": float(np.percentile(one.apply_seconds, 95) * 1e3),
        "make_ms_median": float(np.median(one.make_seconds) * 1e3),
        "bytes_per_new_face_first": int(one.series.sizes[0]) / max(int(one.new_faces[0]), 1),
        "bytes_per_new_face_later": int(later) / max(int(one.new_faces[1:].sum()), 1),
    }
    return found | {
        "cells": one.cells.tolist(),
        "key_frame": one.key_frames.tolist(),
        "new_faces": one.new_faces.tolist(),
        "apply_ms": (one.apply_seconds * 1e3).tolist(),
    }


def print_path(console: Console, found: Figures) -> None:
    """Print the figures that :func:`path_figures` gives."""
    console.print(_heading(found))
    console.print(_bandwidths(found))
    console.print(_packets(found["packets"]))


def _heading(found: Figures) -> str:
    route, speed = found["route"], found["settings"]["speed"]
    name = f"route {route['name']}" if route["name"] else "route"
    return (
        f"{name}: {route['length']:,.0f} m through {len(route['passages']):,} cells,"
        f" {route['duration']:,.1f} s at {speed:g} m/s"
    )


def _bandwidths(found: Figures) -> Table:
    """Means and peaks are without the start; a vehicle holds what it needs there, or all that it ever got."""
    table = _table("what a vehicle receives; mean, peak and B/m are without the start")
    for column in ("way", "holds"):
        table.add_column(column, no_wrap=True)
    for column in ("start\nkB", "mean\nkB/s", "peak\nkB/s", "B/m", "all\nkB", "faces\nheld", ".glb\nkB"):
        table.add_column(column, justify="right")
    retained = found["settings"]["retain"]
    needed = f"+ {retained:,}" if retained else "needed"
    for name, one in found["packets"].items():
        table.add_row(f"packets, {name}", needed, *_row(one["summary"]), "")
    for name, one in found["packets_keeping_all"].items():
        table.add_row(f"packets, {name}", "all", *_row(one["summary"]), "")
    table.add_section()
    for rival in found["rivals"]:
        files = "" if rival["files"] is None else f"{rival['files']['summary']['total_kB']:,.0f}"
        table.add_row(rival["title"], rival["memory"], *_row(rival["coded"]["summary"]), files)
    return table


def _row(summary: Figures) -> list[str]:
    start, mean, peak = (f"{summary[key]:,.1f}" for key in ("first_kB", "mean_kB_s", "peak_kB_s"))
    per_metre, total = f"{summary['bytes_per_metre']:,.0f}", f"{summary['total_kB']:,.0f}"
    return [start, mean, peak, per_metre, total, f"{summary['mean_faces_held']:,.0f}"]


def _table(title: str) -> Table:
    return Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))


def _packets(drives: Figures) -> Table:
    table = _table("packets of a vehicle that holds what it needs")
    table.add_column("lod")
    columns = (
        "packets",
        "key\nframes",
        "start,\nB/new face",
        "later,\nB/new face",
        "apply ms,\nmedian",
        "apply ms,\n95 %",
        "make ms,\nmedian",
    )
    for column in columns:
        table.add_column(column, justify="right")
    for name, one in drives.items():
        s = one["summary"]
        table.add_row(
            name,
            f"{s['packets']:,}",
            f"{s['key_frames']:,}",
            f"{s['bytes_per_new_face_first']:.2f}",
            f"{s['bytes_per_new_face_later']:.2f}",
            f"{s['apply_ms_median']:.2f}",
            f"{s['apply_ms_p95']:.2f}",
            f"{s['make_ms_median']:.2f}",
        )
    return table
