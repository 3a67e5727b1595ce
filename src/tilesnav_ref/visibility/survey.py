"""What rays see from a group of cells: uniform lines first, then lines aimed next to what is seen.

References
----------
P. Wonka, M. Wimmer, K. Zhou, S. Maierhofer, G. Hesina, A. Reshetov, Guided visibility sampling, ACM TOG 25
(2006): what is next to a visible triangle is worth a ray.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.visibility.geometry import UNLIMITED, Geometry
from tilesnav_ref.visibility.limits import leave_out
from tilesnav_ref.visibility.lines import CellPrisms, cell_prisms, share_lines, share_passed, worth_aiming
from tilesnav_ref.visibility.sampling import (
    RayCaster,
    directions_to,
    points_on_faces,
    points_within,
    random_directions,
    random_points,
)
from tilesnav_ref.visibility.settings import VisibilitySettings

CHUNK = 1 << 15
"""Lines in one call, which bounds the memory of a thread."""

Each = Callable[[Callable[[int], None], Iterable[int]], None]
"""Calls a function for each of some numbers, on any threads in any order, and returns when all are done."""


@dataclass(frozen=True)
class Survey:
    """A group of cells under survey; rows of `seen` belong to them in their order."""

    geometry: Geometry
    caster: RayCaster
    cells: CellPrisms
    ids: NDArray[np.int64]
    """(N,) number of each cell in the whole complex, ascending."""
    neighbours: tuple[NDArray[np.int64], ...]
    """Rows behind the portals of each cell, as far as they are in the group."""
    settings: VisibilitySettings
    seen: NDArray[np.uint8]
    """(N, F) 1 where an exact segment from the cell sees the face."""


def make_survey(
    scene: tuple[Geometry, RayCaster],
    complex_: CellComplex,
    prisms: NDArray[np.float64],
    ids: NDArray[np.int64],
    settings: VisibilitySettings,
) -> Survey:
    """Prepare a group: prisms (C, 8, 3) of all cells in fine units, ascending numbers (N,) of its own."""
    geometry, caster = scene
    seen = np.zeros((len(ids), len(geometry.corners)), np.uint8)
    near = tuple(_rows_behind(complex_, cell, ids) for cell in ids)
    return Survey(geometry, caster, cell_prisms(prisms[ids]), ids, near, settings, seen)


def _rows_behind(complex_: CellComplex, cell: int, ids: NDArray[np.int64]) -> NDArray[np.int64]:
    targets = complex_.portal_targets[complex_.portal_offsets[cell] : complex_.portal_offsets[cell + 1]]
    rows = np.minimum(np.searchsorted(ids, targets), len(ids) - 1)
    return np.asarray(rows[ids[rows] == targets], np.int64)


def run_survey(survey: Survey, each: Each) -> None:
    """Fill `survey.seen`; the result depends on the seed and not on the order in which `each` goes."""
    each(lambda row: _uniform(survey, row), range(len(survey.ids)))
    for number in range(1, survey.settings.aimed_rounds + 1):
        before = survey.seen.copy()
        each(lambda row, n=number, b=before: _aimed(survey, row, n, b), range(len(survey.ids)))  # type: ignore[misc]


def _uniform(survey: Survey, row: int) -> None:
    random = np.random.default_rng([survey.settings.seed, survey.ids[row]])
    for begin in range(0, survey.settings.rays, CHUNK):
        number = min(CHUNK, survey.settings.rays - begin)
        points = random_points(random, survey.cells.prisms[row], number)
        _share(survey, points, random_directions(random, number))


def _aimed(survey: Survey, row: int, number: int, before: NDArray[np.uint8]) -> None:
    """Aim at faces that are likely to be seen, judged by what was seen `before` this round."""
    random = np.random.default_rng([survey.settings.seed, survey.ids[row], number])
    wanted = worth_aiming(survey.geometry, before, row, survey.neighbours[row])
    within = np.ones(len(survey.geometry.corners), np.bool_)
    leave_out(survey.geometry, survey.cells.prisms[row], within)
    wanted = np.repeat(wanted[within[wanted]], survey.settings.aimed_rays)
    for begin in range(0, len(wanted), CHUNK):
        faces = wanted[begin : begin + CHUNK]
        prism = survey.cells.prisms[row]
        points = random_points(random, prism, len(faces))
        targets = points_on_faces(random, survey.geometry.corners, faces)
        if survey.geometry.far < UNLIMITED:
            points = points_within(random, prism, targets, survey.geometry.near)
        _share(survey, points, directions_to(points, targets))


def _share(survey: Survey, points: NDArray[np.float64], directions: NDArray[np.float32]) -> None:
    both = np.concatenate([points, points]), np.concatenate([directions, -directions])
    if not survey.caster.has_porous:
        hits = survey.caster.first_hits(*both)
        share_lines(survey.geometry, survey.cells, (points, directions), hits, survey.seen)
        return
    hits, free = survey.caster.opaque_hits(*both)
    share_lines(survey.geometry, survey.cells, (points, directions), hits, survey.seen)
    for passed in survey.caster.porous_hits(*both, free):
        share_passed(survey.geometry, survey.cells, (points, directions, free), passed, survey.seen)
