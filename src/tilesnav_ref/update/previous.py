"""An earlier tileset, with everything checked that a new one is going to rest on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref import __version__
from tilesnav_ref.scene.model import COORDINATE_LIMIT, Scene
from tilesnav_ref.stream.contents import ContentRef
from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.reader import NavTileset, open_tileset
from tilesnav_ref.tileset.provenance import file_digest
from tilesnav_ref.tileset.tilejson import column_major
from tilesnav_ref.update.errors import UpdateError
from tilesnav_ref.visibility import VisibilitySettings

FREE = ("threads", "pairs", "certificates")
"""Settings that may differ: sets do not depend on the first, are equally good with any value of the second,
and are the same with and without the third."""


@dataclass(frozen=True)
class Previous:
    """A map of an earlier scene."""

    source: str
    """The file, for messages."""
    scene: Scene
    planes: NDArray[np.float64]
    """(N, 6, 4) of the cells, nav frame, m."""
    proven: NDArray[np.int64]
    """(N,) number of faces that are proven visible from each cell."""
    faces_of: Callable[[int], NDArray[np.uint32]]
    """Faces that a cell lists, ascending; TilesetError when the file does not hold what was written."""
    sha256: str
    """Digest of the entry tileset, in hexadecimal digits."""

    def check_frame(self, scene: Scene) -> None:
        """Check that coordinates mean the same in both scenes.

        Raises
        ------
        UpdateError
            When grid or nav frame differ.
        """
        if self.scene.grid_exponent != scene.grid_exponent:
            found, allowed = f"{self.scene.grid_exponent}", f"{scene.grid_exponent}, the grid of this run"
            raise UpdateError(self.source, "grid.exponent", found, allowed)
        ours, theirs = column_major(scene.tileset_from_nav), column_major(self.scene.tileset_from_nav)
        if ours != theirs:
            allowed = f"{ours}, the nav frame of this run; --origin holds it where it is"
            raise UpdateError(self.source, "transform", f"{theirs}", allowed)


def open_previous(place: Path, settings: VisibilitySettings) -> Previous:
    """Open an earlier tileset.

    Parameters
    ----------
    place : Path
        A folder with tileset.json, or the entry tileset itself.
    settings : VisibilitySettings
        Of the run that takes sets over.

    Raises
    ------
    UpdateError
        When another program, another version or other settings have made the sets, or proofs are wanted.
    TilesetError
        When a file cannot be read or is damaged.
    """
    tileset = open_tileset(place)
    _check_origin(tileset, settings)
    scene = _read_scene(tileset)
    planes = np.concatenate([sector.planes for sector in tileset.sectors])
    proven = np.concatenate([sector.proven_visible for sector in tileset.sectors]).astype(np.int64)
    faces_of = partial(_checked_faces, tileset, proven)
    return Previous(str(tileset.path), scene, planes, proven, faces_of, file_digest(tileset.path))


def _checked_faces(tileset: NavTileset, proven: NDArray[np.int64], cell: int) -> NDArray[np.uint32]:
    source, place, state = str(tileset.path), f"cell {cell}", tileset.state(cell)
    if state.digest() != tileset.digest(cell):
        raise TilesetError(source, place, "another state", "the state that its digest was made of")
    if proven[cell] > len(state.faces):
        raise TilesetError(
            source, place, f"{proven[cell]} faces proven visible", f"at most {len(state.faces)}"
        )
    return state.faces


def _check_origin(tileset: NavTileset, settings: VisibilitySettings) -> None:
    source = str(tileset.path)
    if settings.certificates:
        allowed = "no certificates: proofs of the earlier scene may rest on faces that are gone"
        raise UpdateError(source, "setting certificates", "certificates beside an update", allowed)
    encoder = f"tilesnav {__version__}"
    if tileset.provenance.get("encoder") != encoder:
        found = repr(tileset.provenance.get("encoder"))[:60]
        raise UpdateError(source, "provenance.encoder", found, f"{encoder!r}, this program")
    parameters = tileset.provenance.get("parameters")
    theirs = parameters.get("visibility") if isinstance(parameters, dict) else None
    if not isinstance(theirs, dict):
        raise UpdateError(
            source, "provenance.parameters.visibility", "nothing", "settings of the earlier run"
        )
    _compare(source, theirs, settings)
    if tileset.max_range != settings.max_range:
        raise UpdateError(source, "visibility.maxRange", f"{tileset.max_range}", f"{settings.max_range}")


def _compare(source: str, theirs: dict[str, Any], settings: VisibilitySettings) -> None:
    for name, ours in asdict(settings).items():
        if name not in FREE and theirs.get(name) != ours:
            found = repr(theirs.get(name))[:60]
            allowed = f"{ours}, the value of this run"
            raise UpdateError(source, f"provenance.parameters.visibility.{name}", found, allowed)


def _read_scene(tileset: NavTileset) -> Scene:
    counts = np.diff(tileset.object_offsets)
    corners = np.concatenate([_content_corners(tileset, content) for content in tileset.contents])
    vertices, faces = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    objects = np.arange(tileset.object_count)
    return Scene(
        vertices=vertices,
        faces=faces.reshape(-1, 3).astype(np.int32),
        face_object=np.repeat(objects, counts).astype(np.int32),
        object_content=np.repeat(
            np.arange(len(tileset.contents)), [content.object_count for content in tileset.contents]
        ).astype(np.int32),
        object_names=("",) * tileset.object_count,
        grid_exponent=round(np.log2(tileset.step)),
        tileset_from_nav=tileset.tileset_from_nav,
        object_porous=np.isin(objects, tileset.porous_objects),
        object_one_sided=np.isin(objects, tileset.one_sided_objects),
    )


def _content_corners(tileset: NavTileset, content: ContentRef) -> NDArray[np.int64]:
    """(F, 3, 3) grid coordinates of the corners of the faces of a content."""
    found = file_digest(content.path)
    if found != content.sha256:
        raise TilesetError(str(content.path), "SHA-256", found, f"{content.sha256}, as the tileset states")
    return _on_grid(tileset, content.path, "positions", tileset.corners(content.content_id))


def _on_grid(tileset: NavTileset, path: Path, place: str, metres: NDArray[Any]) -> NDArray[np.int64]:
    """Grid coordinates of lengths, exactly; the step is a power of two, so the quotient is exact."""
    steps = metres.astype(np.float64) / tileset.step
    if not (np.abs(steps) < COORDINATE_LIMIT).all() or not np.array_equal(steps, np.rint(steps)):
        allowed = f"multiples of {tileset.step:g} m below {COORDINATE_LIMIT} of them"
        raise TilesetError(str(path), place, "positions off the grid", allowed)
    return steps.astype(np.int64)
