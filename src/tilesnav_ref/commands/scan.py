"""Scanning a scene with the simulated scanner: arguments, work and printing."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from tilesnav_ref.commands.values import given_of, integer, line, number
from tilesnav_ref.scene import Scene, SceneSettings, load_scene
from tilesnav_ref.sensor import NO_FACE, Route, Scan, ScannerSettings, scan_count, simulate_scans
from tilesnav_ref.sensor.write import check_output, write_scans

Progress = Callable[[str, int, int], None]


def route_line(text: str) -> tuple[tuple[float, ...], ...]:
    """Waypoints: X,Y,Z with spaces or semicolons between them, or a .json or .csv file."""
    return line(text) if Path(text).suffix.lower() in (".json", ".csv") else line(";".join(text.split()))


def add_scan(parser: argparse.ArgumentParser) -> Any:
    """Add the arguments, and return the group for those of the scene."""
    parser.add_argument(
        "scene", type=Path, metavar="SCENE", help="PLY, OBJ, STL, OFF, GLB or glTF file, or tileset.json"
    )
    parser.add_argument(
        "out",
        type=Path,
        metavar="OUT",
        help="what to write, which must not exist: .ply, .las, .laz, .mcap, or, without an ending, a folder"
        " with a file a scan",
    )
    parser.add_argument(
        "--route",
        type=route_line,
        required=True,
        metavar="'X,Y,Z X,Y,Z'",
        help="waypoints in the nav frame, m, or a .json or .csv file of them; one: a scan that stands still",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--quiet", action="store_true", help="no progress")
    _add_scanner(parser.add_argument_group("scanner"))
    return parser.add_argument_group("scene")


def _add_scanner(group: Any) -> None:
    scanner, route = ScannerSettings(), Route(((0.0, 0.0, 0.0),))
    options = (
        ("--speed", "M/S", f"speed on the route, m/s ({route.speed:g})"),
        ("--turn-length", "M", f"way over which it turns at a waypoint, m ({route.turn_length:g})"),
        ("--lowest", "DEG", f"elevation of the lowest beam, degrees ({scanner.lowest:g})"),
        ("--highest", "DEG", f"elevation of the highest beam, degrees ({scanner.highest:g})"),
        ("--azimuth-step", "DEG", f"from one firing to the next, degrees ({scanner.azimuth_step:g})"),
        ("--rotation-rate", "HZ", f"turns a second ({scanner.rotation_rate:g})"),
        ("--min-range", "M", f"least range, m ({scanner.min_range:g})"),
        ("--max-range", "M", f"greatest range, m ({scanner.max_range:g})"),
        ("--range-noise", "M", f"standard deviation of a range, m ({scanner.range_noise:g})"),
        ("--dropouts", "SHARE", f"share of the returns that are lost ({scanner.dropouts:g})"),
        ("--outliers", "SHARE", f"share of the returns that lie anywhere ({scanner.outliers:g})"),
        ("--pitch", "DEG", f"tilt of the mount forwards, degrees ({scanner.pitch:g})"),
        ("--roll", "DEG", f"tilt of the mount to the right, degrees ({scanner.roll:g})"),
    )
    group.add_argument("--beams", type=integer(1), metavar="N", help=f"beams ({scanner.beams})")
    for option, unit, text in options:
        group.add_argument(option, type=number, metavar=unit, help=text)
    group.add_argument(
        "--every", type=integer(1), metavar="N", help=f"keep one turn of so many ({scanner.every})"
    )
    group.add_argument(
        "--seed", type=integer(0), metavar="N", help=f"start of the random numbers ({scanner.seed})"
    )


def scan_settings(given: argparse.Namespace) -> tuple[Route, ScannerSettings]:
    """Make route and scanner of what was given; the rest keeps its default.

    Raises
    ------
    ScanError
        When a value is not as allowed.
    """
    values = vars(given)
    route = {"waypoints": given.route, **given_of(Route, values)}
    return Route(**route), ScannerSettings(**given_of(ScannerSettings, values))


def scan_figures(
    source: Path, out: Path, settings: tuple[SceneSettings, Route, ScannerSettings], progress: Progress
) -> dict[str, Any]:
    """Read a scene, scan it, write the scans, and say what they hold.

    Raises
    ------
    SceneError, ScanError
        When the scene cannot be read, or the file cannot be written.
    """
    scene_settings, route, scanner = settings
    check_output(out)
    progress("scene", 0, 1)
    scene, _ = load_scene(source, scene_settings)
    progress("scene", 1, 1)
    begin = time.perf_counter()
    tally = _Tally(scene)
    total = len(range(0, scan_count(route, scanner), scanner.every))
    points = write_scans(tally.count(simulate_scans(scene, route, scanner), progress, total), out)
    rays = total * scanner.firings * scanner.beams
    size = out.stat().st_size if out.is_file() else sum(one.stat().st_size for one in out.iterdir())
    return {
        "scans": total,
        "rays": rays,
        "points": points,
        "returned": points / rays,
        "length": route.length,
        "duration": route.duration,
        **tally.figures(),
        "bytes": size,
        "seconds": time.perf_counter() - begin,
    }


class _Tally:
    """Counts of what scans hold, taken as they pass."""

    def __init__(self, scene: Scene) -> None:
        edges = np.diff(scene.corners(), axis=1) * np.float64(scene.step)
        self._areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 2.0
        self._hits: NDArray[np.int64] = np.zeros(scene.face_count, np.int64)
        self._object_of = scene.face_object
        self._ranges, self._points, self._outliers = 0.0, 0, 0

    def count(self, scans: Iterator[Scan], progress: Progress, total: int) -> Iterator[Scan]:
        """Pass scans on."""
        for done, scan in enumerate(scans, start=1):
            faces = scan.returns.faces
            hit = faces[faces != NO_FACE]
            self._hits += np.bincount(hit, minlength=len(self._hits))
            self._outliers += len(faces) - len(hit)
            self._ranges += float(scan.returns.true_ranges.sum())
            self._points += len(faces)
            yield scan
            progress("scan", done, total)

    def figures(self) -> dict[str, Any]:
        """What was counted."""
        seen = self._hits > 0
        return {
            "outliers": self._outliers,
            "mean_range": self._ranges / self._points if self._points else None,
            "faces": len(seen),
            "faces_hit": int(seen.sum()),
            "area_hit": float(self._areas[seen].sum() / self._areas.sum()),
            "objects_hit": len(np.unique(self._object_of[seen])),
        }


def print_scan(console: Console, found: dict[str, Any]) -> None:
    """Print the figures as a table."""
    table = Table()
    table.add_column("figure")
    table.add_column("value", justify="right")
    mean = found["mean_range"]
    rows = (
        ("route", f"{found['length']:,.1f} m, {found['duration']:,.1f} s"),
        ("scans", f"{found['scans']:,}"),
        ("rays", f"{found['rays']:,}"),
        ("points", f"{found['points']:,} ({found['returned']:.1%} of the rays)"),
        ("of them outliers", f"{found['outliers']:,}"),
        ("mean range", "none" if mean is None else f"{mean:.1f} m"),
        ("faces hit", f"{found['faces_hit']:,} of {found['faces']:,}, {found['area_hit']:.1%} of the area"),
        ("objects hit", f"{found['objects_hit']:,}"),
        ("written", f"{found['bytes']:,} bytes"),
        ("scan and write", f"{found['seconds']:.2f} s"),
    )
    for row in rows:
        table.add_row(*row)
    console.print(table)
