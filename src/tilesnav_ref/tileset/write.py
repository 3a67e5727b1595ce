"""Writing a tileset into a folder."""

from __future__ import annotations

import hashlib
import json
import logging
import re
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.levels.model import CoarseLevel
from tilesnav_ref.tileset.certificates import certificate_file
from tilesnav_ref.tileset.container import Buffer
from tilesnav_ref.tileset.content import make_content
from tilesnav_ref.tileset.delta import state_digests
from tilesnav_ref.tileset.errors import EncodeError
from tilesnav_ref.tileset.facemap import face_map_file, objects_of
from tilesnav_ref.tileset.model import NavMap, TilesetSettings
from tilesnav_ref.tileset.nav import CellArrays, nav_file
from tilesnav_ref.tileset.tilejson import Sector, SideFile, Tile, coarse_tile, content_tile, tileset_json

NUMBERS = re.compile(r"\[\n[-+.,\w\s]*\]")
"""An array of numbers over several lines; the line break tells it from the text of a string."""

log = logging.getLogger(__name__)


def write_tileset(
    folder: Path, nav_map: NavMap, planes: NDArray[np.float64], settings: TilesetSettings
) -> None:
    """Write contents, nav files and tileset.json.

    Parameters
    ----------
    folder : Path
        Exists and is empty.
    nav_map : NavMap
        Results of all stages.
    planes : (N, 6, 4) float64
        Outward unit normal and d of every plane of every cell, inside is n.x + d <= 0, nav frame, metres.
    settings : TilesetSettings
        How cells are shared out to nav files.

    Raises
    ------
    EncodeError
        When there are no cells, or more of anything than readers accept.

    Notes
    -----
    The files depend on the arguments alone: no time, name of a host or number of threads gets into them.
    tileset.json is written last.
    """
    _check(nav_map, planes, settings)
    tiles = _write_contents(folder, nav_map)
    sectors = _write_sectors(folder, nav_map, planes, settings)
    document = tileset_json(nav_map, tiles, sectors)
    text = json.dumps(document, indent=1, allow_nan=False)
    (folder / "tileset.json").write_text(NUMBERS.sub(_one_line, text) + "\n", encoding="utf-8")


def _one_line(numbers: re.Match[str]) -> str:
    return re.sub(r"\s+", " ", numbers.group()).replace("[ ", "[").replace(" ]", "]")


def _check(nav_map: NavMap, planes: NDArray[np.float64], settings: TilesetSettings) -> None:
    cells, pvs, lod = nav_map.cells, nav_map.pvs, nav_map.lod
    if cells.count == 0:
        raise EncodeError("there is no cell to publish")
    lengths = {
        "cells.portal_offsets": (len(cells.portal_offsets), cells.count + 1),
        "pvs_offsets": (len(pvs.pvs_offsets), cells.count + 1),
        "lod_offsets": (len(lod.lod_offsets), cells.count + 1),
        "entered_offsets": (len(nav_map.deltas.entered_offsets), cells.portal_count + 1),
        "planes": (len(planes), cells.count),
        "face_object": (len(nav_map.scene.face_object), nav_map.scene.face_count),
    }
    for name, (found, needed) in lengths.items():
        if found != needed:
            raise ValueError(f"{name} has {found} rows; needed are {needed}")
    if settings.cells_per_sector < 1:
        raise ValueError(f"cells_per_sector is {settings.cells_per_sector}; allowed: 1 or greater")


def _write_contents(folder: Path, nav_map: NavMap) -> list[Tile]:
    (folder / "contents").mkdir()
    tiles = []
    for number in range(nav_map.scene.content_count):
        content = make_content(nav_map.scene, number)
        uri = f"contents/{number}.glb"
        (folder / uri).write_bytes(content.data)
        tile = content_tile(uri, number, content)
        for level in nav_map.coarse:
            tile = _write_coarse(folder, level, number, tile)
        tiles.append(tile)
    log.info("wrote %d contents", len(tiles))
    return tiles


def _write_coarse(folder: Path, level: CoarseLevel, number: int, finer: Tile) -> Tile:
    """Write a content of a coarse level and its face map."""
    content = make_content(level.scene, number)
    uri = f"contents/{number}-{level.level}.glb"
    (folder / uri).write_bytes(content.data)
    face_map = _write_side_file(folder, f"contents/{number}-{level.level}.fmap", face_map_file(level, number))
    error = float(level.errors[objects_of(level, number)].max())
    return coarse_tile(content_tile(uri, number, content), level.level, error, face_map, finer)


def _write_side_file(folder: Path, uri: str, parts: Iterable[Buffer]) -> SideFile:
    digest = hashlib.sha256()
    with (folder / uri).open("wb") as file:
        for part in parts:
            file.write(part)
            digest.update(part)
    return SideFile(uri, digest.hexdigest())


def _write_certificates(
    folder: Path, nav_map: NavMap, nav_uri: str, first: int, last: int
) -> SideFile | None:
    certificates = nav_map.pvs.certificates
    if certificates is None:
        return None
    uri = nav_uri.removesuffix(".nav") + ".cert"
    return _write_side_file(folder, uri, certificate_file(certificates, first, last))


def file_ranges(cells: CellComplex, most: int) -> list[tuple[int, int]]:
    """First cell of every nav file and the one behind its last: sectors in their order, and those with more
    cells than ``most`` in several files."""
    borders = cells.sector_offsets.tolist() if len(cells.sector_offsets) else [0, cells.count]
    return [
        (first, min(first + most, end))
        for start, end in pairwise(borders)
        for first in range(start, end, most)
    ]


def _write_sectors(
    folder: Path, nav_map: NavMap, planes: NDArray[np.float64], settings: TilesetSettings
) -> list[Sector]:
    (folder / "nav").mkdir()
    arrays = CellArrays(planes=planes, digests=state_digests(nav_map.pvs, nav_map.lod))
    sectors = []
    for number, (first, last) in enumerate(file_ranges(nav_map.cells, settings.cells_per_sector)):
        uri = f"nav/{number}.nav"
        with (folder / uri).open("wb") as file:
            file.writelines(nav_file(nav_map, arrays, first, last))
        sectors.append(Sector(uri, first, last, _write_certificates(folder, nav_map, uri, first, last)))
    log.info("wrote %d nav files", len(sectors))
    return sectors
