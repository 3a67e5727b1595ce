"""Reading of point clouds, in pieces, into one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.clouds.e57 import open_e57
from tilesnav_ref.clouds.las import open_las
from tilesnav_ref.clouds.model import Chunk, CloudFile, PointCloud
from tilesnav_ref.clouds.pcd import open_pcd
from tilesnav_ref.clouds.ply import open_ply
from tilesnav_ref.clouds.settings import NOISE_CLASSES, CloudSettings
from tilesnav_ref.clouds.text import open_text
from tilesnav_ref.clouds.thinning import Thinning
from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.settings import METRES_PER_UNIT

OPENERS: dict[str, Callable[[Path, int], CloudFile]] = {
    ".las": open_las,
    ".laz": open_las,
    ".ply": open_ply,
    ".pcd": open_pcd,
    ".e57": open_e57,
    ".xyz": open_text,
    ".txt": open_text,
    ".csv": open_text,
}
FAR = 1e9
"""Greatest coordinate, metres: farther is no place on the Earth, and float64 has 0.1 micrometres there."""
ROUND = 100.0
"""The local origin is a multiple of this, metres."""


def open_cloud(path: Path, chunk_points: int) -> CloudFile:
    """Read the header of a point cloud.

    Raises
    ------
    SceneError
        When the file cannot be read or is not what its name says.
    """
    opener = OPENERS.get(path.suffix.lower())
    if opener is None:
        raise SceneError(str(path), "name", repr(path.suffix), ", ".join(OPENERS))
    try:
        with path.open("rb"):
            pass
        return opener(path, chunk_points)
    except OSError as error:
        raise SceneError(str(path), "file", error.strerror or str(error), "a readable file") from error


def cloud_chunks(
    source: Path | CloudFile, settings: CloudSettings
) -> Iterator[tuple[Chunk, CloudFile, float]]:
    """Read a file, or one whose header has been read, in pieces of at most `chunk_points`, whatever its size.

    Yields
    ------
    Chunk
        Points in metres, finite, of the classes and the region asked for.
    CloudFile
        The header.
    float
        Metres of a unit of the file.
    """
    file = source if isinstance(source, CloudFile) else open_cloud(source, settings.chunk_points)
    metres = METRES_PER_UNIT.get(settings.units) or file.metres_per_unit or 1.0
    if math.isnan(metres):
        found = "; ".join(file.notes)
        raise SceneError(file.source, "coordinate system", found, "one whose unit is known, or --units")
    try:
        for chunk in file.chunks:
            wanted = _wanted(chunk, settings)
            if len(wanted.points):
                _check_far(file, wanted.points, metres)
                if wanted.places is not None:
                    _check_far(file, wanted.places, metres)
                yield wanted.moved(metres, np.zeros(3)), file, metres
    except OSError as error:
        raise SceneError(file.source, "points", error.strerror or str(error), "a readable file") from error


def read_cloud(source: Path | CloudFile, settings: CloudSettings | None = None) -> PointCloud:
    """Read a point cloud.

    Parameters
    ----------
    source : Path or CloudFile
        A file with one of the endings in `OPENERS`, or one whose header has been read.
    settings : CloudSettings

    Raises
    ------
    SceneError
        When the file cannot be read, is broken, or has no point that is wanted, or too many.
    """
    settings = settings or CloudSettings()
    kept: list[Chunk] = []
    origin: NDArray[np.float64] | None = None
    thinning = Thinning(settings.thin)
    held = 0
    read: tuple[CloudFile, float] | None = None
    for chunk, file, metres in cloud_chunks(source, settings):
        read = (file, metres)
        if origin is None:
            origin = np.floor(chunk.points.min(axis=0) / ROUND) * ROUND
        local = thinning.kept(chunk.moved(1.0, -origin))
        held += len(local.points)
        if held > settings.max_points:
            allowed = f"at most {settings.max_points}; use --thin or --region"
            raise SceneError(file.source, "points", f"more than {settings.max_points}", allowed)
        kept.append(local)
    if origin is None or read is None:
        name = source.source if isinstance(source, CloudFile) else str(source)
        raise SceneError(name, "points", "none that is finite and wanted", "one point or more")
    return _joined(kept, origin, read)


def _wanted(chunk: Chunk, settings: CloudSettings) -> Chunk:
    """Points with finite coordinates, in the region, of the classes."""
    keep = np.isfinite(chunk.points).all(axis=1)
    if settings.region is not None:
        x0, y0, x1, y1 = settings.region
        x, y = chunk.points[:, 0], chunk.points[:, 1]
        keep &= (x >= x0) & (x < x1) & (y >= y0) & (y < y1)
    if chunk.classes is not None:
        if settings.classes:
            keep &= np.isin(chunk.classes, settings.classes)
        else:
            keep &= ~np.isin(chunk.classes, NOISE_CLASSES)
    return chunk if keep.all() else chunk.kept(np.asarray(keep))


def _check_far(file: CloudFile, points: NDArray[np.float64], metres: float) -> None:
    far = ~(np.abs(points).max(axis=1) * metres <= FAR)  # also what is no number
    if far.any():
        place = points[np.argmax(far)].tolist()
        raise SceneError(file.source, "points", f"one at {place}", f"coordinates within {FAR:g} m")


def _joined(kept: list[Chunk], origin: NDArray[np.float64], read: tuple[CloudFile, float]) -> PointCloud:
    file, metres = read
    parts: dict[str, Any] = {}
    for number, name in enumerate(Chunk._fields):
        columns = [chunk[number] for chunk in kept]
        parts[name] = None if any(c is None for c in columns) else np.concatenate(columns)  # type: ignore[arg-type]
    scan_origins = None if file.scan_origins is None else file.scan_origins * metres - origin
    if scan_origins is None:
        parts["scans"] = None
    elif parts["scans"] is None:
        parts["scans"] = np.zeros(len(parts["points"]), np.int32)
    notes = file.notes
    lost = "" if file.claimed is None else f" of {file.claimed}"
    if file.claimed != len(parts["points"]):
        notes = (*notes, f"{len(parts['points'])}{lost} points kept")
    return PointCloud(
        origin=origin,
        metres_per_unit=metres,
        scan_origins=scan_origins,
        crs=file.crs,
        notes=notes,
        **parts,
    )
