"""A map of two contents, three objects and three cells that other tests write and read."""

from __future__ import annotations

import numpy as np

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.lod.model import LodSettings, LodTable
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.tileset.delta import make_deltas
from tilesnav_ref.tileset.model import NavMap
from tilesnav_ref.visibility.model import PvsTable

STEP = 2.0**-10


def small_scene() -> Scene:
    """Ground of two faces and a wall of two in content 0, a roof of one face in content 1."""
    ground = [[0, 0, 0], [8, 0, 0], [8, 4, 0], [0, 4, 0]]
    vertices = [*ground, [0, 4, 3], [8, 4, 3], [0, -1, 5], [8, -1, 5], [4, 3, 6]]
    faces = [[0, 1, 2], [0, 2, 3], [3, 2, 5], [3, 5, 4], [6, 7, 8]]
    return Scene(
        vertices=np.array(vertices, dtype=np.int64) * 1024,
        faces=np.array(faces, dtype=np.int32),
        face_object=np.array([0, 0, 1, 1, 2], dtype=np.int32),
        object_content=np.array([0, 0, 1], dtype=np.int32),
        object_names=("ground", "wall", "roof"),
    )


def small_cells() -> CellComplex:
    """Three cells of 2 m in a row along x, a portal between each and the next."""
    lower = np.array([[1, 1, 1], [3, 1, 1], [5, 1, 1]], dtype=np.int64) * 1024
    squares = [[[x, 1, 1], [x, 3, 1], [x, 3, 3], [x, 1, 3]] for x in (3, 5)]
    return CellComplex(
        lower=lower,
        upper=lower + 2 * 1024,
        kinds=np.array([1, 1, 0], dtype=np.uint8),
        portal_offsets=np.array([0, 1, 3, 4], dtype=np.int64),
        portal_targets=np.array([1, 0, 2, 1], dtype=np.int64),
        portal_polygons=np.array([0, 0, 1, 1], dtype=np.int64),
        polygon_offsets=np.array([0, 4, 8]),
        polygon_vertices=np.array(squares, dtype=np.float64).reshape(-1, 3) * 1024,
        clearance=256,
        coverage=0.75,
    )


def small_map() -> NavMap:
    """The scene and the cells with sets in which faces enter, leave and stay, and levels that switch."""
    cells = small_cells()
    pvs = PvsTable(
        pvs_offsets=np.array([0, 3, 7, 8], dtype=np.int64),
        pvs_faces=np.array([0, 1, 2, 0, 2, 3, 4, 4], dtype=np.uint32),
        pvs_proven=np.array([1, 1, 0, 1, 1, 1, 0, 1], dtype=np.bool_),
    )
    lod = LodTable(
        settings=LodSettings(),
        lod_offsets=np.array([0, 2, 5, 6], dtype=np.int64),
        lod_objects=np.array([0, 1, 0, 1, 2, 2], dtype=np.uint32),
        lod_codes=np.array([2, 3, 2, 1, 5, 5], dtype=np.uint8),
    )
    provenance = {"encoder": "tilesnav 0.1.0", "parameters": {}, "coverage": 0.75}
    return NavMap(small_scene(), cells, pvs, lod, make_deltas(cells, pvs, lod), provenance)


def test_small_map_is_what_the_contract_asks_of_one() -> None:
    one = small_map()
    objects_seen = [np.unique(one.scene.face_object[one.pvs.faces_of(cell)]).tolist() for cell in range(3)]
    listed = [one.lod.lod_objects[a:b].tolist() for a, b in ((0, 2), (2, 5), (5, 6))]
    assert objects_seen == listed
    assert one.pvs.proven_counts.tolist() == [2, 3, 1]
