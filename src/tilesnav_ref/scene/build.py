"""From grid coordinates to a scene: weld, drop faces without area, node, form objects, arrange."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.arrange import Unarranged, arrange
from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.kinds import ONE_SIDED, POROUS, TERRAIN, object_flags
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.scene.noding import count_junctions, node
from tilesnav_ref.scene.objects import form_objects
from tilesnav_ref.scene.settings import SceneSettings
from tilesnav_ref.scene.topology import Topology, count_topology
from tilesnav_ref.scene.weld import check_limit, has_area, weld


@dataclass(frozen=True)
class Soup:
    """Faces on the grid as they come, with the part of the file that each is from."""

    vertices: NDArray[np.int64]
    """(V, 3) grid coordinates, nav frame."""
    faces: NDArray[np.int64]
    """(F, 3) within range."""
    part: NDArray[np.int64]
    """(F,) part of each face."""
    part_names: tuple[str, ...]
    """Name of each part."""
    part_kinds: NDArray[np.int64] | None = None
    """Kind of each part (kinds.py); None when all are opaque and two-sided."""


@dataclass(frozen=True)
class Build:
    """A scene and what was done on the way."""

    scene: Scene
    source: NDArray[np.int64]
    """(F,) face of the soup that each face of the scene is, or is a part of."""
    degenerate_removed: int
    junctions: int
    faces_before_noding: int
    faces_divided: int
    topology: Topology


def build_scene(
    soup: Soup,
    settings: SceneSettings,
    tileset_from_nav: NDArray[np.float64] | None = None,
    name: str = "scene",
) -> Build:
    """Make the scene that is published and proved.

    Parameters
    ----------
    soup : Soup
    settings : SceneSettings
    tileset_from_nav : (4, 4) float64 or None
        None for the identity.
    name : str
        Named in errors.

    Raises
    ------
    SceneError
        When a coordinate has 2**23 steps or more, or no face has area.
    """
    vertices, faces = weld(soup.vertices, soup.faces)
    check_limit(vertices, settings.grid_exponent, name)
    kept = np.flatnonzero(has_area(vertices[faces]))
    if not len(kept):
        raise SceneError(
            name, "faces", f"{len(faces)} faces, none with area on the grid", "one or more; see --units"
        )
    vertices, faces = weld(vertices, faces[kept])
    if settings.node_junctions:
        noded = node(vertices, faces, settings.max_faces)
        source, junctions = noded.source, noded.junctions
        before, faces = len(faces), noded.faces
    else:
        source, junctions, before = np.arange(len(faces)), count_junctions(vertices, faces), len(faces)
    part = soup.part[kept[source]]
    kind = np.zeros(len(part), np.int64) if soup.part_kinds is None else soup.part_kinds[part]
    face_object, names = form_objects(vertices, faces, part, soup.part_names, settings, kind)
    matrix = np.eye(4) if tileset_from_nav is None else tileset_from_nav
    mesh = Unarranged(vertices, faces, face_object, names)
    scene, order = arrange(mesh, settings.content_faces, settings.grid_exponent, matrix)
    return Build(
        scene=replace(
            scene,
            object_porous=object_flags(scene.face_object, kind[order], POROUS),
            object_one_sided=object_flags(scene.face_object, kind[order], ONE_SIDED),
            object_terrain=object_flags(scene.face_object, kind[order], TERRAIN),
        ),
        source=kept[source[order]],
        degenerate_removed=len(soup.faces) - len(kept),
        junctions=junctions,
        faces_before_noding=before,
        faces_divided=int((np.bincount(source, minlength=before) > 1).sum()),
        topology=count_topology(len(vertices), faces),
    )
