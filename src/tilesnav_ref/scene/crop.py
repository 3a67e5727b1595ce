"""Cropping to a region without cutting a face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.topology import face_components


@dataclass(frozen=True)
class Crop:
    """Which faces a region keeps."""

    keep: NDArray[np.bool_]
    """(F,)."""
    components: int
    """Components that are kept, in whole or in part."""
    cut_components: int
    """Components that are kept in part."""


def crop(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    region: tuple[float, float, float, float],
    margin: float,
) -> Crop:
    """Keep whole components that meet the region; of components larger than it, only the faces near it.

    Parameters
    ----------
    vertices : (V, 3) float64
        Welded positions.
    faces : (F, 3) int64
    region : (x0, y0, x1, y1)
        Closed rectangle in the unit of the vertices.
    margin : float
        How much the rectangle grows for components that are larger than the region in x and in y.

    Notes
    -----
    A building is kept whole because half a building is open, and inside and outside would lose their meaning.
    Ground is one component of the whole town, so it is cut down, to whole faces.
    """
    component = face_components(len(vertices), faces)
    count = int(component.max()) + 1 if len(faces) else 0
    corners = vertices[faces][:, :, :2]
    lower = np.full((count, 2), np.inf)
    upper = np.full((count, 2), -np.inf)
    np.minimum.at(lower, component, corners.min(axis=1))
    np.maximum.at(upper, component, corners.max(axis=1))
    x0, y0, x1, y1 = region
    large = ((upper - lower) > (x1 - x0, y1 - y0)).all(axis=1)
    touched = np.zeros(count, bool)
    touched[component[meets_rectangle(corners, region)]] = True
    near = meets_rectangle(corners, (x0 - margin, y0 - margin, x1 + margin, y1 + margin))
    keep = touched[component] & (near | ~large[component])
    partly = np.zeros(count, bool)
    partly[component[~keep]] = True
    return Crop(keep, int(touched.sum()), int((touched & partly).sum()))


def meets_rectangle(
    corners: NDArray[np.float64], region: tuple[float, float, float, float]
) -> NDArray[np.bool_]:
    """Whether the plan of each triangle meets a closed rectangle, by separating axes.

    Parameters
    ----------
    corners : (F, 3, 2) float64
    region : (x0, y0, x1, y1)

    Returns
    -------
    (F,) bool
    """
    lower, upper = np.array(region[:2]), np.array(region[2:])
    meets = ((corners.min(axis=1) <= upper) & (corners.max(axis=1) >= lower)).all(axis=1)
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    for i in range(3):
        along = corners[:, (i + 1) % 3] - corners[:, i]
        normal = np.stack((-along[:, 1], along[:, 0]), axis=1)
        offset = np.einsum("fij,fj->fi", corners - middle, normal)
        reach = np.abs(normal) @ half
        meets &= (offset.min(axis=1) <= reach) & (offset.max(axis=1) >= -reach)
    return np.asarray(meets)
