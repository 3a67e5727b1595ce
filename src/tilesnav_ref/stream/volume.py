"""Volume of cells that are given by their planes."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull


def cell_volumes(planes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Volume of every cell.

    Parameters
    ----------
    planes : (N, 6, 4) float64
        Unit normal n and d; inside is n.x + d <= 0, metres.

    Returns
    -------
    (N,) float64
        Cubic metres; 0 for a cell without interior.

    Notes
    -----
    Boxes along the axes are a product; other cells are the convex hull of their vertices.

    Examples
    --------
    >>> lower = [[-1.0, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0]]
    >>> upper = [[1.0, 0, 0, -1], [0, 1, 0, -2], [0, 0, 1, -3]]
    >>> cell_volumes(np.array([lower + upper])).tolist()
    [6.0]
    """
    volumes = np.empty(len(planes))
    boxes = _are_boxes(planes)
    # The plane of normal +1 is at -d, that of normal -1 at +d': they are -(d + d') apart.
    axes = np.argmax(np.abs(planes[boxes, :, :3]), axis=2)
    extents = np.stack([-np.where(axes == axis, planes[boxes, :, 3], 0.0).sum(axis=1) for axis in range(3)])
    volumes[boxes] = np.prod(np.maximum(extents, 0.0), axis=0)
    for cell in np.flatnonzero(~boxes):
        volumes[cell] = _hull_volume(planes[cell])
    return volumes


def _are_boxes(planes: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Cells whose normals are the six directions of the axes, each once."""
    directions = np.concatenate((np.eye(3), -np.eye(3)))
    same = np.all(planes[:, :, None, :3] == directions, axis=3)
    return np.asarray(np.all(same.sum(axis=1) == 1, axis=1), dtype=np.bool_)


def _hull_volume(planes: NDArray[np.float64]) -> float:
    vertices = []
    for chosen in combinations(range(len(planes)), 3):
        normals, offsets = planes[chosen, :3], planes[chosen, 3]
        # Three unit normals of a smaller determinant have no well-defined common point.
        if abs(np.linalg.det(normals)) > 1e-9:
            point = np.linalg.solve(normals, -offsets)
            # Rounding of the solution: about 1e-16 times the coordinate, divided by the determinant.
            if np.all(planes[:, :3] @ point + planes[:, 3] <= 1e-6):
                vertices.append(point)
    # Fewer than four points, or points in one plane (within the slack above), have no hull.
    if len(vertices) < 4 or np.linalg.matrix_rank(np.array(vertices) - vertices[0], tol=1e-5) < 3:
        return 0.0
    return float(ConvexHull(np.array(vertices)).volume)
