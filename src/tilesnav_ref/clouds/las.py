"""LAS and LAZ files through laspy."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tilesnav_ref.clouds.model import PLACE, Chunk, CloudFile
from tilesnav_ref.clouds.records import missing_library, scanner_of
from tilesnav_ref.scene.errors import SceneError

LEAST_RECORD = 20
"""Bytes of the shortest point record of LAS."""


def open_las(path: Path, size: int) -> CloudFile:
    """Read the header of a LAS or LAZ file.

    Raises
    ------
    SceneError
        When it is no such file, laspy is absent, or a LAS file is shorter than its header claims.
    """
    try:
        import laspy  # noqa: PLC0415 - optional: only these files need it
    except ImportError as error:
        raise missing_library(path, "laspy", "lidar") from error
    try:
        with path.open("rb") as stream:  # laspy leaves a file open when its header is broken
            header = laspy.open(stream).header
    except Exception as error:
        raise SceneError(str(path), "header", _said(error), "a LAS or LAZ file") from error
    _check_length(path, header)
    crs, metres, notes = _coordinate_system(path, header)
    chunks = _chunks(path, laspy, size)
    return CloudFile(str(path), int(header.point_count), chunks, crs, metres, None, notes)


def _check_length(path: Path, header: Any) -> None:
    """A LAS file must hold the points that it claims; a LAZ file tells only when it is read."""
    if header.are_points_compressed:
        return
    needed = header.offset_to_point_data + header.point_count * max(LEAST_RECORD, header.point_format.size)
    held = path.stat().st_size
    if held < needed:
        claimed = f"{held} bytes where {header.point_count} points need {needed}"
        raise SceneError(str(path), "length", claimed, "a whole file")


def _chunks(path: Path, laspy: Any, size: int) -> Iterator[Chunk]:
    with path.open("rb") as stream:
        try:
            reader = laspy.open(stream)
            names = set(reader.header.point_format.dimension_names)
            for record in reader.chunk_iterator(size):
                yield _chunk(record, names)
        except (MemoryError, SceneError):  # say what it is already
            raise
        except Exception as error:
            raise SceneError(str(path), "points", _said(error), "a whole LAS or LAZ file") from error


def _chunk(record: Any, names: set[str]) -> Chunk:
    points = np.stack([np.asarray(record[axis], np.float64) for axis in ("x", "y", "z")], axis=1)
    chunk = Chunk(
        points,
        classes=np.asarray(record["classification"]).astype(np.uint8),
        returns=np.asarray(record["return_number"]).astype(np.uint8),
        return_counts=np.asarray(record["number_of_returns"]).astype(np.uint8),
        intensities=np.asarray(record["intensity"]).astype(np.float32),
        **scanner_of({name: np.asarray(record[name]) for name in ("scan", *PLACE) if name in names}),
    )
    if "withheld" in names:
        withheld = np.asarray(record["withheld"]).astype(bool)
        chunk = chunk.kept(~withheld) if withheld.any() else chunk
    return chunk


def _coordinate_system(path: Path, header: Any) -> tuple[str | None, float | None, tuple[str, ...]]:
    """WKT; metres of a unit, not a number where there is one that is not known; and notes."""
    records = {type(vlr).__name__ for vlr in header.vlrs}
    if not records & {"WktCoordinateSystemVlr", "GeoKeyDirectoryVlr"}:
        return None, None, ()
    try:
        import pyproj  # noqa: F401, PLC0415 - optional: laspy reads coordinate systems through it
    except ImportError:
        return None, math.nan, ("the coordinate system was not read: no pyproj (extra 'crs')",)
    try:
        crs = header.parse_crs()
    except Exception as error:  # noqa: BLE001 - whatever pyproj makes of broken records
        return None, math.nan, (f"the coordinate system was not read: {_said(error)}",)
    if crs is None:
        return None, math.nan, ("the coordinate system was not understood",)
    if crs.is_geographic:
        raise SceneError(str(path), "coordinate system", f"{crs.name}, in degrees", "a projected one")
    factors = [float(axis.unit_conversion_factor) for axis in crs.axis_info]
    if len(factors) < 2 or max(factors) - min(factors) > 1e-9 or not factors[0] > 0:
        return crs.to_wkt(), math.nan, (f"{crs.name} has the units {factors}, in metres",)
    notes: tuple[str, ...] = ()
    if len(factors) == 2 and factors[0] != 1.0:
        notes = (f"heights taken to be in the unit of the map: {crs.axis_info[0].unit_name}",)
    return crs.to_wkt(), factors[0], notes


def _said(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"[:200]
