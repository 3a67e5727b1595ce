"""Which level of an object is delivered in a cell."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.stream.levels import Level, LevelScale

NAMES = ("fine", "coarse", "auto")
RESOLUTION = math.radians(2.0)
"""Angle between neighbouring beams of a VLP-16: its 16 beams share 30 degrees (Velodyne, VLP-16 user manual:
vertical resolution 2 degrees). What is smaller than that, as seen from the sensor, may fall between beams."""


@dataclass(frozen=True)
class LevelPolicy:
    """How the level of an object is chosen.

    Notes
    -----
    `fine` takes level 0, `coarse` the coarsest level. `auto` takes, for each object by its level code k in
    the cell, the coarsest level whose error e of the object has e * U <= `resolution`, with U the upper end
    of code k; level 0 where there is none, and for code 0, which has no upper end.

    *What `auto` guarantees.* L = cos(phi) / d is at most U for all points p of the cell and x of the faces of
    the object that the cell lists, and it is the rate at which the angle at p changes while x moves in its
    plane straight away from the foot of the perpendicular from p (with a from the foot and the height h this
    angle is atan(a / h), its derivative h / (h^2 + a^2) = L). So two such points that are seen under
    `resolution` or more are at least `resolution` / U >= e apart: along these lines the sensor samples a face
    no denser than the error of what stands for it.

    *What it does not.* Across these lines points are seen under up to 1 / d, so samples may be closer than e,
    most of all on a face that is seen edge on: an object with such faces only has a small L though it may be
    near. It is no bound of the error in metres, which may be that of the coarsest level, and none of the
    error of a range, which a displacement of a face changes by up to e / cos(phi) at any distance. That every
    return lies within e of a face that is delivered comes from the face map and holds for every policy.
    """

    name: str = "auto"
    resolution: float = RESOLUTION
    """Angle that the sensor does not resolve, rad; of `auto` only."""

    def __post_init__(self) -> None:
        """Check every setting: ValueError naming it."""
        if self.name not in NAMES:
            raise ValueError(f"setting policy: found {self.name!r}; allowed: {', '.join(NAMES)}")
        if not (math.isfinite(self.resolution) and self.resolution > 0.0):
            raise ValueError(
                f"setting resolution: found {self.resolution}; allowed: finite, greater than 0, in radians"
            )

    def choose(
        self,
        objects: NDArray[np.uint32],
        codes: NDArray[np.uint8],
        levels: Sequence[Level],
        scale: LevelScale,
    ) -> NDArray[np.int64]:
        """Choose a level for every object of a cell.

        Parameters
        ----------
        objects, codes : (Q,) uint32, uint8
            Objects and their level codes in the cell.
        levels : sequence of Level
            The coarse levels, ascending.
        scale : LevelScale
            What the codes stand for.

        Returns
        -------
        (Q,) int64
            0 for level 0, i + 1 for ``levels[i]``.
        """
        chosen = np.zeros(len(objects), np.int64)
        if self.name == "fine" or not levels:
            return chosen
        if self.name == "coarse":
            return chosen + len(levels)
        upper = scale.upper()[codes]
        bounded = np.isfinite(upper)
        for place, level in enumerate(levels, start=1):
            seen = np.where(bounded, level.errors[objects] * np.where(bounded, upper, 0.0), np.inf)
            chosen[seen <= self.resolution] = place
        return chosen
