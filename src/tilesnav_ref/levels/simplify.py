"""Coarse levels of a scene, object by object."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.levels.contract import contract_within
from tilesnav_ref.levels.deviation import bound_distance, near_pairs
from tilesnav_ref.levels.model import CoarseLevel, LevelSettings
from tilesnav_ref.levels.prepare import prepare
from tilesnav_ref.processors import thread_count
from tilesnav_ref.scene.arrange import morton
from tilesnav_ref.scene.model import Scene

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Progress = Callable[[int, int], None]

ATTEMPTS = (1.0, 0.8, 0.6)
"""Bounds that a contraction is given, in parts of the error that is allowed. It looks at samples, so the
error that is proven can be greater than its bound."""
FINENESS = 2.0**-6
"""Part of the allowed error below which errors are not told apart."""
ROUNDING = 2.0**-10
"""Grid steps added to a proven bound. Coordinates below 2^23 steps, their differences and the corners of cut
pieces are off by less than 2^-25 steps in float64, and so are distances; this is 2^15 times more."""


@dataclass(frozen=True)
class _Simplified:
    """Coarse faces of one object."""

    faces: Ints
    """(C, 3) numbers of vertices of the scene."""
    error: float
    """Grid steps."""
    pairs: Ints
    """(P, 2) coarse face and fine face, numbered within the object, ascending."""


def coarse_levels(
    scene: Scene, settings: LevelSettings, progress: Progress | None = None, threads: int = 0
) -> tuple[CoarseLevel, ...]:
    """Make the coarse levels of a scene.

    Parameters
    ----------
    scene : Scene
        Without faces that have no area.
    settings : LevelSettings
    progress : called with the finished and all objects.
    threads : int
        0: one for each processor. The result does not depend on it.

    Returns
    -------
    tuple of CoarseLevel
        From fine to coarse, one less than `settings.levels`; every level is made from the finest one.
    """
    bounds = [error / scene.step for error in settings.level_errors[: settings.levels - 1]]
    firsts = np.searchsorted(scene.face_object, np.arange(scene.object_count + 1))
    faces = scene.faces.astype(np.int64)
    todo = [(bound, k) for bound in bounds for k in range(scene.object_count)]

    def run(task: tuple[float, int]) -> _Simplified:
        bound, k = task
        return simplify_object(scene.vertices, faces[firsts[k] : firsts[k + 1]], bound)

    found: list[_Simplified] = []
    with ThreadPoolExecutor(thread_count(threads)) as pool:
        for one in pool.map(run, todo):
            found.append(one)
            if progress is not None:
                progress(len(found), len(todo))
    parts = [found[i : i + scene.object_count] for i in range(0, len(found), scene.object_count or 1)]
    return tuple(_level(scene, firsts, i + 1, part) for i, part in enumerate(parts))


def simplify_object(vertices: Ints, faces: Ints, bound: float) -> _Simplified:
    """Simplify the faces of one object within an error.

    Parameters
    ----------
    vertices : (V, 3) int64
        Grid coordinates.
    faces : (F, 3) int64
        With area; one at least.
    bound : float
        Grid steps, greater than 0.

    Returns
    -------
    _Simplified
        Error at most `bound` + ROUNDING; the faces themselves where contractions do not lead to less.
    """
    used, local = np.unique(faces, return_inverse=True)
    local = local.reshape(-1, 3)
    # Near the origin float64 has more digits below the point.
    points = (vertices[used] - vertices[used[0]]).astype(np.float64)
    for coarse in _attempts(points, local, bound):
        error = _deviation(points[local], points[coarse], bound)
        if error <= bound:
            ordered = coarse[_along_the_curve(vertices[used[coarse]])]
            return _Simplified(used[ordered], error + ROUNDING, _pairs(points[local], points[ordered], error))
    same = np.arange(len(faces))
    return _Simplified(faces, ROUNDING, np.stack((same, same), axis=1))


def _along_the_curve(corners: Ints) -> NDArray[np.intp]:
    """Order of faces that faces of a scene have, too: neighbours in space get numbers near each other."""
    return np.argsort(morton(corners.sum(axis=1) // 3), kind="stable")


def _attempts(points: Floats, faces: Ints, bound: float) -> Iterator[Ints]:
    """Faces after contractions within smaller and smaller bounds."""
    for share in ATTEMPTS:
        surface = prepare(points, faces, share * bound)
        if not contract_within(surface, share * bound):
            return
        yield surface.faces[surface.alive]


def _deviation(fine: Floats, coarse: Floats, bound: float) -> float:
    """Proven bound of the distance of both from each other, grid steps."""
    away = bound_distance(fine, coarse, bound * FINENESS)
    return float(max(away, bound_distance(coarse, fine, max(away, bound * FINENESS))))


def _pairs(fine: Floats, coarse: Floats, error: float) -> Ints:
    """(P, 2) coarse and fine faces that are near each other, so that the error holds both ways."""
    stood_for = near_pairs(fine, coarse, error)[:, ::-1]
    return np.unique(np.concatenate((stood_for, near_pairs(coarse, fine, error))), axis=0)


def _level(scene: Scene, firsts: Ints, level: int, parts: list[_Simplified]) -> CoarseLevel:
    """Join the objects of a level."""
    sizes = np.array([len(part.faces) for part in parts], np.int64)
    before = np.concatenate(([0], np.cumsum(sizes)))
    pairs = np.concatenate([p.pairs + np.array((before[k], firsts[k])) for k, p in enumerate(parts)])
    counts = np.bincount(pairs[:, 0], minlength=before[-1])
    return CoarseLevel(
        level=level,
        scene=replace(
            scene,
            faces=np.concatenate([part.faces for part in parts]).astype(np.int32),
            face_object=np.repeat(np.arange(len(parts)), sizes).astype(np.int32),
            planes=None,  # of the finest faces alone; those of coarse ones are in no plane of the survey
        ),
        errors=np.array([part.error for part in parts]) * scene.step,
        offsets=np.concatenate(([0], np.cumsum(counts))),
        fine_faces=pairs[:, 1].astype(np.uint32),
    )
