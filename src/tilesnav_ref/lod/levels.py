"""Level codes of the visible objects of every cell."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.kernels import kernel
from tilesnav_ref.lod.codes import check_settings, count_thresholds, thresholds
from tilesnav_ref.lod.maximum import prism_maximum
from tilesnav_ref.lod.model import LodSettings, LodTable
from tilesnav_ref.lod.prism import Vector, describe_prism
from tilesnav_ref.lod.screen import cheap_bounds, paired_bound
from tilesnav_ref.processors import thread_count
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.visibility.model import PvsTable

Progress = Callable[[int, int], None]
_GROUPS_A_TASK = 4096


@kernel
def _object_code(
    prism: Vector,
    triangles: Vector,
    normals: Vector,
    faces: NDArray[np.uint32],
    limits: Vector,
) -> int:
    """Code of the largest proven bound over some faces; faces that cannot make it finer are skipped."""
    uppers, work = np.empty(len(faces)), np.empty((3, 3))
    least, first = 0.0, 0
    for i in range(len(faces)):
        low, uppers[i] = cheap_bounds(prism, triangles[faces[i]], normals[faces[i]], work)
        least = max(least, low)
        if uppers[i] > uppers[first]:
            first = i
    # least is reached (if rounding enlarges it, that errs towards a finer code), so the true code is not
    # above this one; a face whose bound has this code or a larger one cannot change it
    code = count_thresholds(least, limits)
    for i in range(-1, len(faces)):
        j = first if i < 0 else i
        if i == first or count_thresholds(uppers[j], limits) >= code:
            continue
        bound = min(uppers[j], paired_bound(prism, triangles[faces[j]], normals[faces[j]], work))
        if count_thresholds(bound, limits) < code:
            bound = min(bound, prism_maximum(prism, triangles[faces[j]]))
            code = min(code, count_thresholds(bound, limits))
    return int(code)


@kernel
def _code_groups(
    cells: tuple[NDArray[np.int64], float],
    mesh: tuple[Vector, Vector],
    groups: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.uint32]],
    limits: Vector,
    codes: NDArray[np.uint8],
    span: tuple[int, int],
) -> None:
    """Codes of the groups span[0] to span[1]: group g has the faces members[starts[g]:starts[g + 1]]."""
    corners, step = cells
    cell_of, starts, members = groups
    prism = describe_prism(corners[cell_of[span[0]]], step)
    for g in range(span[0], span[1]):
        if g > span[0] and cell_of[g] != cell_of[g - 1]:
            prism = describe_prism(corners[cell_of[g]], step)
        faces = members[starts[g] : starts[g + 1]]
        codes[g] = _object_code(prism, mesh[0], mesh[1], faces, limits)


def _group_faces(
    scene: Scene, cells: CellComplex, pvs: PvsTable
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.uint32]]:
    """Cell (Q,), first face (Q + 1,) and object (Q,) of every pair of a cell and an object in its PVS."""
    if len(pvs.pvs_offsets) != cells.count + 1:
        raise ValueError(
            f"the PVS table has {len(pvs.pvs_offsets) - 1} cells; "
            f"allowed: as many as there are, {cells.count}"
        )
    if len(pvs.pvs_faces) and int(pvs.pvs_faces.max()) >= scene.face_count:
        raise ValueError(
            f"the PVS table lists face {int(pvs.pvs_faces.max())}; allowed: less than {scene.face_count}"
        )
    cell_of = np.repeat(np.arange(cells.count, dtype=np.int64), np.diff(pvs.pvs_offsets))
    object_of = scene.face_object[pvs.pvs_faces].astype(np.int64)
    change = np.ones(len(cell_of), np.bool_)
    change[1:] = (np.diff(cell_of) != 0) | (np.diff(object_of) != 0)
    starts = np.flatnonzero(change)
    ends = np.append(starts, len(cell_of)).astype(np.int64)
    return cell_of[starts], ends, object_of[starts].astype(np.uint32)


def _in_metres(grid: NDArray[np.int64], step: float) -> NDArray[np.float64]:
    """Grid coordinates times the step, which is a power of two: exact."""
    return np.asarray(grid * step, dtype=np.float64)


def _mesh_in_metres(scene: Scene) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners (F, 3, 3), m, and unit normals (F, 3); the products behind the normals are exact."""
    corners = scene.corners()
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).astype(np.float64)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    units: NDArray[np.float64] = np.zeros_like(normals)
    np.divide(normals, lengths, out=units, where=lengths > 0)
    return _in_metres(corners, scene.step), units


def choose_levels(
    scene: Scene,
    cells: CellComplex,
    pvs: PvsTable,
    settings: LodSettings | None = None,
    progress: Progress | None = None,
    threads: int = 0,
) -> LodTable:
    """Level code of every object in the PVS of every cell.

    Parameters
    ----------
    scene, cells, pvs
        Faces and objects, cells, and the faces of every cell; nav frame, grid.
    settings
        Scale of the codes; None: the defaults.
    progress
        Called with the number of finished and of all tasks.
    threads
        0: one for each usable processor. Codes do not depend on it.

    Returns
    -------
    LodTable
        The code of an upper bound of L over the closed cell and the object's faces in its PVS: never
        coarser than the code of the true maximum, and finer only where that is within a relative 1e-6 of a
        threshold.

    Raises
    ------
    ValueError
        Settings out of range, or tables that do not belong together.
    """
    settings = settings or LodSettings()
    check_settings(settings)
    cell_of, starts, objects = _group_faces(scene, cells, pvs)
    codes = np.empty(len(objects), np.uint8)
    prisms = (np.ascontiguousarray(cells.corners), scene.step)
    mesh, limits = _mesh_in_metres(scene), thresholds(settings)
    groups = (cell_of, starts, np.ascontiguousarray(pvs.pvs_faces))
    spans = [(g, min(g + _GROUPS_A_TASK, len(codes))) for g in range(0, len(codes), _GROUPS_A_TASK)]
    with ThreadPoolExecutor(thread_count(threads)) as pool:
        tasks = pool.map(lambda span: _code_groups(prisms, mesh, groups, limits, codes, span), spans)
        for done, _ in enumerate(tasks, start=1):
            if progress is not None:
                progress(done, len(spans))
    degrees = np.bincount(cell_of, minlength=cells.count)
    offsets = np.concatenate((np.zeros(1, np.int64), np.cumsum(degrees, dtype=np.int64)))
    return LodTable(settings=settings, lod_offsets=offsets, lod_objects=objects, lod_codes=codes)
