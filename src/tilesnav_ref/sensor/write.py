"""Writing of scans to files, one scan at a time, so that a long route needs little memory."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterable
from datetime import date
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tilesnav_ref.sensor.errors import ScanError
from tilesnav_ref.sensor.mcap_file import mcap_writer, write_mcap
from tilesnav_ref.sensor.model import Returns, Scan

LAS_STEP = 0.001
"""Metres; the coordinates of a LAS file are multiples of it, far below the noise of any scanner."""
NO_DAY = date(2000, 1, 1)
"""Creation date of LAS files, which must have one: a simulation has no day; the same bytes every time."""
COUNT_DIGITS = 12
"""Digits of the count in the header of a PLY file, which is known only when all is written."""

POSES = "poses.txt"
POSES_HEADER = "# time x y z qx qy qz qw: seconds, metres, unit quaternion; nav frame from scanner\n"
"""First line of the file of poses, a trajectory as the TUM RGB-D benchmark and the tool evo know it."""

PLY_TYPES = {"<f8": "double", "<f4": "float", "<i4": "int", "|u1": "uchar"}
PLY_RECORD = np.dtype(
    [
        ("x", "<f8"),
        ("y", "<f8"),
        ("z", "<f8"),
        ("time", "<f8"),
        ("scan", "<i4"),
        ("face", "<i4"),
        ("object", "<i4"),
        ("true_range", "<f4"),
        ("beam", "u1"),
    ]
)
"""A point of a PLY file."""

LAS_DIMENSIONS = {"scan": "int32", "face": "int32", "object": "int32", "true_range": "float32"}
"""What a LAS file has besides the dimensions of point format 6."""


def write_scans(scans: Iterable[Scan], path: Path) -> int:
    """Write the points of scans with time, scan, beam, true face, object and range.

    Parameters
    ----------
    scans : iterable of Scan
        Taken one by one.
    path : Path
        .ply (binary), .las or .laz: all points in the nav frame. .mcap: messages of ROS 2. Without an
        ending: a folder with a PLY file a scan, each in the frame of the scanner at its first firing as if
        it had stood still, and `POSES`, the true poses. It must not exist; nothing is there until all is.

    Returns
    -------
    Points written.

    Raises
    ------
    ScanError
        Another ending, something at that path, a parent that is no folder, a missing extra, or coordinates
        beyond what LAS can hold.
    """
    check_output(path)
    return _completed(path, lambda part: WRITERS[path.suffix.lower()](scans, part))


def check_output(path: Path) -> None:
    """Refuse what cannot be written, before any work is done.

    Raises
    ------
    ScanError
        See :func:`write_scans`.
    """
    suffix = path.suffix.lower()
    if suffix not in WRITERS:
        named = ", ".join(name for name in WRITERS if name)
        raise ScanError(str(path), f"the ending {path.suffix!r}", f"{named}, or none for a folder")
    if not path.parent.is_dir():
        raise ScanError(str(path), f"{path.parent}, which is no folder", "a folder that exists")
    if path.exists():
        raise ScanError(str(path), "something there", "a name that is free")
    if suffix in (".las", ".laz"):
        _laspy()
    if suffix == ".mcap":
        mcap_writer()


def _completed(path: Path, write: Callable[[Path], int]) -> int:
    """Write to a name beside, then rename."""
    part = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        count = write(part)
        part.replace(path)
    finally:
        if part.is_dir():
            shutil.rmtree(part)
        else:
            part.unlink(missing_ok=True)
    return count


def _write_ply(scans: Iterable[Scan], path: Path) -> int:
    count = 0
    with path.open("wb") as file:
        place = _ply_header(file)
        for scan in scans:
            file.write(ply_records(scan.returns, scan.returns.points).tobytes())
            count += len(scan.returns)
        file.seek(place)
        file.write(f"{count:0{COUNT_DIGITS}d}".encode())
    return count


def _ply_header(file: BinaryIO) -> int:
    """Write the header and return where the count stands in it."""
    head = b"ply\nformat binary_little_endian 1.0\nelement vertex "
    kinds = [(name, PLY_TYPES[PLY_RECORD[name].str]) for name in PLY_RECORD.names or ()]
    rest = "".join(f"property {kind} {name}\n" for name, kind in kinds)
    file.write(head + b"0" * COUNT_DIGITS + b"\n" + rest.encode() + b"end_header\n")
    return len(head)


def ply_records(returns: Returns, points: NDArray[np.float64]) -> np.ndarray[Any, np.dtype[np.void]]:
    """(N,) records of `PLY_RECORD` with the given coordinates (N, 3)."""
    records = np.empty(len(returns), PLY_RECORD)
    for axis, name in enumerate("xyz"):
        records[name] = points[:, axis]
    records["time"], records["scan"], records["beam"] = returns.times, returns.scans, returns.beams
    records["face"], records["object"] = returns.faces, returns.objects
    records["true_range"] = returns.true_ranges
    return records


def _write_folder(scans: Iterable[Scan], path: Path) -> int:
    count = 0
    path.mkdir()
    with (path / POSES).open("w", encoding="ascii") as poses:
        poses.write(POSES_HEADER)
        for scan in scans:
            with (path / f"scan_{scan.number:06d}.ply").open("wb") as file:
                place = _ply_header(file)
                file.write(ply_records(scan.returns, scan.points_in_scanner()).tobytes())
                file.seek(place)
                file.write(f"{len(scan.returns):0{COUNT_DIGITS}d}".encode())
            poses.write(_pose_line(scan))
            count += len(scan.returns)
    return count


def _pose_line(scan: Scan) -> str:
    place = scan.nav_from_scanner[:3, 3]
    turn = Rotation.from_matrix(scan.nav_from_scanner[:3, :3]).as_quat(canonical=True)
    return f"{scan.time:.6f} " + " ".join(f"{value:.9f}" for value in (*place, *turn)) + "\n"


def _write_las(scans: Iterable[Scan], path: Path) -> int:
    laspy = _laspy()
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.scales, header.offsets = np.full(3, LAS_STEP), np.zeros(3)
    header.creation_date = NO_DAY
    header.generating_software = "tilesnav scan"
    header.add_extra_dims([laspy.ExtraBytesParams(name, kind) for name, kind in LAS_DIMENSIONS.items()])
    count = 0
    with laspy.open(path, mode="w", header=header) as writer:
        for scan in scans:
            if len(scan.returns):
                writer.write_points(_las_points(laspy, header, scan.returns, path))
                count += len(scan.returns)
    return count


def _las_points(laspy: Any, header: Any, returns: Returns, path: Path) -> Any:
    reach = float(np.abs(returns.points).max())
    if reach >= 2**31 * LAS_STEP:
        raise ScanError(str(path), f"a coordinate of {reach:.0f} m", f"less than {2**31 * LAS_STEP:.0f} m")
    points = laspy.ScaleAwarePointRecord.zeros(len(returns), header=header)
    points.x, points.y, points.z = returns.points.T
    points.gps_time = returns.times
    points.return_number = points.number_of_returns = np.ones(len(returns), np.uint8)
    points.user_data = returns.beams
    points.scan, points.face, points.object = returns.scans, returns.faces, returns.objects
    points.true_range = returns.true_ranges.astype(np.float32)
    return points


def _laspy() -> Any:
    try:
        import laspy  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise ScanError(
            "LAS and LAZ", "no laspy", "the extra 'lidar': pip install 'tilesnav[lidar]'"
        ) from error
    return laspy


WRITERS: dict[str, Callable[[Iterable[Scan], Path], int]] = {
    ".ply": _write_ply,
    ".las": _write_las,
    ".laz": _write_las,
    ".mcap": write_mcap,
    "": _write_folder,
}
