"""Planar features of a point cloud: arguments, work, files and printing."""

from __future__ import annotations

import argparse
import json
import shutil
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from tilesnav_ref.clouds import CloudSettings, PointCloud
from tilesnav_ref.clouds.write import write_points
from tilesnav_ref.commands.values import given_of, integer, number, numbers
from tilesnav_ref.planar import PlanarFeatures, PlaneSettings, detect_planes
from tilesnav_ref.planar.picture import (
    PictureError,
    check_picture,
    draw_features,
    draw_normal_deviations,
    feature_colours,
)
from tilesnav_ref.scene import METRES_PER_UNIT
from tilesnav_ref.survey.scans import read_scans
from tilesnav_ref.tileset.errors import OutputError
from tilesnav_ref.tileset.run_report import StageProgress

PLANES = "planes.json"
POINTS = "points.ply"
COLOURS = ("red", "green", "blue")
RECORD = np.dtype([*((axis, "<f8") for axis in "xyz"), ("feature", "<i4"), *((c, "u1") for c in COLOURS)])
"""A point of `POINTS`: metres as in the file, the number of its feature or -1, a colour for viewers."""
PLANE_NUMBERS = 10
"""A plane (4) and two corners of its rectangle (6), as the source paper stores a feature."""
WRITTEN_POINTS = 1_000_000
"""Points that are written at once."""


