"""Writing of points with further fields as PLY, LAS or LAZ, piece by piece.

References
----------
ASPRS LAS specification 1.4 - R15; G. Turk: the PLY polygon file format (1994).
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterable
from datetime import date
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError

Records = NDArray[np.void]
"""Points with fields x, y, z (float64, metres) and any others."""

SUFFIXES = (".ply", ".las", ".laz")
LAS_STEP = 0.001
"""Metres; the coordinates of a LAS file are multiples of it, far below the noise of any scanner."""
LAS_ROUND = 1000.0
"""Metres; the offset of a LAS file is a multiple of it."""
NO_DAY = date(2000, 1, 1)
"""Creation date of LAS files, which must have one; a fixed one, so that the bytes are the same every time."""
COUNT_DIGITS = 12
"""Digits of the count in the header of a PLY file, which is known only when all is written."""
PLY_TYPES = {"<f8": "double", "<f4": "float", "<i4": "int", "<u2": "ushort", "|u1": "uchar"}
LAS_NAMES = {"time": "gps_time", "beam": "user_data"}
"""Fields that LAS has a place for; all others become extra bytes."""


def write_points(path: Path, record: np.dtype[Any], chunks: Iterable[Records]) -> int:
    """Write points; the file appears when it is complete.

    Parameters
    ----------
    path : Path
        .ply (binary), .las or .laz; replaced.
    record : dtype
        x, y, z as little-endian float64, and other fields of `PLY_TYPES`.
    chunks : iterable of (n,) records

    Returns
    -------
    Points written.

    Raises
    ------
    SceneError
        Another ending, laspy is missing, or coordinates beyond what LAS can hold.
    """
    check_suffix(path)
    writer = _write_ply if path.suffix.lower() == ".ply" else _write_las
    return completed(path, lambda part: writer(part, record, chunks))


def check_suffix(path: Path) -> None:
    """Refuse an ending that cannot be written here and now.

    Raises
    ------
    SceneError
        See :func:`write_points`.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise SceneError(str(path), "name", repr(path.suffix), ", ".join(SUFFIXES))
    if suffix != ".ply":
        _laspy(path)


def completed(path: Path, write: Callable[[Path], int]) -> int:
    """Write to a name beside, then rename; nothing is left of what fails."""
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


def _write_ply(path: Path, record: np.dtype[Any], chunks: Iterable[Records]) -> int:
    count = 0
    with path.open("wb") as file:
        place = _ply_header(file, record)
        for chunk in chunks:
            file.write(chunk.tobytes())
            count += len(chunk)
        file.seek(place)
        file.write(f"{count:0{COUNT_DIGITS}d}".encode())
    return count


def _ply_header(file: BinaryIO, record: np.dtype[Any]) -> int:
    """Write the header and return where the count stands in it."""
    head = b"ply\nformat binary_little_endian 1.0\nelement vertex "
    kinds = [(name, PLY_TYPES[record[name].str]) for name in record.names or ()]
    rest = "".join(f"property {kind} {name}\n" for name, kind in kinds)
    file.write(head + b"0" * COUNT_DIGITS + b"\n" + rest.encode() + b"end_header\n")
    return len(head)


def _write_las(path: Path, record: np.dtype[Any], chunks: Iterable[Records]) -> int:
    laspy = _laspy(path)
    own = [name for name in record.names or () if name not in "xyz" and name not in LAS_NAMES]
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.scales, header.creation_date = np.full(3, LAS_STEP), NO_DAY
    header.generating_software = "tilesnav"
    header.add_extra_dims([laspy.ExtraBytesParams(name, record[name].newbyteorder("=").name) for name in own])
    count, writer = 0, None
    try:
        for chunk in chunks:
            if not len(chunk):
                continue
            if writer is None:
                header.offsets = np.floor([chunk[axis].min() / LAS_ROUND for axis in "xyz"]) * LAS_ROUND
                writer = laspy.open(path, mode="w", header=header)
            writer.write_points(_las_points(laspy, header, chunk, path))
            count += len(chunk)
        writer = writer or laspy.open(path, mode="w", header=header)
    finally:
        if writer is not None:
            writer.close()
    return count


def _las_points(laspy: Any, header: Any, chunk: Records, path: Path) -> Any:
    for axis, offset in zip("xyz", header.offsets, strict=True):
        reach = float(np.abs(chunk[axis] - offset).max())
        if reach >= 2**31 * LAS_STEP:
            allowed = f"less than {2**31 * LAS_STEP:.0f} m from the first"
            raise SceneError(str(path), "points", f"one {reach:.0f} m away in {axis}", allowed)
    points = laspy.ScaleAwarePointRecord.zeros(len(chunk), header=header)
    points.return_number = points.number_of_returns = np.ones(len(chunk), np.uint8)
    for name in chunk.dtype.names or ():
        setattr(points, LAS_NAMES.get(name, name), chunk[name])
    return points


def _laspy(path: Path) -> Any:
    try:
        import laspy  # noqa: PLC0415 - an extra
    except ImportError as error:
        allowed = "the extra 'lidar': pip install 'tilesnav[lidar]'"
        raise SceneError(str(path), "LAS", "no laspy", allowed) from error
    return laspy
