"""tileset.json: the tree of tiles and the extension's entry object."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref import __version__
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.tileset.bounds import box_volume, diagonal
from tilesnav_ref.tileset.content import Content
from tilesnav_ref.tileset.model import EXTENSION, SPEC_VERSION, NavMap

Json = dict[str, Any]


@dataclass(frozen=True)
class SideFile:
    """A certificate file or a face map that has been written."""

    uri: str
    sha256: str


@dataclass(frozen=True)
class Sector:
    """A nav file that has been written."""

    uri: str
    first: int
    """Number of its first cell."""
    last: int
    """Number behind that of its last cell."""
    certificates: SideFile | None = None


@dataclass(frozen=True)
class Tile:
    """A content that has been written, without its bytes."""

    uri: str
    extension: Json
    lower: NDArray[np.int64]
    upper: NDArray[np.int64]
    error: float = 0.0
    """Distance of its faces from those of level 0 at most, m."""
    finer: Tile | None = None
    """What replaces it where more detail is asked for."""


def content_tile(uri: str, content_id: int, content: Content) -> Tile:
    """State what tileset.json says about a content of level 0."""
    extension: Json = {
        "contentId": content_id,
        "level": 0,
        "faceCount": content.face_count,
        "objectCount": content.object_count,
        "sha256": hashlib.sha256(content.data).hexdigest(),
    }
    flags = {"porous": content.porous, "oneSided": content.one_sided}
    extension.update({name: list(objects) for name, objects in flags.items() if objects})
    return Tile(uri, extension, content.lower, content.upper)


def coarse_tile(content: Tile, level: int, error: float, face_map: SideFile, finer: Tile) -> Tile:
    """State what tileset.json says about a content of a coarse level, from what it says of any content.

    Notes
    -----
    The finer tile lies within the coarser one, and is not shown where the coarser one is good enough; so the
    box and the error of the coarser one are not less.
    """
    return Tile(
        content.uri,
        {**content.extension, "level": level, "faceMap": vars(face_map)},
        np.minimum(content.lower, finer.lower),
        np.maximum(content.upper, finer.upper),
        max(error, finer.error),
        finer,
    )


def tileset_json(nav_map: NavMap, tiles: list[Tile], sectors: list[Sector]) -> Json:
    """Make the entry tileset.

    Notes
    -----
    The root has no content, so refining it replaces nothing and adds everything: with ADD a viewer shows
    each child as soon as it is there, with REPLACE it would hold all of them back until the last one has
    come. The finest level has a geometric error of 0, a coarser one its measured distance from it; what is
    missing while none of them is shown is the whole scene, so the error of the root is the diagonal of its
    box.
    """
    scene = nav_map.scene
    lower = np.min([tile.lower for tile in tiles], axis=0)
    upper = np.max([tile.upper for tile in tiles], axis=0)
    error = max(diagonal(lower, upper, scene.step), *(tile.error for tile in tiles))
    return {
        "asset": {"version": "1.1", "generator": f"tilesnav {__version__}"},
        "extensionsUsed": [EXTENSION],
        "extensions": {EXTENSION: _entry(nav_map, sectors)},
        "geometricError": error,
        "root": {
            "transform": column_major(scene.tileset_from_nav),
            "boundingVolume": {"box": box_volume(lower, upper, scene.step)},
            "geometricError": error,
            "refine": "ADD",
            "children": [_child(scene, tile) for tile in tiles],
        },
    }


def column_major(transform: NDArray[np.float64]) -> list[float]:
    """Return the 16 elements of a (4, 4) matrix, column after column."""
    return [float(v) + 0.0 for v in transform.T.ravel()]


def _child(scene: Scene, tile: Tile) -> Json:
    child: Json = {
        "boundingVolume": {"box": box_volume(tile.lower, tile.upper, scene.step)},
        "geometricError": tile.error if tile.finer else 0,
        "content": {"uri": tile.uri, "extensions": {EXTENSION: tile.extension}},
    }
    if tile.finer:
        child |= {"refine": "REPLACE", "children": [_child(scene, tile.finer)]}
    return child


def _entry(nav_map: NavMap, sectors: list[Sector]) -> Json:
    limits = {} if nav_map.max_range is None else {"visibility": {"maxRange": nav_map.max_range}}
    scene, cells, pvs, lod = nav_map.scene, nav_map.cells, nav_map.pvs, nav_map.lod.settings
    return {
        "version": SPEC_VERSION,
        "grid": {"exponent": scene.grid_exponent},
        "transform": column_major(scene.tileset_from_nav),
        "clearance": cells.clearance * scene.step,
        "faceCount": scene.face_count,
        "objectCount": scene.object_count,
        "cellCount": cells.count,
        "portalCount": cells.portal_count,
        "sectors": [_sector(nav_map, sector) for sector in sectors],
        "lod": {"reference": lod.reference, "base": lod.base, "levelCount": lod.level_count},
        "pvs": {"listed": len(pvs.pvs_faces), "provenVisible": int(pvs.proven_counts.sum())},
        **limits,
        "provenance": nav_map.provenance,
    }


def _sector(nav_map: NavMap, sector: Sector) -> Json:
    cells = slice(sector.first, sector.last)
    lower = nav_map.cells.lower[cells].min(axis=0)
    upper = nav_map.cells.upper[cells].max(axis=0)
    listed: Json = {
        "uri": sector.uri,
        "firstCell": sector.first,
        "cellCount": sector.last - sector.first,
        "boundingVolume": {"box": box_volume(lower, upper, nav_map.scene.step)},
    }
    if sector.certificates is not None:
        listed["certificates"] = vars(sector.certificates)
    return listed
