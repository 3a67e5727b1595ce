"""Random small scenes, full of degeneracies, against visibility by definition in rational numbers."""

import random
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from update_reference import seen_by_definition
from visibility_reference import half_open_meets, make_flagged, make_scene, point, visible_by

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.visibility import VisibilitySettings, compute_pvs
from tilesnav_ref.visibility.geometry import FineFrame, build_geometry
from tilesnav_ref.visibility.sight import blocker, sees

small = st.integers(0, 6)
corner = st.tuples(small, small, small)
triangle = st.tuples(corner, corner, corner).filter(
    lambda t: bool(np.any(np.cross(np.subtract(t[1], t[0]), np.subtract(t[2], t[0]))))
)
soup = st.lists(triangle, min_size=2, max_size=9)
CELL = np.array([[8, 2, 2], [11, 4, 4]])  # beside the soup, so that it is always empty
SETTINGS = VisibilitySettings(rays=300, attempts=64, depth=10, leaf_segments=4, threads=1)


def random_triangles(rng, count):
    found = rng.integers(0, 7, (count, 3, 3))
    areas = np.cross(found[:, 1] - found[:, 0], found[:, 2] - found[:, 0])
    return found[np.any(areas, axis=1)].tolist()


def cells_of(boxes):
    boxes = np.asarray(boxes, np.int64).reshape(-1, 2, 3)
    none = np.zeros(0, np.int64)
    return CellComplex(
        boxes[:, 0], boxes[:, 1], np.zeros(len(boxes), np.uint8), np.zeros(len(boxes) + 1, np.int64),
        none, none, 0, 1.0,
    )  # fmt: skip


SLOPE = np.array(
    [[3 + 6 * (i >> 1 & 1) if not i & 1 else 12, 6 * (i >> 1 & 1), 2 + 2 * (i >> 2 & 1)] for i in range(8)]
)
"""A prism from x = 3 + y to x = 12, 0 < y < 6 and 2 < z < 4; the box around it holds much of the soup."""


def slope_cell():
    return replace(cells_of([[[3, 0, 2], [12, 6, 4]]]), corners=SLOPE[None])


def points_of_slope(rng):
    """A random rational point inside the prism."""
    while True:
        share = [Fraction(rng.randint(1, 31), 32) for _ in range(3)]
        y, z = 6 * share[1], 2 + 2 * share[2]
        yield point((3 + y + (9 - y) * share[0], y, z))


@given(soup, st.booleans())
@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_face_that_a_segment_from_a_prism_sees_is_listed(monkeypatch, triangles, patches):
    triangles = [t for t in triangles if all(x <= 3 + y for x, y, _ in t)]
    assume(triangles)
    monkeypatch.setattr("tilesnav_ref.visibility.certify.is_fine", lambda _: patches)
    table = compute_pvs(make_scene(triangles), slope_cell(), SETTINGS)
    listed, inside = table.faces_of(0).tolist(), points_of_slope(random.Random(7))
    assert seen_faces(triangles, inside, 24) <= set(listed)


def pvs_of(triangles, box=CELL, work=SETTINGS):
    return set(compute_pvs(make_scene(triangles), cells_of([box]), work).faces_of(0).tolist())


def points_of_box(box):
    """Random rational points inside a box, always the same."""
    rng = random.Random(7)
    while True:
        yield point(Fraction(int(lo)) + Fraction(rng.randint(1, 31), 32) * int(up - lo) for lo, up in box.T)


def seen_faces(triangles, inside, tries):
    """Faces that some of some random rational segments from points inside a cell sees, by definition."""
    rng = random.Random(8)
    corners = [[point(v) for v in t] for t in triangles]
    found = set()
    for target, own in enumerate(corners):
        for _ in range(tries):
            c = next(inside)
            w = [rng.randint(1, 20) for _ in range(3)]
            t = point(sum(v[k] * x for v, x in zip(own, w, strict=True)) / sum(w) for k in range(3))
            if all(i == target or not half_open_meets(c, t, other) for i, other in enumerate(corners)):
                found.add(target)
                break
    return found


@given(soup)
@settings(max_examples=150)
def test_a_face_that_a_segment_sees_is_listed(triangles):
    assert seen_faces(triangles, points_of_box(CELL), 12) <= pvs_of(triangles)


@given(soup)
@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_face_that_a_segment_sees_is_listed_when_occluders_are_patches(monkeypatch, triangles):
    monkeypatch.setattr("tilesnav_ref.visibility.certify.is_fine", lambda _: True)
    assert seen_faces(triangles, points_of_box(CELL), 12) <= pvs_of(triangles)


@given(soup)
@settings(max_examples=60)
def test_no_face_is_proven_visible_and_hidden_at_once(triangles):
    table = compute_pvs(make_scene(triangles), cells_of([CELL]), SETTINGS)
    assert table.proven_counts[0] <= len(table.faces_of(0))
    assert len(table.faces_of(0)) == len(set(table.faces_of(0).tolist()))


