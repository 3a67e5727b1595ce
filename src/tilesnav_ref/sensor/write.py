"""Writing of scans to files, one scan at a time, so that a long route needs little memory."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tilesnav_ref.clouds.model import PLACE
from tilesnav_ref.clouds.write import SUFFIXES, Records, check_suffix, completed, write_points
from tilesnav_ref.sensor.errors import ScanError
from tilesnav_ref.sensor.mcap_file import mcap_writer, write_mcap
from tilesnav_ref.sensor.model import Returns, Scan

POSES = "poses.txt"
POSES_HEADER = "# time x y z qx qy qz qw: seconds, metres, unit quaternion; nav frame from scanner\n"
"""First line of the file of poses, a trajectory as the TUM RGB-D benchmark and the tool evo know it."""
RECORD = np.dtype(
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
        *((name, "<f8") for name in PLACE),
    ]
)
"""A point of a PLY or LAS file. LAS has `time` as gps_time, `beam` as user_data, others as extra bytes.
The last three are where the scanner was, in the frame of the point."""


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
        Another ending, something at that path, a parent that is no folder, or a missing extra.
    SceneError
        A missing extra, or coordinates beyond what LAS can hold.
    """
    check_output(path)
    suffix = path.suffix.lower()
    if suffix in SUFFIXES:
        return write_points(path, RECORD, (records(scan.returns) for scan in scans))
    return completed(path, lambda part: (write_mcap if suffix else _write_folder)(scans, part))


def check_output(path: Path) -> None:
    """Refuse what cannot be written, before any work is done.

    Raises
    ------
    ScanError, SceneError
        See :func:`write_scans`.
    """
    suffix = path.suffix.lower()
    if suffix not in (*SUFFIXES, ".mcap", ""):
        allowed = f"{', '.join(SUFFIXES)}, .mcap, or none for a folder"
        raise ScanError(str(path), f"the ending {path.suffix!r}", allowed)
    if not path.parent.is_dir():
        raise ScanError(str(path), f"{path.parent}, which is no folder", "a folder that exists")
    if path.exists():
        raise ScanError(str(path), "something there", "a name that is free")
    if suffix in SUFFIXES:
        check_suffix(path)
    if suffix == ".mcap":
        mcap_writer()


def records(returns: Returns, scan: Scan | None = None) -> Records:
    """(N,) records of `RECORD`, with coordinates in the nav frame or in that of a scan."""
    filled = np.empty(len(returns), RECORD)
    for names, places in (("xyz", returns.points), (PLACE, returns.places)):
        local = places if scan is None else scan.in_scanner(places)
        for axis, name in enumerate(names):
            filled[name] = local[:, axis]
    filled["time"], filled["scan"], filled["beam"] = returns.times, returns.scans, returns.beams
    filled["face"], filled["object"] = returns.faces, returns.objects
    filled["true_range"] = returns.true_ranges
    return filled


def _write_folder(scans: Iterable[Scan], path: Path) -> int:
    count = 0
    path.mkdir()
    with (path / POSES).open("w", encoding="ascii") as poses:
        poses.write(POSES_HEADER)
        for scan in scans:
            local = records(scan.returns, scan)
            count += write_points(path / f"scan_{scan.number:06d}.ply", RECORD, (local,))
            poses.write(_pose_line(scan))
    return count


def _pose_line(scan: Scan) -> str:
    place = scan.nav_from_scanner[:3, 3]
    turn = Rotation.from_matrix(scan.nav_from_scanner[:3, :3]).as_quat(canonical=True)
    return f"{scan.time:.6f} " + " ".join(f"{value:.9f}" for value in (*place, *turn)) + "\n"
