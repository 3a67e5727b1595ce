"""E57 files through pye57."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.clouds.model import Chunk, CloudFile
from tilesnav_ref.clouds.records import missing_library
from tilesnav_ref.scene.errors import SceneError

CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ")
SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")


def open_e57(path: Path, size: int) -> CloudFile:
    """Read the headers of all scans of an E57 file.

    Raises
    ------
    SceneError
        When it is no E57 file, has no scan, or pye57 is absent.
    """
    try:
        import pye57  # noqa: PLC0415 - optional: only these files need it
    except ImportError as error:
        raise missing_library(path, "pye57", "e57") from error
    try:
        file = pye57.E57(str(path))
        headers = [file.get_header(number) for number in range(file.scan_count)]
        claimed = sum(int(header.point_count) for header in headers)
        posed = any(header.has_pose() for header in headers)
        origins = np.array([header.translation for header in headers], np.float64).reshape(-1, 3)
    except Exception as error:
        raise SceneError(str(path), "header", f"{error}"[:200], "an E57 file") from error
    if not headers:
        raise SceneError(str(path), "header", "no scan", "an E57 file with one scan or more")
    chunks = _chunks(path, file, headers, size)
    return CloudFile(str(path), claimed, chunks, scan_origins=origins if posed else None)


def _chunks(path: Path, file: Any, headers: list[Any], size: int) -> Iterator[Chunk]:
    with file:
        for number, header in enumerate(headers):
            try:
                yield from _scan(path, file, (number, header), size)
            except (MemoryError, SceneError):  # say what it is already
                raise
            except Exception as error:
                found = f"{error}"[:200]
                raise SceneError(str(path), f"scan {number}", found, "a whole E57 file") from error


def _scan(path: Path, file: Any, scan: tuple[int, Any], size: int) -> Iterator[Chunk]:
    """Points of one scan, in the frame of the file."""
    number, header = scan
    present = set(header.point_fields)
    place = next((names for names in (CARTESIAN, SPHERICAL) if present.issuperset(names)), None)
    if place is None:
        raise SceneError(str(path), f"scan {number}", f"fields {sorted(present)}", "x, y, z or ranges")
    invalid = "cartesianInvalidState" if place is CARTESIAN else "sphericalInvalidState"
    extra = [name for name in ("intensity", invalid) if name in present]
    data, buffers = file.make_buffers([*place, *extra], min(size, max(1, header.point_count)))
    reader = header.points.reader(buffers)
    turn, shift = np.asarray(header.rotation_matrix), np.asarray(header.translation, np.float64)
    while count := reader.read():
        columns = np.stack([data[name][:count] for name in place], axis=1)
        points = (columns if place is CARTESIAN else _cartesian(columns)) @ turn.T + shift
        intensities = data["intensity"][:count].copy() if "intensity" in data else None
        chunk = Chunk(points, intensities=intensities, scans=np.full(count, number, np.int32))
        yield chunk.kept(data[invalid][:count] == 0) if invalid in data else chunk


def _cartesian(columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """From range, azimuth and elevation (radians; ASTM E2807)."""
    away, azimuth, elevation = columns.T
    flat = away * np.cos(elevation)
    return np.stack((flat * np.cos(azimuth), flat * np.sin(azimuth), away * np.sin(elevation)), axis=1)
