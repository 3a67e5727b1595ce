"""The order in which faces and objects are published.

References
----------
G. M. Morton, A computer oriented geodetic data base, 1966 (interleaved bits keep neighbours near each other).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.model import COORDINATE_LIMIT, Scene
from tilesnav_ref.scene.objects import kd_groups, object_boxes


@dataclass(frozen=True)
class Unarranged:
    """Noded faces with their objects, in any order."""

    vertices: NDArray[np.int64]
    """(V, 3) grid coordinates, each used by a face."""
    faces: NDArray[np.int64]
    """(F, 3)."""
    face_object: NDArray[np.int64]
    """(F,) 0 to K - 1, each used."""
    object_names: tuple[str, ...]
    """(K,)."""


def arrange(
    mesh: Unarranged, content_faces: int, grid_exponent: int, tileset_from_nav: NDArray[np.float64]
) -> tuple[Scene, NDArray[np.int64]]:
    """Order contents, their objects and the objects' faces in space.

    Parameters
    ----------
    mesh : Unarranged
    content_faces : int
        Faces that a content holds at most, unless one object has more.
    grid_exponent : int
    tileset_from_nav : (4, 4) float64

    Returns
    -------
    scene : Scene
    order : (F,) int64
        ``order[i]`` is the face of the mesh that is face i of the scene; a permutation.

    Notes
    -----
    Contents are the leaves of a tree of weighted medians; objects of a content and faces of an object
    follow the Morton order of their middles; ties keep the given order. So equal input gives equal output.
    """
    if not len(mesh.faces):
        empty = np.zeros(0, np.int32)
        none = Scene(
            mesh.vertices, np.zeros((0, 3), np.int32), empty, empty, (), grid_exponent, tileset_from_nav
        )
        return none, np.zeros(0, np.int64)
    lower, upper = object_boxes(mesh.vertices, mesh.faces, mesh.face_object)
    middles = (lower + upper) >> 1
    groups = kd_groups(middles, np.bincount(mesh.face_object), content_faces)
    ordered = np.concatenate([group[np.argsort(morton(middles[group]), kind="stable")] for group in groups])
    content = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
    rank = np.empty(len(ordered), np.int64)
    rank[ordered] = np.arange(len(ordered))
    face_rank = rank[mesh.face_object]
    codes = morton(mesh.vertices[mesh.faces].sum(axis=1) // 3)
    order = np.lexsort((np.arange(len(codes)), codes, face_rank))
    scene = Scene(
        vertices=mesh.vertices,
        faces=mesh.faces[order].astype(np.int32),
        face_object=face_rank[order].astype(np.int32),
        object_content=content.astype(np.int32),
        object_names=tuple(mesh.object_names[k] for k in ordered),
        grid_exponent=grid_exponent,
        tileset_from_nav=tileset_from_nav,
    )
    return scene, order


def morton(points: NDArray[np.int64]) -> NDArray[np.uint64]:
    """Interleave 21 bits of each coordinate; the lowest three of the 24 bits on the grid are left out.

    Parameters
    ----------
    points : (N, 3) int64
        Grid coordinates of magnitude below 2**23.

    Returns
    -------
    (N,) uint64
    """
    code = np.zeros(len(points), np.uint64)
    shifted = ((points + COORDINATE_LIMIT) >> 3).astype(np.uint64)
    for k in range(3):
        x = shifted[:, k]
        for shift, mask in (
            (32, 0x1F00000000FFFF),
            (16, 0x1F0000FF0000FF),
            (8, 0x100F00F00F00F00F),
            (4, 0x10C30C30C30C30C3),
            (2, 0x1249249249249249),
        ):
            x = (x | (x << np.uint64(shift))) & np.uint64(mask)
        code |= x << np.uint64(k)
    return code
