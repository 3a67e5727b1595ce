"""Cells: kinds, planes, and their geometry."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator import broadphase, clipping, polyhedra, volumes
from tilesnav_validator.checks import check
from tilesnav_validator.checks.container import WHOLE
from tilesnav_validator.findings import Finding, Findings, NotRun
from tilesnav_validator.subject import Subject
from tilesnav_validator.tiles import EXTENSION

UNIT_NORMAL = 2.0**-40
SAME_DIRECTION = 2.0**-30
"""Normals this near are those of one plane: at 2^13 m they part by half a tolerance of a 1 mm step."""

FACES = ("core/face-count", "core/on-grid")
"""What must hold before the faces of the map are used."""

NO_CELL = NotRun("no cell without an earlier finding")


@check("cell/known-kind", needs=WHOLE)
def known_kind(subject: Subject) -> Iterator[Finding]:
    """Kinds are 0 or 1."""
    for cell in np.flatnonzero(subject.tables.kinds > 1):
        yield Finding(f"cell {cell}", f"kind {subject.tables.kinds[cell]}", "0 or 1")


@check("cell/unit-normals", needs=WHOLE)
def unit_normals(subject: Subject) -> Iterator[Finding]:
    """Coefficients are finite, normals have length 1."""
    planes = subject.tables.planes
    with np.errstate(over="ignore", invalid="ignore"):
        length = np.sqrt((planes[..., :3] ** 2).sum(axis=2))
    wrong = ~np.isfinite(planes).all(axis=2) | ~(np.abs(length - 1) <= UNIT_NORMAL)
    for cell, plane in np.argwhere(wrong):
        measured = f"{planes[cell, plane].tolist()}, length of the normal {length[cell, plane]!r}"
        yield Finding(f"cell {cell} plane {plane}", measured, "finite, length 1 within 2^-40")


@check("cell/bounded", needs=("cell/unit-normals",))
def bounded(subject: Subject) -> Iterator[Finding]:
    """The normals of a cell span space in every direction."""
    for cell in np.flatnonzero(polyhedra.unbounded(subject.tables.planes)):
        subject.reject_cell(cell)
        yield Finding(f"cell {cell}", "unbounded", "bounded")


@check("cell/non-empty", needs=("cell/unit-normals",))
def non_empty(subject: Subject) -> Findings:
    """A cell holds a ball of one grid step."""
    cells = np.flatnonzero(subject.sound_cells)
    planes = subject.tables.planes[cells]
    small = cells[~polyhedra.holds_ball(planes, subject.step, subject.tolerance)]
    radius = polyhedra.largest_ball(subject.tables.planes[small], 2 * subject.step, subject.tolerance)
    for cell, found in zip(small, radius, strict=True):
        subject.reject_cell(cell)
        measured = "empty" if found <= -subject.step else f"largest ball of radius {found:.3g} m"
        yield Finding(f"cell {cell}", measured, f"at least {subject.step:g} m")
    return None if len(cells) else NO_CELL


@check("cell/no-redundant-plane", needs=("cell/unit-normals",))
def no_redundant_plane(subject: Subject) -> Findings:
    """Every plane has a facet, and no two planes have the same."""
    cells = np.repeat(np.flatnonzero(subject.sound_cells), 6)
    plane = np.tile(np.arange(6), len(cells) // 6)
    area = _facet_areas(subject, cells, plane)
    planes = subject.tables.planes[cells]
    own = np.take_along_axis(planes, plane[:, None, None], axis=1)
    turned = np.abs(planes[..., :3] - own[..., :3]).max(axis=2) <= SAME_DIRECTION
    same = turned & (np.abs(planes[..., 3] - own[..., 3]) <= subject.tolerance)
    repeats = (same & (np.arange(6) != plane[:, None])).any(axis=1)
    allowed = f"a facet of its own of more than {subject.step**2:.3g} m2"
    for index in np.flatnonzero((area <= subject.step**2) | repeats):
        subject.reject_cell(cells[index])
        measured = "the half-space of another plane" if repeats[index] else f"a facet of {area[index]:.3g} m2"
        yield Finding(f"cell {cells[index]} plane {plane[index]}", measured, allowed)
    return None if len(cells) else NO_CELL


def _facet_areas(subject: Subject, cells: NDArray[np.int64], plane: NDArray[np.int64]) -> NDArray[np.float64]:
    """Areas of facets, m2; those that the tolerance of vertices may have widened are clipped without one."""
    corners = subject.polyhedra.facet(cells, plane)
    area = polyhedra.polygon_area(corners)
    reach = np.linalg.norm(np.ptp(corners, axis=1), axis=1)
    doubtful = np.flatnonzero(area <= subject.step**2 + 8 * subject.tolerance * reach)
    cells, plane, corners = cells[doubtful], plane[doubtful], corners[doubtful]
    count = np.full(len(doubtful), corners.shape[1], dtype=np.int64)
    for turn in range(1, 6):
        corners, count = clipping.clip(corners, count, subject.tables.planes[cells, (plane + turn) % 6])
    behind = np.arange(corners.shape[1]) >= count[:, None]
    area[doubtful] = polyhedra.polygon_area(np.where(behind[..., None], corners[:, :1], corners))
    return area


@check("cell/clear-of-geometry", needs=("cell/unit-normals", *FACES))
def clear_of_geometry(subject: Subject) -> Findings:
    """No face reaches into a cell with its planes moved out by the clearance."""
    cells = np.flatnonzero(subject.sound_cells)
    clearance = float(subject.nav["clearance"])
    moved = subject.tables.planes[cells].copy()
    moved[..., 3] -= clearance
    shapes = polyhedra.build(moved, subject.tolerance)
    inner = moved.copy()
    inner[..., 3] += subject.tolerance
    points = subject.faces.points
    pairs = broadphase.overlaps(shapes.low, shapes.high, points.min(axis=1), points.max(axis=1))
    allowed = f"no point of a face, at the clearance of {clearance:g} m"
    for i, j in pairs:
        hit = clipping.meets(points[j], inner[i])
        for cell, face in zip(cells[i[hit]], j[hit], strict=True):
            subject.reject_cell(cell)
            yield Finding(f"cell {cell}", f"face {face} reaches into it", allowed)
    return None if len(cells) else NO_CELL


@check("cell/disjoint-interiors", needs=("cell/unit-normals",))
def disjoint_interiors(subject: Subject) -> Findings:
    """No two cells overlap."""
    cells = np.flatnonzero(subject.sound_cells)
    low = subject.polyhedra.low[cells] + subject.tolerance
    high = subject.polyhedra.high[cells] - subject.tolerance
    for i, j in broadphase.overlaps(low, high, low, high):
        first, second = cells[i[i < j]], cells[j[i < j]]
        for index in np.flatnonzero(_overlap(subject, first, second)):
            subject.reject_cell(second[index])
            yield Finding(f"cells {first[index]} and {second[index]}", "interiors meet", "disjoint interiors")
    return None if len(cells) else NO_CELL


def _overlap(subject: Subject, first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which pairs of cells have a common interior: first by the facets, then by the polyhedron that they
    share."""
    shapes, planes, tolerance = subject.polyhedra, subject.tables.planes, subject.tolerance
    apart = np.zeros(len(first), dtype=bool)
    for one, other in ((first, second), (second, first)):
        height = np.einsum("kti,kpi->kpt", shapes.points[one], planes[other, :, :3]) + planes[other, :, 3:]
        apart |= (height.min(axis=2) >= -tolerance).any(axis=1)
    result = ~apart
    close = np.flatnonzero(result)
    for start in range(0, len(close), 4096):  # 220 triples of 12 planes a pair: 4096 pairs are 90 MB
        part = close[start : start + 4096]
        both = np.concatenate([planes[first[part]], planes[second[part]]], axis=1)
        result[part] = polyhedra.holds_ball(both, 2 * tolerance, tolerance)
    return result


@check("cell/sector-volume-bounds", needs=("cell/unit-normals",))
def sector_volume_bounds(subject: Subject) -> Findings:
    """The vertices of the cells of a sector are in its box."""
    sound, first = subject.sound_cells, 0
    for index, sector in enumerate(subject.nav["sectors"]):
        cells = first + np.flatnonzero(sound[first : first + int(sector["cellCount"])])
        first += int(sector["cellCount"])
        box = np.array(sector["boundingVolume"]["box"], dtype=np.float64)
        points = subject.polyhedra.points[cells].reshape(-1, 3)
        excess = volumes.box_excess(box, points)
        if not excess <= subject.step + subject.tolerance:
            where = f"{subject.entry_name}#/extensions/{EXTENSION}/sectors/{index}/boundingVolume/box"
            measured = f"a cell reaches {excess:.6g} m out of it"
            yield Finding(where, measured, f"at most {subject.step:g} m")
    return None if sound.any() else NO_CELL
