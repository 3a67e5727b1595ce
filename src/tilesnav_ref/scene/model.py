"""The scene that is published and proved: exact grid coordinates, faces in their final order."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.planes import PlaneTable
from tilesnav_ref.scene.unknown import UnknownSpace

COORDINATE_LIMIT = 1 << 23
"""Every grid coordinate is smaller than this in magnitude, so that differences fit 24 bits."""


@dataclass(frozen=True)
class Scene:
    """Faces on the grid, in the order in which the tileset publishes them.

    Notes
    -----
    Face i belongs to object ``face_object[i]`` and object j to content ``object_content[j]``; both arrays
    never decrease, so the position of a face is its number in the file.
    """

    vertices: NDArray[np.int64]
    """(V, 3) grid coordinates in the nav frame; metres = value * step."""
    faces: NDArray[np.int32]
    """(F, 3) indices into vertices; no degenerate faces."""
    face_object: NDArray[np.int32]
    """(F,) object of each face."""
    object_content: NDArray[np.int32]
    """(K,) content of each object."""
    object_names: tuple[str, ...]
    """(K,) names for people; not unique."""
    grid_exponent: int = -10
    """The step is 2**grid_exponent metres."""
    tileset_from_nav: NDArray[np.float64] = field(default_factory=lambda: np.eye(4))
    """(4, 4) rigid motion from the nav frame to the frame of the entry tileset."""
    object_porous: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, np.bool_))
    """(K,) whether an object is seen and hides nothing; empty when none is porous."""
    object_one_sided: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, np.bool_))
    """(K,) whether the faces of an object are seen from their front only; empty when none is one-sided."""
    object_terrain: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, np.bool_))
    """(K,) whether an object is the ground, by its name; empty when none was named."""
    unknown: UnknownSpace | None = None
    """Space that the survey says nothing about and that no cell may be in; None: all of it is known."""
    planes: PlaneTable | None = None
    """Planes of a survey that the faces lie on; None where the scene was not made from planes."""

    @property
    def step(self) -> float:
        """Grid step in metres."""
        return float(2.0**self.grid_exponent)

    @property
    def face_count(self) -> int:
        """Number of faces."""
        return len(self.faces)

    @property
    def object_count(self) -> int:
        """Number of objects."""
        return len(self.object_content)

    @property
    def content_count(self) -> int:
        """Number of contents."""
        return int(self.object_content[-1]) + 1 if len(self.object_content) else 0

    @property
    def porous(self) -> NDArray[np.bool_]:
        """(F,) whether each face is porous."""
        return self._of_faces(self.object_porous)

    @property
    def one_sided(self) -> NDArray[np.bool_]:
        """(F,) whether each face is one-sided."""
        return self._of_faces(self.object_one_sided)

    @property
    def terrain(self) -> NDArray[np.bool_] | None:
        """(F,) whether each face is the ground, by its name; None when none was named."""
        return self._of_faces(self.object_terrain) if len(self.object_terrain) else None

    def _of_faces(self, flags: NDArray[np.bool_]) -> NDArray[np.bool_]:
        return flags[self.face_object] if len(flags) else np.zeros(len(self.faces), np.bool_)

    def corners(self) -> NDArray[np.int64]:
        """(F, 3, 3) grid coordinates of the corners of every face."""
        return self.vertices[self.faces]
