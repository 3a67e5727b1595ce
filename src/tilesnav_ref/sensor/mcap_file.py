"""Writing of scans as an MCAP recording with messages of ROS 2.

Notes
-----
The topics are ``/points`` (sensor_msgs/msg/PointCloud2), ``/pose`` (geometry_msgs/msg/PoseStamped, the
truth) and ``/tf`` (tf2_msgs/msg/TFMessage, the same). Points are raw: each is in the frame of the scanner at
its own time, ``time`` seconds after the stamp, so a scan of a moving scanner is bent as it is in practice.

References
----------
MCAP specification, https://mcap.dev/spec; ROS Enhancement Proposals 103 and 105 for the frames.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tilesnav_ref.sensor.errors import ScanError
from tilesnav_ref.sensor.model import Scan
from tilesnav_ref.sensor.ros_messages import POINT_CLOUD, POSE_STAMPED, TF_MESSAGE

EPOCH = 1_000_000_000
"""Seconds of the clock of the messages at which a route begins; zero means "the newest" to readers of tf."""
NAV_FRAME, SCANNER_FRAME = "map", "lidar"

POINT_RECORD = np.dtype(
    [
        ("x", "<f4"),
        ("y", "<f4"),
        ("z", "<f4"),
        ("time", "<f4"),
        ("face", "<i4"),
        ("ring", "<u2"),
    ]
)
"""A point of a message: `ring` is the beam, `face` the true face."""
FIELD_TYPES = {"<f4": 7, "<i4": 5, "<u2": 4}
"""Constants of sensor_msgs/msg/PointField."""


def write_mcap(scans: Iterable[Scan], path: Path) -> int:
    """Write scans and true poses; returns the number of points.

    Raises
    ------
    ScanError
        When the extra is missing.
    """
    writer_of = mcap_writer()
    count = 0
    with path.open("wb") as file:
        writer = writer_of(file)
        clouds = writer.register_msgdef("sensor_msgs/msg/PointCloud2", POINT_CLOUD)
        poses = writer.register_msgdef("geometry_msgs/msg/PoseStamped", POSE_STAMPED)
        frames = writer.register_msgdef("tf2_msgs/msg/TFMessage", TF_MESSAGE)
        for sequence, scan in enumerate(scans):
            stamp = EPOCH * 10**9 + round(scan.time * 1e9)
            messages = (
                ("/tf", frames, {"transforms": [_transform(scan, stamp)]}),
                ("/pose", poses, {"header": _header(stamp, NAV_FRAME), "pose": _pose(scan)}),
                ("/points", clouds, _cloud(scan, stamp)),
            )
            for topic, schema, message in messages:
                writer.write_message(topic, schema, message, stamp, stamp, sequence)
            count += len(scan.returns)
        writer.finish()
    return count


def mcap_writer() -> Any:
    """Class that writes messages of ROS 2 to MCAP.

    Raises
    ------
    ScanError
        When the extra is missing.
    """
    try:
        from mcap_ros2.writer import Writer  # noqa: PLC0415 - an extra
    except ImportError as error:
        allowed = "the extra 'lidar': pip install 'tilesnav[lidar]'"
        raise ScanError("MCAP", "no mcap-ros2-support", allowed) from error
    return Writer


def _header(stamp: int, frame: str) -> dict[str, Any]:
    return {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": frame}


def _xyz(values: NDArray[np.float64]) -> dict[str, float]:
    return {"x": float(values[0]), "y": float(values[1]), "z": float(values[2])}


def _turn(scan: Scan) -> dict[str, float]:
    x, y, z, w = Rotation.from_matrix(scan.nav_from_scanner[:3, :3]).as_quat()
    return {"x": float(x), "y": float(y), "z": float(z), "w": float(w)}


def _pose(scan: Scan) -> dict[str, Any]:
    return {"position": _xyz(scan.nav_from_scanner[:3, 3]), "orientation": _turn(scan)}


def _transform(scan: Scan, stamp: int) -> dict[str, Any]:
    motion = {"translation": _xyz(scan.nav_from_scanner[:3, 3]), "rotation": _turn(scan)}
    return {"header": _header(stamp, NAV_FRAME), "child_frame_id": SCANNER_FRAME, "transform": motion}


def _cloud(scan: Scan, stamp: int) -> dict[str, Any]:
    returns = scan.returns
    records = np.empty(len(returns), POINT_RECORD)
    for axis, name in enumerate("xyz"):
        records[name] = returns.raw[:, axis]
    records["time"] = returns.times - scan.time
    records["face"], records["ring"] = returns.faces, returns.beams
    return {
        "header": _header(stamp, SCANNER_FRAME),
        "height": 1,
        "width": len(records),
        "fields": _fields(),
        "is_bigendian": False,
        "point_step": POINT_RECORD.itemsize,
        "row_step": POINT_RECORD.itemsize * len(records),
        "data": records.tobytes(),
        "is_dense": True,
    }


def _fields() -> list[dict[str, Any]]:
    described: dict[str, Any] = dict(POINT_RECORD.fields or {})
    return [
        {"name": name, "offset": kind[1], "datatype": FIELD_TYPES[kind[0].str], "count": 1}
        for name, kind in described.items()
    ]
