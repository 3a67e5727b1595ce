"""Portals: numbers, symmetry, and their polygons against the facets of the cells."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator import broadphase, clipping, polygons, polyhedra, ragged
from tilesnav_validator.checks import check
from tilesnav_validator.checks.cells import FACES, NO_CELL
from tilesnav_validator.checks.container import WHOLE
from tilesnav_validator.findings import Finding, Findings
from tilesnav_validator.subject import Subject

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

CONTACT_IN_STEPS = 2.0**-20
"""A face this near to a portal touches it. A float64 plane is off by 2^-39 m at most; where planes are
parallel to the axes and on the grid, which they are wherever contact happens on purpose, everything here is
exact."""


@check("portal/target-exists", needs=WHOLE)
def target_exists(subject: Subject) -> Iterator[Finding]:
    """Targets and polygons are numbers of things that exist."""
    tables = subject.tables
    sources, targets = tables.portal_sources, tables.targets.values.astype(np.int64)
    out = (targets >= tables.cell_count) | (targets == sources)
    for index in np.flatnonzero(out):
        allowed = f"another cell, less than {tables.cell_count}"
        yield Finding(f"cell {sources[index]} portal {index}", f"target {targets[index]}", allowed)
    for index in ragged.not_ascending(tables.targets.values, tables.targets.offsets):
        if not out[index] and not out[index - 1]:
            measured = f"target {targets[index]} after {targets[index - 1]}"
            yield Finding(f"cell {sources[index]} portal {index}", measured, "ascending, each once")
    low, high = tables.polygon_range.T
    for index in np.flatnonzero((tables.polygons < low) | (tables.polygons >= high)):
        measured = f"polygon {tables.polygons[index] - low[index]}"
        yield Finding(
            f"cell {sources[index]} portal {index}", measured, f"less than {high[index] - low[index]}"
        )


@check("portal/symmetric", needs=("portal/target-exists",))
def symmetric(subject: Subject) -> Iterator[Finding]:
    """Every portal has one that leads back, with the same polygon."""
    tables = subject.tables
    sources, targets = tables.portal_sources, tables.targets.values.astype(np.int64)
    if not len(sources):
        return
    keys, back = sources * tables.cell_count + targets, targets * tables.cell_count + sources
    place = np.minimum(np.searchsorted(keys, back), len(keys) - 1)  # ascending, since targets are
    found = keys[place] == back
    for index in np.flatnonzero(~found):
        where = f"cell {sources[index]} portal {index}"
        yield Finding(where, f"no portal from {targets[index]} back", "a portal back")
    same = tables.polygons == tables.polygons[place]
    for index in np.flatnonzero(found & ~same & (sources < targets)):
        other = place[index]
        crosses = tables.polygon_range[index, 0] != tables.polygon_range[other, 0]
        one, two = (tables.vertices.row(tables.polygons[portal]) for portal in (index, other))
        if not (crosses and np.array_equal(one, two)):
            where = f"cell {sources[index]} portal {index} to cell {targets[index]}"
            yield Finding(where, f"another polygon than that of portal {other}", "the same polygon")


@dataclass(frozen=True)
class Passage:
    """k portals between sound cells whose polygons have the same number q of corners, each pair of cells
    once.

    Attributes
    ----------
    first, second : ndarray of int64, shape (k,)
        Cells.
    corners : ndarray of float64, shape (k, q, 3)
    side_first, side_second : ndarray of int64, shape (k,)
        Planes of the cells that the polygon lies on best.
    """

    first: IntArray
    second: IntArray
    corners: FloatArray
    side_first: IntArray
    side_second: IntArray


def _passages(subject: Subject) -> Iterator[Passage]:
    """Portals of sound cells, by number of corners."""
    tables, sound = subject.tables, subject.sound_cells
    sources, targets = tables.portal_sources, tables.targets.values.astype(np.int64)
    chosen = np.flatnonzero((sources < targets) & sound[sources] & sound[np.minimum(targets, len(sound) - 1)])
    polygon = tables.polygons[chosen]
    sizes = tables.vertices.offsets[polygon + 1] - tables.vertices.offsets[polygon]
    for size in np.unique(sizes):
        portals, start = chosen[sizes == size], tables.vertices.offsets[polygon[sizes == size]]
        corners = tables.vertices.values[start[:, None] + np.arange(size)]
        first, second = sources[portals], targets[portals]
        sides = [
            _off(corners, tables.planes[cells]).argmin(axis=1) if size else np.zeros(len(cells), np.int64)
            for cells in (first, second)
        ]
        yield Passage(first, second, corners, sides[0], sides[1])


def _off(corners: FloatArray, planes: FloatArray) -> FloatArray:
    """Largest distance of the corners of each polygon to each plane, shape (k, 6); infinite for NaN."""
    height = np.abs(np.einsum("kqi,kpi->kpq", corners, planes[..., :3]) + planes[..., 3:])
    return np.asarray(np.nan_to_num(height, nan=np.inf).max(axis=2))


@check("portal/shared-polygon", needs=("portal/symmetric", "cell/unit-normals"))
def shared_polygon(subject: Subject) -> Findings:
    """The polygon is the intersection of two facets, both ways."""
    for passage in _passages(subject):
        if passage.corners.shape[1] < 3:
            for first, second in zip(passage.first, passage.second, strict=True):
                where = f"portal of cells {first} and {second}"
                yield Finding(where, f"{passage.corners.shape[1]} vertices", "at least 3")
            continue
        faults = _polygon_faults(subject, passage)
        for index in np.flatnonzero(np.any([bad for bad, _, _ in faults], axis=0)):
            values, allowed = next((values, allowed) for bad, values, allowed in faults if bad[index])
            where = f"portal of cells {passage.first[index]} and {passage.second[index]}"
            yield Finding(where, f"{values[0]} {values[1][index]:.6g}", allowed)
    return None if subject.sound_cells.any() else NO_CELL


_Fault = tuple[NDArray[np.bool_], tuple[str, FloatArray], str]


def _polygon_faults(subject: Subject, passage: Passage) -> list[_Fault]:
    """What can be wrong with polygons, the most telling first: which are, what was measured, what is
    allowed."""
    step, tolerance = subject.step, subject.tolerance
    both = [subject.tables.planes[cells] for cells in (passage.first, passage.second)]
    rows = np.arange(len(passage.first))
    off = np.maximum(
        _off(passage.corners, both[0])[rows, passage.side_first],
        _off(passage.corners, both[1])[rows, passage.side_second],
    )
    height = np.concatenate(
        [np.einsum("kqi,kpi->kqp", passage.corners, p[..., :3]) + p[:, None, :, 3] for p in both], axis=2
    ).max(axis=(1, 2))
    normals = both[0][rows, passage.side_first, :3]
    convex = polygons.turns_once(passage.corners, normals, tolerance)
    area = polyhedra.polygon_area(passage.corners)
    missing = _missing(subject, passage, normals)
    reach = step + tolerance
    return [
        (~(off <= reach), ("vertices off the common plane by metres", off), f"at most {step:g} m"),
        (~(height <= reach), ("vertices outside a cell by metres", height), f"at most {step:g} m"),
        (~convex, ("not convex, or vertices out of order; area in m2", area), "convex, in order"),
        (~(area > step**2), ("area in m2", area), f"more than {step**2:.3g} m2"),
        (
            ~(missing <= reach),
            ("the common part of the facets goes beyond it by metres", missing),
            f"at most {step:g} m",
        ),
    ]


def _missing(subject: Subject, passage: Passage, normals: FloatArray) -> FloatArray:
    """How far the intersection of the two facets reaches out of the stored polygon; infinite if there is
    none."""
    planes = subject.tables.planes
    corners = subject.polyhedra.facet(passage.first, passage.side_first)
    count = np.full(len(corners), corners.shape[1], dtype=np.int64)
    for turn in range(1, 6):
        side = (passage.side_second + turn) % 6
        corners, count = clipping.clip(corners, count, planes[passage.second, side])
    away = polygons.distance(corners, passage.corners, normals)
    away = np.where(np.arange(corners.shape[1]) < count[:, None], away, 0.0)
    return np.where(count > 0, away.max(axis=1), np.inf)


@check("portal/clear-of-geometry", needs=("portal/shared-polygon", *FACES))
def clear_of_geometry(subject: Subject) -> Findings:
    """No face meets the inside of a polygon."""
    points = subject.faces.points
    low, high = points.min(axis=1), points.max(axis=1)
    for passage in _passages(subject):
        corners = passage.corners
        for i, j in broadphase.overlaps(corners.min(axis=1), corners.max(axis=1), low, high):
            planes = _around_polygon(subject, passage, i)
            for index in np.flatnonzero(clipping.meets(points[j], planes)):
                where = f"portal of cells {passage.first[i[index]]} and {passage.second[i[index]]}"
                yield Finding(where, f"face {j[index]} meets it", "no face")
    return None if subject.sound_cells.any() else NO_CELL


def _around_polygon(subject: Subject, passage: Passage, chosen: IntArray) -> FloatArray:
    """Half-spaces around the relative interior of polygons: both sides of their planes, and their edges
    moved in."""
    plane = subject.tables.planes[passage.first[chosen], passage.side_first[chosen]]
    contact = subject.step * CONTACT_IN_STEPS
    sides = np.stack([plane, -plane], axis=1)
    sides[..., 3] -= contact
    edges = polygons.edge_planes(passage.corners[chosen], plane[:, :3])
    edges[..., 3] += np.where(edges[..., :3].any(axis=2), subject.tolerance, 0.0)
    return np.concatenate([sides, edges], axis=1)
