"""Registration of scans: arguments, work and printing."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from tilesnav_ref.clouds import CloudSettings, cloud_chunks, read_cloud
from tilesnav_ref.clouds.model import PLACE
from tilesnav_ref.clouds.write import Records, check_suffix, write_points
from tilesnav_ref.commands.values import given_of, integer, number
from tilesnav_ref.registration import (
    LEAST_HELD,
    Registration,
    RegistrationError,
    RegistrationSettings,
    register,
)
from tilesnav_ref.registration.motion import place
from tilesnav_ref.registration.poses import read_poses, write_poses
from tilesnav_ref.scene import METRES_PER_UNIT

Progress = Callable[[str, int, int], None]
RECORD = np.dtype([("x", "<f8"), ("y", "<f8"), ("z", "<f8"), ("scan", "<i4")])
"""A point of the merged cloud."""
PLACED = np.dtype([*RECORD.descr, *((name, "<f8") for name in PLACE)])
"""With where the scanner was."""


def add_register(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    settings = RegistrationSettings()
    parser.add_argument(
        "scans", nargs="+", type=Path, metavar="SCAN", help="point clouds; the first stays where it is"
    )
    parser.add_argument(
        "out", type=Path, metavar="OUT", help="merged cloud to write, .ply, .las or .laz; it must not exist"
    )
    parser.add_argument(
        "--poses",
        type=Path,
        metavar="FILE",
        help="where each scan lies roughly: a line each, time x y z qx qy qz qw (as their coordinates say)",
    )
    parser.add_argument(
        "--found-poses", type=Path, metavar="FILE", help="file to write for the poses found, of the same form"
    )
    lengths = (
        ("--voxel", f"edge of the voxels of which each gives a point ({settings.voxel:g})"),
        ("--reach", f"how far off a starting pose may be ({settings.reach:g})"),
        ("--fine-reach", f"greatest distance of partners in the adjustment ({settings.fine_reach:g})"),
    )
    for option, text in lengths:
        parser.add_argument(option, type=number, metavar="M", help=f"{text}, m")
    parser.add_argument(
        "--least-overlap",
        type=number,
        metavar="SHARE",
        help=f"share of a scan that must have partners in the map ({settings.least_overlap:g})",
    )
    parser.add_argument(
        "--rounds", type=integer(0), metavar="N", help=f"most rounds of the adjustment ({settings.rounds})"
    )
    parser.add_argument(
        "--units",
        choices=("auto", *METRES_PER_UNIT),
        default="auto",
        help="length unit of the files (auto: as they say, else m)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--quiet", action="store_true", help="no progress")


def registration_figures(given: argparse.Namespace, progress: Progress) -> dict[str, Any]:
    """Register scans, write the merged cloud and say how well they fit.

    Raises
    ------
    SceneError, RegistrationError
        When a setting is refused, a file cannot be read or written, or the scans cannot be brought together.
    """
    settings = RegistrationSettings(**given_of(RegistrationSettings, vars(given)))
    _check_outputs([path for path in (given.out, given.found_poses) if path is not None])
    reading = CloudSettings(units=given.units)
    starts = None if given.poses is None else list(read_poses(given.poses))
    begin = time.perf_counter()
    found = register(_scans(given.scans, reading, progress), starts, settings, progress)
    registered = time.perf_counter()
    record = _record(given.scans, reading)
    merged = _merged(given.scans, (found.map_from_scan, record), reading, progress)
    points = write_points(given.out, record, merged)
    if given.found_poses is not None:
        write_poses(given.found_poses, found.map_from_scan)
    return {
        "scans": [_row(found, k) for k in range(len(found.names))],
        "points": points,
        "rounds": found.rounds,
        "rms": float(np.sqrt(np.mean(found.rms**2))),
        "seconds": {"register": registered - begin, "merge": time.perf_counter() - registered},
    }


def _check_outputs(paths: list[Path]) -> None:
    check_suffix(paths[0])
    for path in paths:
        if not path.parent.is_dir():
            raise RegistrationError(str(path), f"{path.parent}, which is no folder", "a folder that exists")
        if path.exists():
            raise RegistrationError(str(path), "something there", "a name that is free")


def _scans(
    paths: list[Path], reading: CloudSettings, progress: Progress
) -> Iterator[tuple[str, NDArray[np.float64]]]:
    for done, path in enumerate(paths, start=1):
        cloud = read_cloud(path, reading)
        yield str(path), cloud.points + cloud.origin
        progress("thin", done, len(paths))


def _record(paths: list[Path], reading: CloudSettings) -> np.dtype[Any]:
    """`RECORD`, with the places of the scanner where all scans have them."""
    first = replace(reading, chunk_points=1)
    places = [next(cloud_chunks(path, first))[0].places for path in paths]
    return RECORD if any(place is None for place in places) else PLACED


def _merged(
    paths: list[Path],
    found: tuple[NDArray[np.float64], np.dtype[Any]],
    reading: CloudSettings,
    progress: Progress,
) -> Iterator[Records]:
    poses, record = found
    for done, (path, pose) in enumerate(zip(paths, poses, strict=True), start=1):
        for chunk, _, _ in cloud_chunks(path, reading):
            records = np.empty(len(chunk.points), record)
            parts: list[tuple[Any, NDArray[np.float64]]] = [("xyz", chunk.points)]
            if record is PLACED and chunk.places is not None:
                parts.append((PLACE, chunk.places))
            for names, points in parts:
                for name, values in zip(names, place(pose, points).T, strict=True):
                    records[name] = values
            records["scan"] = done - 1
            yield records
        progress("merge", done, len(paths))


def _row(found: Registration, number: int) -> dict[str, Any]:
    return {
        "scan": found.names[number],
        "pose": found.map_from_scan[number].tolist(),
        "moved": float(found.moved[number]),
        "turned": float(np.degrees(found.turned[number])),
        "rms": float(found.rms[number]),
        "matched": float(found.matched[number]),
        "held": float(found.held[number]),
    }


def print_registration(console: Console, found: dict[str, Any]) -> None:
    """Print a line for each scan, and figures of all."""
    table = Table()
    for name in ("scan", "moved, m", "turned, deg", "rms, mm", "with partner", "held"):
        table.add_column(name, justify="left" if name == "scan" else "right")
    for row in found["scans"]:
        table.add_row(
            Path(row["scan"]).name,
            f"{row['moved']:.3f}",
            f"{row['turned']:.2f}",
            f"{1000 * row['rms']:.1f}",
            f"{row['matched']:.0%}",
            f"{row['held']:.3f}",
        )
    console.print(table)
    seconds = found["seconds"]
    console.print(
        f"{found['points']:,} points of {len(found['scans'])} scans; rms {1000 * found['rms']:.1f} mm after"
        f" {found['rounds']} rounds; {seconds['register']:.1f} s, {seconds['merge']:.1f} s to write"
    )
    loose = [Path(row["scan"]).name for row in found["scans"] if row["held"] < LEAST_HELD]
    if loose:
        console.print(f"[yellow]slides along a line that no plane holds: {', '.join(loose)}")
