"""What must hold for cells that are prisms, judged in fractions, on random and on built-up scenes."""

from __future__ import annotations

import dataclasses
from fractions import Fraction
from itertools import combinations

import numpy as np
from cell_prism_reference import (
    clip,
    dot,
    half_spaces,
    interiors_meet,
    is_prism,
    meets,
    meets_points,
    side_polygon,
    twice_area,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from test_cells_complex import scenes

from tilesnav_ref.cells import CellComplex, CellError, CellSettings, decompose, planes
from tilesnav_ref.cells.meeting import inflate, meets_prism
from tilesnav_ref.cells.prisms import WIDTH, holds_point, prism_corners
from tilesnav_ref.scene.model import Scene

PRISMS = CellSettings(
    min_size=1.0,
    max_size=8.0,
    clearance=0.25,
    region=(0.0, 0.0, 8.0, 8.0),
    altitude_max=8.0,
    cell_price=0.5,
    keep_interiors=True,
    coverage_points=200,
)


def house(rng: np.random.Generator, scale: int) -> np.ndarray:
    """(F, 3, 3) a turned block with a pitched roof and no bottom, on a site of 8 by 8 units."""
    middle, half = rng.uniform(2, 6, 2), rng.uniform(0.5, 2.5, 2)
    angle, height, ridge = rng.uniform(0, np.pi), rng.uniform(1, 4), rng.uniform(0, 2)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    around = middle + (np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half) @ turn.T
    ends = middle + (np.array([[-1, 0], [1, 0]]) * half) @ turn.T
    low = np.column_stack((around, np.zeros(4)))
    eaves = np.column_stack((around, np.full(4, height)))
    top = np.column_stack((ends, np.full(2, height + ridge)))
    faces = []
    for a in range(4):
        b = (a + 1) % 4
        faces += [(low[a], low[b], eaves[b]), (low[a], eaves[b], eaves[a])]
    faces += [(eaves[0], eaves[1], top[1]), (eaves[0], top[1], top[0])]
    faces += [(eaves[2], eaves[3], top[0]), (eaves[2], top[0], top[1])]
    faces += [(eaves[1], eaves[2], top[1]), (eaves[3], eaves[0], top[0])]
    return np.round(np.array(faces) * scale).astype(np.int64)


@st.composite
def towns(draw: st.DrawFn) -> Scene:
    """Ground and up to three turned houses, which may cut through each other, at a step of 1/64 m."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    scale = 64
    ground = np.array([[[0, 0, 0], [8, 0, 0], [8, 8, 0]], [[0, 0, 0], [8, 8, 0], [0, 8, 0]]]) * scale
    corners = np.concatenate([ground, *(house(rng, scale) for _ in range(draw(st.integers(0, 3))))])
    edges = corners[:, 1:] - corners[:, :1]
    corners = corners[np.any(np.cross(edges[:, 0], edges[:, 1]) != 0, axis=1)]
    faces = np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
    return Scene(
        corners.reshape(-1, 3), faces, np.zeros(len(faces), np.int32), np.zeros(1, np.int32), ("",), -6
    )


any_scene = st.one_of(scenes(), towns())


def run(scene: Scene, **change: object) -> CellComplex | None:
    """Cells, or None where there is no free space."""
    try:
        return decompose(scene, dataclasses.replace(PRISMS, **change))
    except CellError as error:
        if "no free space" not in str(error):
            raise
        return None


def test_sloping_walls_give_slanted_sides() -> None:
    """The scenes below would test boxes alone if none did."""
    cells = [run(towns_of(seed)) for seed in range(3)]
    slanted = [one for one in cells if one is not None and np.any(is_slanted(one))]
    assert slanted


def towns_of(seed: int) -> Scene:
    """One house on the ground."""
    corners = house(np.random.default_rng(seed), 64)
    faces = np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
    return Scene(
        corners.reshape(-1, 3), faces, np.zeros(len(faces), np.int32), np.zeros(1, np.int32), ("",), -6
    )


def is_slanted(cells: CellComplex) -> np.ndarray:
    """(N,) which cells are no boxes."""
    on_bounds = (cells.corners == cells.lower[:, None]) | (cells.corners == cells.upper[:, None])
    return ~on_bounds.all(axis=(1, 2))


@given(any_scene, st.sampled_from([0.0, 0.25]))
@settings(max_examples=60, deadline=None)
def test_cells_are_prisms_clear_of_faces_and_inside_the_domain(scene: Scene, clearance: float) -> None:
    cells = run(scene, clearance=clearance)
    if cells is None:
        return
    unit = round(1 / scene.step)
    least = unit * PRISMS.min_size
    for corners in cells.corners:
        assert is_prism(corners)
        spaces = half_spaces(corners, cells.clearance)
        assert not any(meets(triangle, spaces) for triangle in scene.corners())
        assert np.all(np.ptp(corners, axis=0) >= least)
        for axis in range(3):
            for upper in range(2):
                square = twice_area(side_polygon(corners, axis, upper), axis) ** 2 / 4
                assert square > 1, "the facet is larger than a square grid step"
    assert np.all(cells.corners >= 0)
    assert np.all(cells.corners <= 8 * unit)
    assert np.array_equal(cells.corners.min(axis=1), cells.lower)
    assert np.array_equal(cells.corners.max(axis=1), cells.upper)


@given(any_scene)
@settings(max_examples=40, deadline=None)
def test_interiors_are_disjoint(scene: Scene) -> None:
    cells = run(scene)
    if cells is None:
        return
    for i, j in combinations(range(cells.count), 2):
        if np.all((cells.lower[i] < cells.upper[j]) & (cells.lower[j] < cells.upper[i])):
            assert not interiors_meet(cells.corners[i], cells.corners[j])


@given(any_scene)
@settings(max_examples=40, deadline=None)
def test_planes_bound_a_cell_inside_the_one_on_the_grid(scene: Scene) -> None:
    cells = run(scene)
    if cells is None:
        return
    table, step = planes(cells, scene.step), Fraction(scene.step)
    assert np.all(np.abs(np.sqrt((table[..., :3] ** 2).sum(axis=2)) - 1) < 2.0**-40)
    for corners, six in zip(cells.corners, table, strict=True):
        middle = [Fraction(int(value), 8) * step for value in corners.sum(axis=0)]
        for number, (*normal, d) in enumerate(six.tolist()):
            axis, upper = divmod(number, 2)
            heights = [
                sum(Fraction(n) * int(x) * step for n, x in zip(normal, corners[c], strict=True))
                + Fraction(d)
                for c in range(8)
            ]
            on_side = [heights[c] for c in range(8) if c >> axis & 1 == upper]
            assert min(on_side) >= 0
            assert max(on_side) < Fraction(1, 2**30)
            if np.ptp(corners[[c for c in range(8) if c >> axis & 1 == upper], axis]) == 0:
                assert max(on_side) == 0, "a plane normal to an axis is exact"
            assert sum(Fraction(n) * x for n, x in zip(normal, middle, strict=True)) + Fraction(d) < 0


def portals_of(cells: CellComplex) -> dict[tuple[int, int], int]:
    sources = np.repeat(np.arange(cells.count), np.diff(cells.portal_offsets))
    found: dict[tuple[int, int], int] = {}
    for s, t, p in zip(sources, cells.portal_targets, cells.portal_polygons, strict=True):
        assert (int(s), int(t)) not in found
        found[int(s), int(t)] = int(p)
    return found


def contact(one: np.ndarray, other: np.ndarray) -> tuple[int, list[tuple[Fraction, ...]]] | None:
    """Axis and polygon in which the upper side of a cell touches the lower side of another, if they do."""
    for axis in range(3):
        upper, lower = side_polygon(one, axis, 1), side_polygon(other, axis, 0)
        if len({p[axis] for p in upper + lower}) > 1:
            continue
        for number, space in enumerate(half_spaces(other)):
            if number // 2 != axis:
                upper = clip(upper, space) if upper else []
        if upper and twice_area(upper, axis) > 0:
            return axis, upper
    return None


@given(any_scene, st.sampled_from([0.0, 0.25]))
@settings(max_examples=40, deadline=None)
def test_portals_are_the_contacts_of_flat_sides(scene: Scene, clearance: float) -> None:
    cells = run(scene, clearance=clearance)
    if cells is None:
        return
    found = portals_of(cells)
    assert all(found[j, i] == polygon for (i, j), polygon in found.items())
    seen = 0
    for i in range(cells.count):
        for j in range(cells.count):
            touch = contact(cells.corners[i], cells.corners[j]) if i != j else None
            if touch is None:
                continue
            axis, expected = touch
            if (i, j) not in found:
                assert twice_area(expected, axis) <= 2 or clearance == 0 or _thin(expected)
                continue
            seen += 1
            polygon = cells.polygon_vertices[slice(*cells.polygon_offsets[found[i, j] :][:2])]
            assert 3 <= len(polygon) <= 8
            for vertex in polygon.tolist():
                assert min(_distance(vertex, p) for p in expected) < 1e-3
            for point in expected:
                assert min(_distance(vertex, point) for vertex in polygon.tolist()) < 0.3
            if clearance == 0:
                flat = [tuple(Fraction(x) for x in vertex) for vertex in polygon.tolist()]
                assert not any(_meets_polygon(t, flat, axis) for t in scene.corners())
    assert seen * 2 == len(found)


def _thin(polygon: list[tuple[Fraction, ...]]) -> bool:
    extents = sorted(float(max(p[k] for p in polygon) - min(p[k] for p in polygon)) for k in range(3))
    return extents[1] < 2.0


def _distance(one: object, other: object) -> float:
    return max(abs(float(a) - float(b)) for a, b in zip(list(one), list(other), strict=True))  # type: ignore[call-overload]


def _meets_polygon(triangle: np.ndarray, polygon: list[tuple[Fraction, ...]], axis: int) -> bool:
    """Whether a triangle meets the inside of a polygon, shrunk about its mean by a thousandth."""
    mean = tuple(sum((p[k] for p in polygon), Fraction(0)) / len(polygon) for k in range(3))
    plane = int(mean[axis])
    part = [tuple(Fraction(int(x)) for x in corner) for corner in triangle]
    for sign in (1, -1):
        normal = tuple(sign if k == axis else 0 for k in range(3))
        part = clip(part, (normal, Fraction(sign * plane))) if part else []
    if not part:
        return False
    i, j = (axis + 1) % 3, (axis + 2) % 3
    spaces = []
    for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        normal = [Fraction(0)] * 3
        normal[i], normal[j] = b[j] - a[j], a[i] - b[i]
        bound = sum(n * x for n, x in zip(normal, a, strict=True))
        depth = bound - sum(n * x for n, x in zip(normal, mean, strict=True))
        spaces.append((tuple(normal), bound - depth / 1000))
    return meets_points(part, spaces)  # type: ignore[arg-type]


@given(towns(), st.tuples(*[st.integers(-10_000, 10_000)] * 3))
@settings(max_examples=20, deadline=None)
def test_cells_move_with_the_scene(scene: Scene, shift: tuple[int, int, int]) -> None:
    """Guesses are made in floating point, in which moved scenes round otherwise by less than a step."""
    move = np.array(shift)
    moved = dataclasses.replace(scene, vertices=scene.vertices + move)
    x, y = shift[0] * scene.step, shift[1] * scene.step
    cells, other = run(scene), run(moved, region=(x, y, x + 8, y + 8))
    if cells is None or other is None:
        assert cells is other
        return
    assert cells.count == other.count
    assert np.array_equal(cells.corners + move, other.corners)
    assert np.array_equal(cells.portal_targets, other.portal_targets)


@given(towns())
@settings(max_examples=20, deadline=None)
def test_a_turned_scene_is_covered_as_well(scene: Scene) -> None:
    """A quarter turn about z changes which cut comes first, not how much is free."""
    turned = np.column_stack((8 * 64 - scene.vertices[:, 1], scene.vertices[:, 0], scene.vertices[:, 2]))
    cells, other = run(scene), run(dataclasses.replace(scene, vertices=turned))
    assert cells is not None
    assert other is not None
    assert abs(cells.coverage - other.coverage) < 0.15


@given(towns(), st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_one_more_house_only_takes_volume_away(scene: Scene, seed: int) -> None:
    """Cells of the fuller scene are free space of the emptier one."""
    extra = house(np.random.default_rng(seed), 64)
    corners = np.concatenate((scene.corners(), extra))
    faces = np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
    fuller = dataclasses.replace(
        scene, vertices=corners.reshape(-1, 3), faces=faces, face_object=np.zeros(len(faces), np.int32)
    )
    cells = run(fuller)
    for cell in cells.corners if cells is not None else []:
        spaces = half_spaces(cell, cells.clearance)
        assert not any(meets(triangle, spaces) for triangle in scene.corners())


def test_same_cells_whatever_the_number_of_threads() -> None:
    scene = towns_of(1)
    first, *others = (run(scene, max_size=2.0, threads=count) for count in (1, 4, 4))
    assert first is not None
    for other in others:
        for field in dataclasses.fields(CellComplex):
            assert np.array_equal(getattr(first, field.name), getattr(other, field.name)), field.name


@st.composite
def rows(draw: st.DrawFn) -> np.ndarray:
    """A prism over a trapezoid, small or as large as the grid."""
    small = draw(st.booleans())
    limit = 6 if small else 2**23 - 1
    axes = draw(st.permutations(range(3)))
    numbers = st.integers(-limit, limit)

    def interval() -> list[int]:
        return sorted(draw(st.lists(numbers, min_size=2, max_size=2, unique=True)))

    (u0, u1), (w0, w1), (l0, h0), (l1, h1) = interval(), interval(), interval(), interval()
    return np.array([*axes, u0, u1, w0, w1, l0, l1, h0, h1], dtype=np.int64)


@given(rows(), st.data())
@settings(max_examples=300, deadline=None)
def test_prism_test_is_exact(row: np.ndarray, data: st.DataObject) -> None:
    corners = prism_corners(row[None])[0]
    low, high = corners.min(axis=0) - 2, corners.max(axis=0) + 2
    triangle = np.array(
        [[data.draw(st.integers(int(low[k]), int(high[k]))) for k in range(3)] for _ in range(3)], np.int64
    )
    room = np.empty((11, 3), np.int64), np.empty(3, np.int64)
    assert meets_prism(triangle, row, room) == meets(triangle, half_spaces(corners))


@given(rows(), st.data())
@settings(max_examples=200, deadline=None)
def test_a_point_is_in_a_prism_by_its_half_spaces(row: np.ndarray, data: st.DataObject) -> None:
    corners = prism_corners(row[None])[0]
    low, high = corners.min(axis=0) - 1, corners.max(axis=0) + 1
    point = np.array([data.draw(st.integers(int(low[k]), int(high[k]))) for k in range(3)], np.int64)
    expected = all(dot(normal, point) <= bound for normal, bound in half_spaces(corners))
    assert holds_point(row, point) == expected


@given(rows(), st.integers(0, 40))
@settings(max_examples=200, deadline=None)
def test_an_inflated_prism_holds_the_moved_planes_and_little_more(row: np.ndarray, clearance: int) -> None:
    """Corners of the polyhedron of moved planes, in floating point, lie in the inflated prism and near its
    corners."""
    run_ = row[4] - row[3]
    if abs(row[8] - row[7]) > 2 * run_ or abs(row[10] - row[9]) > 2 * run_:
        return
    inflated = np.empty(WIDTH, np.int64)
    inflate(row, clearance, inflated)
    assert inflated[3:7].tolist() == (row[3:7] + np.array([-1, 1, -1, 1]) * clearance).tolist()
    for near, sign in ((7, -1), (9, 1)):
        slope = (row[near + 1] - row[near]) / run_
        move = sign * clearance * np.sqrt(1 + slope * slope)
        for end, along in ((0, -clearance), (1, clearance)):
            exact = row[near + end] + slope * along + move
            beyond = sign * (inflated[near + end] - exact)
            assert -1e-6 <= beyond <= (1 + 3 / run_ if slope else 1e-6)