@given(soup, st.integers(0, 8))
@settings(max_examples=60)
def test_what_is_proven_visible_stays_listed_without_an_occluder(triangles, which):
    assume(which < len(triangles) and len(triangles) > 2)
    table = compute_pvs(make_scene(triangles), cells_of([CELL]), SETTINGS)
    proven = set(table.faces_of(0)[table.pvs_proven].tolist()) - {which}
    rest = [t for i, t in enumerate(triangles) if i != which]
    assert {i - (i > which) for i in proven} <= pvs_of(rest)


@given(soup)
@settings(max_examples=60)
def test_what_is_proven_from_a_part_is_listed_for_the_whole(triangles):
    part = np.array([CELL[0], [9, 3, 3]])
    table = compute_pvs(make_scene(triangles), cells_of([part]), SETTINGS)
    assert set(table.faces_of(0)[table.pvs_proven].tolist()) <= pvs_of(triangles)


@given(soup, st.tuples(st.integers(-50, 50), st.integers(-50, 50), st.integers(-50, 50)))
@settings(max_examples=30)
def test_a_move_by_grid_steps_changes_nothing(triangles, shift):
    moved = (np.array(triangles) + np.array(shift)).tolist()
    assert pvs_of(triangles) == pvs_of(moved, CELL + np.array(shift))


def test_threads_and_blocks_of_cells_share_out_the_same_work():
    rng = np.random.default_rng(3)
    scene = make_scene(random_triangles(rng, 40))
    corners = [(8 + 2 * i, 2 * j) for i in range(4) for j in range(4)]
    cells = cells_of([[[x, y, 0], [x + 2, y + 2, 4]] for x, y in corners])
    one, two = (
        compute_pvs(scene, cells, VisibilitySettings(rays=500, threads=threads, block_cells=4))
        for threads in (1, 2)
    )
    assert np.array_equal(one.pvs_faces, two.pvs_faces)
    assert np.array_equal(one.pvs_offsets, two.pvs_offsets)
    assert np.array_equal(one.pvs_proven, two.pvs_proven)


@pytest.mark.parametrize("block_cells", [1, 2, 16])
def test_a_cell_in_a_block_lists_what_is_proven_for_it_alone(block_cells):
    rng = np.random.default_rng(5)
    scene = make_scene(random_triangles(rng, 60))
    boxes = [[[8, 2 * j, 0], [10, 2 * j + 2, 4]] for j in range(8)]
    together = compute_pvs(scene, cells_of(boxes), VisibilitySettings(block_cells=block_cells, rays=400))
    for i, box in enumerate(boxes):
        alone = compute_pvs(scene, cells_of([box]), VisibilitySettings(rays=4000))
        assert set(alone.faces_of(0)[alone.pvs_proven].tolist()) <= set(together.faces_of(i).tolist())


numbers = st.sets(st.integers(0, 8))
WITHIN = replace(SETTINGS, max_range=6 * 2.0**-10)


def flagged_pvs(scene, work):
    table = compute_pvs(scene, cells_of([CELL]), work)
    return set(table.faces_of(0).tolist()), set(table.pvs_faces[table.pvs_proven].tolist())


@given(soup, numbers, numbers, st.booleans())
@settings(max_examples=150)
def test_a_face_that_a_segment_sees_by_any_definition_is_listed(triangles, porous, sided, limited):
    scene = make_flagged(triangles, porous, sided)
    work, reach = (WITHIN, Fraction(6)) if limited else (SETTINGS, None)
    listed, proven = flagged_pvs(scene, work)
    assert seen_by_definition(scene, CELL, reach, 12) <= listed
    assert proven <= listed


@given(soup, numbers, numbers)
@settings(max_examples=60)
def test_each_condition_takes_away_and_none_adds(triangles, porous, sided):
    free = flagged_pvs(make_flagged(triangles, porous), SETTINGS)
    _, sided_proven = flagged_pvs(make_flagged(triangles, porous, sided), SETTINGS)
    _, near_proven = flagged_pvs(make_flagged(triangles, porous), WITHIN)
    _, opaque_proven = flagged_pvs(make_flagged(triangles), SETTINGS)
    assert (sided_proven | near_proven | opaque_proven) <= free[0]


@given(soup, numbers, numbers, st.integers(0, 8), st.integers(0, 2**32 - 1))
@settings(max_examples=150, deadline=None)
def test_a_segment_that_proves_a_face_visible_does_so_by_definition(triangles, porous, sided, which, seed):
    scene = make_flagged(triangles, porous, sided)
    target = which % len(triangles)
    geometry = build_geometry(scene, FineFrame(np.zeros(3, np.int64), 64), 6 * 2.0**-10)
    rng = np.random.default_rng(seed)
    c = tuple(rng.integers(0, 12 * 64, 3).astype(float).tolist())
    weights = rng.multinomial(61, [1 / 3] * 3) + 1
    t = tuple((weights @ geometry.corners[target] / 64).tolist())
    fine_c, fine_t = (point(Fraction(x) / 64 for x in p) for p in (c, t))
    if sees(geometry, c, t, target):
        assert visible_by(scene, fine_c, fine_t, target, Fraction(6))
    elif visible_by(scene, fine_c, fine_t, target, Fraction(6)):
        # Contact with an edge is refused where it may be none; so is what is within a fine unit of the range.
        length = float(np.linalg.norm(np.subtract(c, t)))
        assert length > 6 * 64 - 1 or blocker(geometry, c, t, target) >= 0
