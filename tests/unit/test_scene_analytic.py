"""The stated visibility of the analytic scenes against an exact judge that shares nothing with them."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest

from tilesnav_ref.scene import SceneSettings
from tilesnav_ref.scene.analytic import SCENES, AnalyticScene
from tilesnav_ref.scene.analytic.case import Answer, Drawing, on_grid
from tilesnav_ref.scene.noding import count_junctions

CELL_PARTS = 64
FACE_PARTS = 60
SCALE = CELL_PARTS * FACE_PARTS  # makes every sample point an integer point
HIDDEN_SAMPLES = 1500
VISIBLE_TRIES = 4000

Vector = tuple[int, int, int]


def _sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def blocks(triangle, start, end) -> bool:
    """Whether the segment from start to end, without its end, meets the closed triangle; exact for exact
    numbers."""
    normal = _cross(_sub(triangle[1], triangle[0]), _sub(triangle[2], triangle[0]))
    at_start = _dot(normal, _sub(start, triangle[0]))
    at_end = _dot(normal, _sub(end, triangle[0]))
    sides = [
        (_dot(_cross(normal, _sub(triangle[(i + 1) % 3], triangle[i])), _sub(p, triangle[i])))
        for i in range(3)
        for p in (start, end)
    ]
    if at_start == 0 and at_end == 0:
        low, high = Fraction(0), Fraction(1)
        for first, last in zip(sides[::2], sides[1::2], strict=True):
            if first == last:
                if first < 0:
                    return False
            elif first < last:
                low = max(low, Fraction(-first) / (last - first))
            else:
                high = min(high, Fraction(-first) / (last - first))
        return low <= high and low < 1
    if at_end == 0 or ((at_start > 0) == (at_end > 0) and at_start != 0):
        return False
    weight = at_start - at_end  # the point of the plane is (start * -at_end + end * at_start) / weight
    sign = 1 if weight > 0 else -1
    return all(
        sign * (at_start * last - at_end * first) >= 0
        for first, last in zip(sides[::2], sides[1::2], strict=True)
    )


class Judge:
    """Random exact segments from a cell to a face."""

    def __init__(self, case: AnalyticScene) -> None:
        self.case = case
        self.random = random.Random(7)
        self.triangles = [tuple(tuple(SCALE * int(x) for x in p) for p in t) for t in case.scene.corners()]
        self.order = list(range(len(self.triangles)))

    def free(self, start, end, target: int) -> bool:
        """Whether no face but the target blocks; the last face that blocked is tried first."""
        for position, face in enumerate(self.order):
            if face != target and blocks(self.triangles[face], start, end):
                self.order.insert(0, self.order.pop(position))
                return False
        return True

    def target_point(self, face: int):
        i = self.random.randint(1, FACE_PARTS - 2)
        j = self.random.randint(1, FACE_PARTS - 1 - i)
        weights = (i, j, FACE_PARTS - i - j)
        corners = self.triangles[face]
        return tuple(
            sum(w * p[k] for w, p in zip(weights, corners, strict=True)) // FACE_PARTS for k in range(3)
        )

    def cell_point(self) -> Vector:
        low, high = self.case.cell_lower.tolist(), self.case.cell_upper.tolist()
        parts = [self.random.randint(1, CELL_PARTS - 1) for _ in range(3)]
        x, y, z = (
            FACE_PARTS * (a * (CELL_PARTS - p) + b * p) for a, b, p in zip(low, high, parts, strict=True)
        )
        return (x, y, z)

    def aimed_point(self, end):
        """A point of the open cell on the line from the target through the opening, or None."""
        assert self.case.opening is not None
        through = [SCALE * x for x in self.case.opening]
        factor = Fraction(self.random.randint(101, 400), 100)
        start = tuple(e + factor * (o - e) for e, o in zip(end, through, strict=True))
        low, high = self.case.cell_lower.tolist(), self.case.cell_upper.tolist()
        inside = all(SCALE * a < x < SCALE * b for a, x, b in zip(low, start, high, strict=True))
        return start if inside else None

    def sees(self, face: int, tries: int) -> bool:
        """Whether one of a number of random segments reaches the face."""
        for n in range(tries):
            end = self.target_point(face)
            start = self.aimed_point(end) if self.case.opening is not None and n % 2 else self.cell_point()
            if start is not None and self.free(start, end, face):
                return True
        return False


@pytest.mark.parametrize("name", sorted(SCENES))
def test_stated_visibility_is_what_exact_segments_find(name: str) -> None:
    case = SCENES[name]()
    judge = Judge(case)
    unseen = [face for face in sorted(case.visible) if not judge.sees(face, VISIBLE_TRIES)]
    seen = [face for face in sorted(case.hidden) if judge.sees(face, HIDDEN_SAMPLES)]
    assert (unseen, seen) == ([], [])


@pytest.mark.parametrize("name", sorted(SCENES))
def test_scene_is_sound(name: str) -> None:
    case = SCENES[name]()
    scene = case.scene
    assert case.name == name
    assert case.visible
    assert not case.visible & case.hidden
    assert max(case.visible | case.hidden) < scene.face_count
    assert (case.cell_lower < case.cell_upper).all()
    assert count_junctions(scene.vertices, scene.faces.astype(np.int64)) == 0


def test_every_scene_but_one_has_a_hidden_face() -> None:
    assert [name for name, make in SCENES.items() if not make().hidden] == ["edge_on"]


def test_judge_finds_a_gap_that_is_made_into_the_wall() -> None:
    """The judge can fail: the wall moved aside by 1.5 m leaves the target to be seen."""
    drawing = Drawing("moved", (-1, -1, -1), (1, 1, 1))
    drawing.wall_y("wall", 10, (0.5, 20))
    drawing.triangle("behind", (-1, 12, -1), (1, 12, -1), (0, 12, 1))
    case = drawing.finish(Answer("wall", "behind", "wrong"))
    assert Judge(case).sees(min(case.hidden), HIDDEN_SAMPLES)


@pytest.mark.parametrize(
    ("start", "end", "expected"),
    [
        ((1, 1, -1), (1, 1, 1), True),
        ((1, 1, 1), (1, 1, 0), False),  # only its end is on the triangle
        ((1, 1, 0), (1, 1, 5), True),  # its start is on the triangle
        ((0, 0, -1), (0, 0, 1), True),  # through a corner
        ((2, 0, -1), (2, 0, 1), True),  # through an edge
        ((-1, 1, -1), (-1, 1, 1), False),
        ((-1, 1, 0), (1, 1, 0), True),  # within the plane
        ((-1, 1, 0), (0, 1, 0), False),  # within the plane, up to the border
        ((-1, -1, 0), (5, -1, 0), False),
        ((1, 1, 3), (1, 1, 1), False),
    ],
)
def test_judge_of_one_segment(start: Vector, end: Vector, expected: bool) -> None:
    triangle = ((0, 0, 0), (4, 0, 0), (0, 4, 0))
    assert blocks(triangle, start, end) is expected
    assert blocks(triangle[::-1], start, end) is expected


def test_answer_with_an_unknown_name_is_refused() -> None:
    drawing = Drawing("named", (0, 0, 0), (1, 1, 1))
    drawing.triangle("a", (0, 2, 0), (1, 2, 0), (0, 2, 1))
    with pytest.raises(ValueError, match="no piece named b"):
        drawing.finish(Answer("a", "b", ""))


def test_point_off_the_grid_is_refused() -> None:
    with pytest.raises(ValueError, match="not on the grid"):
        on_grid((0.1, 0.0, 0.0))


def test_grid_of_the_drawings_is_the_default_grid() -> None:
    assert SceneSettings().step * 1024 == 1.0
