"""Coarse levels: what is asked for, and what is found."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.model import Scene

LEVELS_MAX = 3
"""Fine, median and coarse."""


@dataclass(frozen=True)
class LevelSettings:
    """How many levels are made, and how far their faces may lie from the finest ones.

    Notes
    -----
    A level is ruled by its error and not by its number of faces, since a client matches a scan within a
    distance. With the first default, reveals of the usual depth of 0.2 m go and the two sides of a thin wall
    become one; with the second, openings of 1 m are closed, no point of which is farther than half of that
    from their frame.
    """

    levels: int = 1
    """1 (finest only), 2 (and median) or 3 (and coarse)."""
    level_errors: tuple[float, ...] = (0.25, 0.6)
    """Metres; greatest distance of the faces of the median and of the coarse level from the finest ones, and
    the other way round. With two levels the first is used."""

    def __post_init__(self) -> None:
        """Check every setting: ValueError naming it."""
        if not 1 <= self.levels <= LEVELS_MAX:
            raise ValueError(f"setting levels: found {self.levels}; allowed: 1 to {LEVELS_MAX}")
        errors = self.level_errors
        sound = all(math.isfinite(error) and error > 0 for error in errors)
        if not sound or any(b <= a for a, b in itertools.pairwise(errors)):
            raise ValueError(
                f"setting level_errors: found {errors}; allowed: finite, greater than 0, ascending"
            )
        if len(errors) < self.levels - 1:
            raise ValueError(
                f"setting level_errors: found {len(errors)} for {self.levels} levels;"
                " allowed: one for each level but the finest"
            )


@dataclass(frozen=True)
class CoarseLevel:
    """A coarse level of a scene, with the same objects and contents.

    Notes
    -----
    Every point of a fine face is within the error of its object of a point of a coarse face that stands for
    it, and every point of a coarse face within that of a fine face that it stands for.
    """

    level: int
    """1 or more."""
    scene: Scene
    """The faces; vertices are vertices of the fine scene. Every object has a face."""
    errors: NDArray[np.float64]
    """(K,) proven bound of the distance, of every object, m."""
    offsets: NDArray[np.int64]
    """(F + 1,) fine faces that each coarse face stands for."""
    fine_faces: NDArray[np.uint32]
    """(P,) numbers of fine faces, of the object of the coarse face, ascending for each coarse face. Every
    fine face is listed once at least."""