def add_planes(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    planes, clouds = PlaneSettings(), CloudSettings()
    parser.add_argument(
        "cloud",
        type=Path,
        metavar="CLOUD",
        help="LAS, LAZ, PLY, PCD, E57, XYZ, TXT or CSV file, or a folder of scans with poses.txt",
    )
    parser.add_argument(
        "out", type=Path, metavar="OUT", help=f"folder to make, with {PLANES} and {POINTS}; it must not exist"
    )
    parser.add_argument(
        "--plot", type=Path, metavar="FILE", help="picture of the features, .png, .svg or .pdf (extra 'plot')"
    )
    parser.add_argument(
        "--plot-normals", type=Path, metavar="FILE", help="picture of how normals deviate from their features"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--quiet", action="store_true", help="no progress")
    parser.add_argument("--seed", type=integer(0), metavar="N", help=f"start of the samples ({planes.seed})")
    parser.add_argument("--threads", type=integer(0), metavar="N", help="threads; 0: one for each processor")
    group = parser.add_argument_group("cloud")
    group.add_argument(
        "--units", choices=("auto", *METRES_PER_UNIT), help="length unit (auto: as the file says, else m)"
    )
    group.add_argument(
        "--classes", type=_classes, metavar="N,N,...", help="ASPRS classes to keep (all but 7 and 18, noise)"
    )
    group.add_argument(
        "--region", type=numbers(4), metavar="X0,Y0,X1,Y1", help="part to keep, as the file counts"
    )
    group.add_argument(
        "--poses", type=Path, metavar="FILE", help="poses of the scans (poses.txt in a folder of scans)"
    )
    group.add_argument("--thin", type=number, metavar="M", help="keep a point of each cube of this edge, m")
    group.add_argument(
        "--max-points", type=integer(1), metavar="N", help=f"most points to keep ({clouds.max_points:,})"
    )
    group = parser.add_argument_group("features")
    group.add_argument(
        "--inlier-distance", type=number, metavar="M", help="most from a plane, m (4 sigma, as measured)"
    )
    group.add_argument(
        "--normal-sigmas", type=number, metavar="N", help=f"most that normals turn ({planes.normal_sigmas:g})"
    )
    group.add_argument(
        "--min-points", type=integer(6), metavar="N", help=f"fewest points of a feature ({planes.min_points})"
    )
    group.add_argument("--radius", type=number, metavar="M", help="of neighbourhoods, m (16 neighbours)")


def _classes(text: str) -> tuple[int, ...]:
    return tuple(integer(0, 255)(part) for part in text.split(","))


def plane_figures(given: argparse.Namespace, progress: StageProgress) -> dict[str, Any]:
    """Read a cloud, find its planes, write and draw them, and return the figures as JSON values.

    Raises
    ------
    SceneError, OutputError
        The cloud cannot be read, a setting is refused, or an output cannot be made.
    """
    try:
        settings = PlaneSettings(**given_of(PlaneSettings, vars(given)))
    except ValueError as error:
        raise OutputError(str(error)) from error
    reading = CloudSettings(**given_of(CloudSettings, vars(given)))
    _check_outputs(given)
    times = [time.perf_counter()]
    progress("cloud", 0, 1)
    cloud = read_scans(given.cloud, reading, given.poses)
    progress("cloud", 1, 1)
    times.append(time.perf_counter())
    features = detect_planes(cloud.points, settings, progress)
    times.append(time.perf_counter())
    _write(given.out, (str(given.cloud), cloud), features)
    _draw(given, cloud, features)
    times.append(time.perf_counter())
    seconds = dict(zip(("read", "planes", "write"), np.diff(times).tolist(), strict=True))
    return {**_figures(cloud, features), "seconds": seconds}


def _check_outputs(given: argparse.Namespace) -> None:
    if not given.out.name or not given.out.parent.is_dir():
        raise OutputError(f"{given.out}: its parent {given.out.parent} is not a folder")
    if given.out.exists() or given.out.is_symlink():
        raise OutputError(f"{given.out}: exists already")
    for path in (given.plot, given.plot_normals):
        if path is not None:
            try:
                check_picture(path)
            except PictureError as error:
                raise OutputError(str(error)) from error


def _write(out: Path, read: tuple[str, PointCloud], features: PlanarFeatures) -> None:
    """Write the folder; it appears when it is complete."""
    source, cloud = read
    work = Path(tempfile.mkdtemp(prefix=f".{out.name}.", dir=out.parent))
    try:
        new = work / "new"
        new.mkdir()  # mkdtemp makes a folder that is private to its owner
        text = json.dumps(planes_document(source, cloud, features), indent=1)
        (new / PLANES).write_text(text + "\n", encoding="utf-8")
        colours = (feature_colours(features) * 255.0).round().astype(np.uint8)
        starts = range(0, len(cloud.points), WRITTEN_POINTS)
        write_points(new / POINTS, RECORD, (_records(cloud, features, colours, at) for at in starts))
        new.rename(out)
    finally:
        shutil.rmtree(work)


def _records(cloud: PointCloud, features: PlanarFeatures, colours: Any, start: int) -> Any:
    part = slice(start, start + WRITTEN_POINTS)
    records = np.empty(len(cloud.points[part]), RECORD)
    for axis, values in zip("xyz", (cloud.points[part] + cloud.origin).T, strict=True):
        records[axis] = values
    records["feature"] = features.labels[part]
    for channel, values in zip(COLOURS, colours[part].T, strict=True):
        records[channel] = values
    return records


def planes_document(source: str, cloud: PointCloud, features: PlanarFeatures) -> dict[str, Any]:
    """What `PLANES` holds: see docs/lidar.md."""
    extents = features.extents
    return {
        "source": Path(source).name,
        "origin": cloud.origin.tolist(),
        "metresPerUnit": cloud.metres_per_unit,
        "crs": cloud.crs,
        "points": len(cloud.points),
        "inlierDistance": features.inlier_distance,
        "normalDeviation": features.normal_deviation,
        "features": [
            {
                "normal": features.normals[k].tolist(),
                "offset": float(features.offsets[k]),
                "centroid": features.centroids[k].tolist(),
                "covariance": features.covariances[k].tolist(),
                "rms": float(features.rms[k]),
                "count": int(features.counts[k]),
                "rectangle": {
                    "centre": extents.centres[k].tolist(),
                    "axes": extents.axes[k].tolist(),
                    "halfSizes": extents.half_sizes[k].tolist(),
                },
            }
            for k in range(len(features))
        ],
    }


def _draw(given: argparse.Namespace, cloud: PointCloud, features: PlanarFeatures) -> None:
    for path, draw in ((given.plot, draw_features), (given.plot_normals, draw_normal_deviations)):
        if path is not None:
            try:
                draw(cloud.points, features, path)
            except PictureError as error:
                raise OutputError(str(error)) from error


def _figures(cloud: PointCloud, features: PlanarFeatures) -> dict[str, Any]:
    inside = int(features.counts.sum())
    areas = 4.0 * features.extents.half_sizes.prod(axis=1)
    return {
        "points": len(cloud.points),
        "metres_per_unit": cloud.metres_per_unit,
        "notes": list(cloud.notes),
        "features": len(features),
        "points_in_features": inside,
        "compression": compression(features),
        "rms": float(np.sqrt((features.rms**2 * features.counts).sum() / inside)) if inside else None,
        "inlier_distance": features.inlier_distance,
        "normal_deviation": features.normal_deviation,
        "points_of_a_feature": float(np.median(features.counts)) if len(features) else None,
        "area_of_rectangles": float(areas.sum()),
        "upright": int((np.abs(features.normals[:, 2]) < 0.1).sum()),
        "level": int((np.abs(features.normals[:, 2]) > 0.995).sum()),
    }


def compression(features: PlanarFeatures) -> float | None:
    """Share of the numbers of the points in features that features save; None without any.

    A point has three numbers, a feature `PLANE_NUMBERS`.
    """
    inside = int(features.counts.sum())
    return 1.0 - len(features) * PLANE_NUMBERS / (3.0 * inside) if inside else None


def print_planes(console: Console, found: dict[str, Any]) -> None:
    """Print the figures that :func:`plane_figures` gives."""
    table = Table()
    table.add_column("figure")
    table.add_column("value", justify="right")
    share = found["points_in_features"] / max(1, found["points"])
    rows = [
        ("points", f"{found['points']:,}"),
        ("features", f"{found['features']:,} ({found['upright']:,} upright, {found['level']:,} level)"),
        ("points in features", f"{found['points_in_features']:,} ({share:.1%})"),
        ("inlier distance", f"{1000 * found['inlier_distance']:.1f} mm"),
        ("deviation of normals", f"{np.degrees(found['normal_deviation']):.2f} degrees"),
    ]
    if found["features"]:
        rows += [
            ("points of a feature, median", f"{found['points_of_a_feature']:,.0f}"),
            ("rms distance from the plane", f"{1000 * found['rms']:.1f} mm"),
            ("numbers saved", f"{found['compression']:.2%}"),
            ("area of the rectangles", f"{found['area_of_rectangles']:,.0f} m2"),
        ]
    rows += [(f"seconds: {stage}", f"{value:,.2f}") for stage, value in found["seconds"].items()]
    for row in rows:
        table.add_row(*row)
    console.print(table)
    for note in found["notes"]:
        console.print(f"note: {note}", highlight=False)
