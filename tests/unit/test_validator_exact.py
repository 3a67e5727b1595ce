"""Witnesses are decided in exact arithmetic: shared edges, coincident faces, rays in a plane, half-open
segments."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from validator_fixture import box_planes

from tilesnav_validator.exact import Candidate, Witness, decide, inside, make_ray, meets, pierces
from tilesnav_validator.subject import Faces

STEP = 2.0**-10
CELL = np.array(box_planes((-1, -1, -1), (1, 1, 1)))
WALL = [(4, -4, -4), (4, 4, -4), (4, 0, 4)]


def scene(*triangles: list[tuple[float, float, float]]) -> Faces:
    points = np.array(triangles, dtype=np.float64)
    grid = np.rint(points / STEP).astype(np.int64)
    return Faces(grid, points, np.zeros(len(points), np.int64))


def see(faces: Faces, face: int, c: tuple[float, ...], towards: tuple[float, ...]) -> Witness | None:
    start, end = np.array(c, dtype=np.float64), np.array(towards, dtype=np.float64)
    return decide(Candidate(0, face, start, end - start), CELL, faces, STEP)


def test_a_free_line_of_sight_is_a_witness() -> None:
    witness = see(scene(WALL), 0, (0, 0, 0), (8, 1, 0))
    assert witness == Witness(0, 0, (Fraction(0),) * 3, (Fraction(4), Fraction(1, 2), Fraction(0)))


def test_both_sides_of_a_face_are_seen() -> None:
    assert see(scene(WALL[::-1]), 0, (0, 0, 0), (4, 0, 0)) is not None


def test_a_face_between_blocks() -> None:
    front = [(2, -4, -4), (2, 4, -4), (2, 0, 4)]
    assert see(scene(WALL, front), 0, (0, 0, 0), (4, 0, 0)) is None
    behind = [(6, -4, -4), (6, 4, -4), (6, 0, 4)]
    assert see(scene(WALL, behind), 0, (0, 0, 0), (4, 0, 0)) is not None


def test_a_face_behind_the_position_does_not_block() -> None:
    assert see(scene(WALL, [(-2, -4, -4), (-2, 4, -4), (-2, 0, 4)]), 0, (0, 0, 0), (4, 0, 0)) is not None


def test_an_edge_that_is_only_touched_blocks_and_one_step_beside_it_does_not() -> None:
    def edge_at(y: float) -> list[tuple[float, float, float]]:
        return [(2, y, -2), (2, y, 2), (2, y + 2, 0)]

    assert see(scene(WALL, edge_at(0)), 0, (0, 0, 0), (4, 0, 0)) is None
    assert see(scene(WALL, edge_at(STEP)), 0, (0, 0, 0), (4, 0, 0)) is not None
    assert see(scene(WALL, edge_at(-STEP)), 0, (0, 0, 0), (4, 0, 0)) is None


def test_a_corner_that_is_only_touched_blocks() -> None:
    assert see(scene(WALL, [(2, 0, 0), (2, 1, 1), (2, 1, 2)]), 0, (0, 0, 0), (4, 0, 0)) is None


def test_a_ray_through_the_edge_of_the_face_itself_is_no_witness() -> None:
    left, right = [(4, -4, -4), (4, 0, -4), (4, 0, 4)], [(4, 0, -4), (4, 4, -4), (4, 0, 4)]
    faces = scene(left, right)
    assert see(faces, 0, (0, 0, 0), (4, 0, 0)) is None
    assert see(faces, 1, (0, 0, 0), (4, 0, 0)) is None
    assert see(faces, 0, (0, 0, 0), (4, -STEP, 0)) is not None
    assert see(faces, 1, (0, 0, 0), (4, -STEP, 0)) is None


def test_of_two_coincident_faces_each_is_seen() -> None:
    faces = scene(WALL, WALL)
    assert see(faces, 0, (0, 0, 0), (4, 0, 0)) is not None
    assert see(faces, 1, (0, 0, 0), (4, 0, 0)) is not None


def test_a_face_seen_edge_on_is_no_witness_but_blocks_in_its_plane() -> None:
    flat = [(2, -1, 0), (3, -1, 0), (2.5, 1, 0)]
    faces = scene(WALL, flat)
    assert see(faces, 1, (0, 0, 0), (4, 0, 0)) is None
    assert see(faces, 0, (0, 0, 0), (4, 0, 0)) is None
    assert see(faces, 0, (0, 0, STEP), (4, 0, STEP)) is not None
    assert see(faces, 0, (0, 0.875, 0), (4, 2, -1)) is not None


def test_a_face_in_the_plane_of_the_ray_beside_it_or_behind_its_end_does_not_block() -> None:
    beside = [(2, 1, 0), (3, 1, 0), (2.5, 2, 0)]
    behind = [(5, -1, 0), (6, -1, 0), (5.5, 1, 0)]
    assert see(scene(WALL, beside, behind), 0, (0, 0, 0), (4, 0, 0)) is not None


def test_a_face_in_the_plane_of_the_ray_that_begins_where_it_ends_does_not_block() -> None:
    begins_at_wall = [(4, 0, 0), (6, 1, 0), (6, -1, 0)]
    assert see(scene(WALL, begins_at_wall), 0, (0, 0, 0), (4, 0, 0)) is not None
    ends_at_wall = [(4, 0, 0), (2, 1, 0), (2, -1, 0)]
    assert see(scene(WALL, ends_at_wall), 0, (0, 0, 0), (4, 0, 0)) is None


def test_a_face_that_meets_the_target_at_the_point_itself_does_not_block() -> None:
    crossing = [(3, 0, -1), (5, 0, -1), (4, 0, 0)]
    assert see(scene(WALL, crossing), 0, (0, 0, 0), (4, 0, 0)) is not None


def test_a_segment_that_touches_a_corner_in_its_plane_is_blocked() -> None:
    touching = [(2, 0, 0), (3, 1, 0), (2, 1, 0)]
    assert see(scene(WALL, touching), 0, (0, 0, 0), (4, 0, 0)) is None


def test_degenerate_faces_are_neither_seen_nor_in_the_way() -> None:
    line = [(2, -1, 0), (2, 0, 0), (2, 1, 0)]
    faces = scene(WALL, line)
    assert see(faces, 0, (0, 0, 0), (4, 0, 0)) is not None
    assert see(faces, 1, (0, 0, 0), (4, 0, 0)) is None


@pytest.mark.parametrize("c", [(1, 0, 0), (0, -1, 0), (1.0000000000000002, 0, 0), (0, 0, 5)])
def test_positions_on_or_outside_the_border_of_the_cell_count_for_nothing(c: tuple[float, ...]) -> None:
    assert see(scene(WALL), 0, c, (4, 0, 0)) is None


def test_the_interior_is_open_to_the_last_bit() -> None:
    assert inside(np.array([np.nextafter(1, 0), 0, 0]), CELL)
    assert not inside(np.array([1.0, 0, 0]), CELL)


def test_a_face_behind_is_not_pierced() -> None:
    assert see(scene(WALL), 0, (0, 0, 0), (-4, 0, 0)) is None


def test_a_gap_of_one_step_between_two_walls_is_seen_through() -> None:
    low, high = [(2, -8, -4), (2, 0, -4), (2, 0, 8)], [(2, STEP, -4), (2, 8, -4), (2, STEP, 8)]
    faces = scene(WALL, low, high)
    assert see(faces, 0, (0, STEP / 2, 0), (4, STEP / 2, 0)) is not None
    assert see(faces, 0, (0, STEP, 0), (4, STEP, 0)) is None


def test_nothing_depends_on_float64_far_from_the_origin() -> None:
    far = 2.0**13 - 8
    planes = np.array(box_planes((far - 1, far - 1, far - 1), (far, far, far)))
    wall = [(far + 4, far - 4, far - 4), (far + 4, far + 4, far - 4), (far + 4, far, far + 4)]
    edge = [(far + 2, far - 0.5, far - 2), (far + 2, far - 0.5, far + 2), (far + 2, far + 2, far)]
    faces = scene(wall, edge)
    c = np.array([far - 0.5, far - 0.5, far - 0.5])
    tiny = np.nextafter(0.5, 0) - 0.5
    straight, beside = np.array([4.0, 0.0, 0.0]), np.array([4.0, tiny, 0.0])
    assert decide(Candidate(0, 0, c, straight), planes, faces, STEP) is None
    assert decide(Candidate(0, 0, c, beside), planes, faces, STEP) is not None


def test_directions_are_taken_without_rounding() -> None:
    ray = make_ray(np.array([0.1, 0.2, 0.3]), np.array([1e-20, 1.0, 3.0]), STEP)
    assert Fraction(ray.direction[0], ray.direction[1]) == Fraction(1e-20)
    assert Fraction(ray.origin[0], ray.scale) * Fraction(STEP) == Fraction(0.1)


def test_faces_beside_a_ray_in_their_plane() -> None:
    ray = make_ray(np.zeros(3), np.array([1.0, 0.0, 0.0]), 1.0)
    for y, expected in ((0, True), (1, False), (-1, True), (-2, True), (-3, False)):
        triangle = ray.triangle(np.array([(2, y, 0), (3, y, 0), (2, y + 2, 0)]))
        assert meets(ray, triangle, Fraction(9)) == expected
        assert not meets(ray, triangle, Fraction(2))


def test_pierces_and_meets_differ_on_the_border() -> None:
    ray = make_ray(np.zeros(3), np.array([1.0, 0.0, 0.0]), 1.0)
    border = ray.triangle(np.array([(2, 0, -2), (2, 0, 2), (2, 3, 0)]))
    assert pierces(ray, border) is None
    assert meets(ray, border, Fraction(3))
    assert not meets(ray, border, Fraction(2))
