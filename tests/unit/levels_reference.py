"""Distances by another program, and meshes, for the tests of coarse levels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from trimesh.triangles import closest_point

Array = NDArray[Any]


def lattice(parts: int) -> Array:
    """Barycentric weights of points of a triangle."""
    return np.array([(parts - i - j, i, j) for i in range(parts + 1) for j in range(parts + 1 - i)]) / parts


def farthest(corners: Array, triangles: Array, parts: int) -> float:
    """Greatest distance of a point on a lattice of one triangle from the nearest of some triangles."""
    points = lattice(parts) @ corners
    least = np.full(len(points), np.inf)
    for triangle in triangles:
        nearest = closest_point(np.repeat(triangle[None], len(points), axis=0), points)
        least = np.minimum(least, np.linalg.norm(points - nearest, axis=1))
    return float(least.max())


def plate(columns: int, rows: int, size: int = 1024) -> tuple[Array, Array]:
    """A flat rectangle of squares."""
    x, y = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1), indexing="ij")
    vertices = np.stack((x.ravel() * size, y.ravel() * size, np.zeros(x.size, int)), axis=1)
    corner = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (
        part.ravel() for part in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:])
    )
    return vertices, np.concatenate((np.stack((a, b, c), 1), np.stack((a, c, d), 1)))


def recessed(depth: int) -> tuple[Array, Array]:
    """A plate of 5 x 5 squares whose middle one lies deeper, with the sides of the recess."""
    vertices, faces = plate(5, 5)
    inner = [14, 20, 21, 15]  # corners of the middle square
    is_middle = np.array([set(face) <= set(inner) for face in faces])
    deep = np.arange(len(vertices), len(vertices) + 4)
    vertices = np.concatenate((vertices, vertices[inner] - (0, 0, depth)))
    sides = [(inner[k], inner[k - 3], deep[k - 3]) for k in range(4)]
    sides += [(inner[k], deep[k - 3], deep[k]) for k in range(4)]
    pane = [(deep[0], deep[1], deep[2]), (deep[0], deep[2], deep[3])]
    return vertices, np.concatenate((faces[~is_middle], sides, pane))
