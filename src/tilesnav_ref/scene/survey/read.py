"""Point clouds as a survey needs them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError

CLOUD_SUFFIXES = (".las", ".laz", ".pcd", ".e57", ".xyz")
_HEADER_BYTES = 1 << 16


@dataclass(frozen=True)
class Survey:
    """Returns of a survey."""

    points: NDArray[np.float64]
    """(N, 3) in the unit and axes of the file."""
    classes: NDArray[np.uint8] | None = None
    """(N,) ASPRS class of each."""
    origins: NDArray[np.float64] | None = None
    """(N, 3) where the scanner was."""

    def only(self, chosen: NDArray[np.bool_]) -> Survey:
        """The chosen returns (N,)."""
        classes = None if self.classes is None else self.classes[chosen]
        return Survey(self.points[chosen], classes, None if self.origins is None else self.origins[chosen])


def is_cloud(path: Path) -> bool:
    """Whether a file is a point cloud, by its name; a PLY file is one when its header claims no face."""
    suffix = path.suffix.lower()
    if suffix != ".ply":
        return suffix in CLOUD_SUFFIXES
    try:
        with path.open("rb") as file:
            header = file.read(_HEADER_BYTES).partition(b"end_header")[0]
    except OSError:
        return False  # the reader of meshes says what is wrong
    words = [line.split() for line in header.splitlines()]
    faces = [line[2] for line in words if line[:2] == [b"element", b"face"] and len(line) > 2]
    return header.startswith(b"ply") and faces in ([], [b"0"])


def read_survey(path: Path) -> Survey:
    import laspy
    las = laspy.read(path)
    return Survey(np.asarray(las.xyz, np.float64), np.asarray(las.classification, np.uint8))
