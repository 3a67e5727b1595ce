"""The conditions of the parity theorem: each is what stands between a false proof and its acceptance."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from certificate_fixture import box_triangles, complaints, one_certificate
from clipping_reference import along, box_sides, common
from hypothesis import given, settings
from hypothesis import strategies as st

from tilesnav_validator import cuttrees, parity, prisms, proofs, separation, shafts

REGION = [0, 0, 0, 4, 4, 4]
TARGET = [(20, 0, 0), (20, 4, 0), (20, 0, 4)]
Triangles = list[list[tuple[int, ...]]]


def wall(x: int, low: tuple[int, int] = (-9, -9), high: tuple[int, int] = (13, 13)) -> Triangles:
    """Two triangles of a rectangle across the line of sight."""
    a, b, c, d = (x, *low), (x, high[0], low[1]), (x, *high), (x, low[0], high[1])
    return [[a, b, c], [a, c, d]]


def judged(occluder: Triangles, region: list[int] | None = None, target: Any = TARGET) -> list[str]:
    """Complaints about a certificate of one leaf with one target, the face 0."""
    faces = list(range(1, 1 + len(occluder)))
    return complaints(one_certificate([target, *occluder], region or REGION, [0], [faces]))


def judged_box(occluder: Triangles, targets: Triangles, region: list[int] | None = None) -> list[str]:
    """Complaints about a certificate with several targets, the first faces."""
    numbers = list(range(len(targets)))
    faces = list(range(len(targets), len(targets) + len(occluder)))
    return complaints(one_certificate([*targets, *occluder], region or REGION, numbers, [faces]))


def test_a_wall_hides_what_is_behind_it() -> None:
    assert judged(wall(10)) == []
    assert judged_box(wall(10), wall(20, (0, 0), (4, 4))) == []


@pytest.mark.parametrize(("top", "said"), [(4, []), (3, ["the border edge [[10, 13, 3], [10, -9, 3]]"])])
def test_1_no_segment_meets_the_border(top: int, said: list[str]) -> None:
    assert judged(wall(10, high=(13, top))) == said
    assert judged_box(wall(10, high=(13, top)), wall(20, (0, 0), (4, 4))) == said


def test_1_an_edge_of_three_faces_is_border_and_one_of_two_is_not() -> None:
    low, high = wall(10, high=(13, 2)), wall(10, (-9, 2))
    assert judged(low + high) == []  # they share the whole edge at the height 2
    fin = [[(10, -9, 2), (10, 13, 2), (10, 13, 40)]]
    assert judged(low + high + fin) == ["the border edge [[10, 13, 2], [10, -9, 2]]"]
    split = [[(10, -9, 2), (10, 2, 2), (10, 2, 13)], [(10, 2, 2), (10, 13, 2), (10, 2, 13)]]
    corners = [[(10, -9, 2), (10, 2, 13), (10, -9, 13)], [(10, 13, 2), (10, 13, 13), (10, 2, 13)]]
    # A T-junction: the same points, other edges; no light passes, and nothing is proven.
    assert len(judged(low + split + corners)) == 1


TESTS = ("_beside", "_past_lines", "_behind_target", "_past_segments")
ONLY: dict[str, list[tuple[Any, Any, Any]]] = {
    "_beside": [
        ([[8, -4, 2], [15, 9, 3], [15, 1, 5]], [-3, 10, -5], [-1, -3, 8]),
        ([[13, -4, -1], [8, 10, 5], [18, -2, 2]], [16, -6, 5], [-1, -4, 3]),
    ],
    "_past_lines": [
        ([[20, -6, -3], [21, 3, 10], [20, 8, -6]], [15, 0, -8], [2, -7, -2]),
        ([[13, 6, 5], [14, -4, 4], [9, 6, 8]], [12, 1, -7], [13, 6, 2]),
    ],
    "_behind_target": [
        ([[9, -1, 1], [16, -1, 9], [18, 11, 10]], [17, 0, 2], [15, 5, 7]),
        ([[23, 10, 1], [12, 9, -4], [10, -1, 0]], [1, -8, -1], [16, 7, -6]),
    ],
    "_past_segments": [
        ([[20, -5, 3], [13, 3, 6], [11, -6, 2]], [8, -8, 1], [10, -4, 7]),
        ([[19, -4, 10], [16, 11, 3], [21, 7, 2]], [4, 11, -8], [7, 7, 10]),
    ],
}
"""Edges that one of the tests clears and no other does."""


def open_edges(target: Any, start: list[int], end: list[int], region: list[int] | None = None) -> int:
    box = np.array(region or REGION)
    parts = shafts.Parts(prisms.box_corners(box[None, :3], box[None, 3:]), np.array([target]))
    return len(shafts.open_edges(parts, np.zeros(1, np.int64), np.array([start]), np.array([end])))


@pytest.mark.parametrize("name", TESTS)
def test_1_each_test_clears_what_no_other_does(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert [open_edges(*edge) for edge in ONLY[name]] == [0, 0]
    monkeypatch.setattr(shafts, name, lambda _, leaf, *__: np.zeros(len(leaf), dtype=bool))
    assert [open_edges(*edge) for edge in ONLY[name]] == [1, 1]


@pytest.mark.parametrize("name", ["_past_lines", "_past_segments"])
@pytest.mark.parametrize("turned", [False, True])
def test_1_contact_does_not_spoil_a_test(name: str, turned: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    for other in TESTS:
        if other != name:
            monkeypatch.setattr(shafts, other, lambda _, leaf, *__: np.zeros(len(leaf), dtype=bool))
    target = [[20, 0, 0], [20, 4, 0], [20, 2, 40]]
    ends = [[10, 13, 22], [10, -9, 22]] if turned else [[10, -9, 22], [10, 13, 22]]
    assert open_edges(target, *ends) == 0  # the line from (0, 4) to (20, 40) is 22 high at 10
    ends[0][2] = 21
    assert open_edges(target, *ends) == 1


@pytest.mark.parametrize("turned", [False, True])
def test_1_a_line_that_is_lower_by_a_hair(turned: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    for other in TESTS[:3]:
        monkeypatch.setattr(shafts, other, lambda _, leaf, *__: np.zeros(len(leaf), dtype=bool))
    s = 2**24
    target = [[20 * s, 0, 0], [20 * s, 4 * s, 0], [20 * s, 2 * s, 40 * s]]
    for less in (0, 1):  # one unit at 2^52 units from the shaft: 2^-24 of a unit there, lost in float64
        ends = [[10 * s, -10 * s, 22 * s], [10 * s, 2**52, 22 * s - less]]
        found = open_edges(target, *(ends[::-1] if turned else ends), region=[0, 0, 0, 4 * s, 4 * s, 4 * s])
        assert found == less


@settings(max_examples=200)
@given(data=st.data(), far=st.sampled_from([1, 2**10, 2**22]), several=st.booleans())
def test_1_lines_that_pass_a_corner_closely(data: st.DataObject, far: int, several: bool) -> None:
    size = 2**28
    number = st.integers(-size, size)
    low, high = ([data.draw(number) for _ in range(3)] for _ in range(2))
    low, high = np.minimum(low, high), np.maximum(low, high) + 1
    target = np.array([[data.draw(number) for _ in range(3)] for _ in range(8 if several else 3)])
    corners = prisms.box_corners(low[None], high[None])[0]
    through = data.draw(st.sampled_from([*corners.tolist(), *target.tolist()]))
    way, off = (np.array([data.draw(st.integers(-9, 9)) for _ in range(3)]) for _ in range(2))
    start, end = through + far * way, through - 7 * far * way + off // 5
    parts = shafts.Parts(corners[None], target[None])
    found = shafts._past_segments(parts, np.zeros(1, np.int64), start[None], end[None])
    signs = {_sign(det_of(end - start, c - start, t - start)) for c, t in product(corners, target)}
    assert found[0] == (signs in ({1}, {-1}, {0, 1}, {0, -1}))


def _sign(value: int) -> int:
    return (value > 0) - (value < 0)


def det_of(*rows: Any) -> int:
    a, b, c = ([int(x) for x in row] for row in rows)
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


def test_1_equal_corners_are_no_line() -> None:
    # The lower corners of region and target agree in the view along z, so they span no line, and any edge
    # would be on both sides of it.
    target = [[0, 0, 20], [3, 0, 20], [0, 3, 20]]
    assert open_edges(target, [-5, 1, 10], [9, 1, 10]) == 1


def test_1_all_zero_is_not_one_side() -> None:
    assert open_edges(TARGET, [10, 1, 1], [10, 1, 1]) == 1  # an edge without a length is a point in the way
    assert open_edges([[20, 1, 1]] * 3, [10, -9, 1], [10, 9, 1]) == 1  # and all is in the plane of a point


@pytest.mark.parametrize("axis", range(3))
def test_2_the_occluder_keeps_off_the_region(axis: int) -> None:
    assert judged(wall(4)) == []  # contact
    assert judged(wall(10), [0, 0, 0, 10, 4, 4]) == []
    assert judged(wall(10), [0, 0, 0, 11, 4, 4])[0] == "face 1 of the occluder meets the region"
    corner = [4, 4, 4]
    corner[axis] = 3
    away = [tuple(np.add(corner, step)) for step in np.eye(3, dtype=int) * 30]
    tip = [[tuple(corner), away[0], away[1]]]
    assert "face 3 of the occluder meets the region" not in judged(wall(10) + tip)  # at the border only
    tip = [[(3, 3, 3), away[0], away[1]]]
    assert judged(wall(10) + tip) == ["face 3 of the occluder meets the region"]


def test_2_the_occluder_keeps_off_the_target() -> None:
    shell = box_triangles((8, -9, -9), (20, 13, 13))
    front = [face for face in shell if any(corner[0] == 8 for corner in face)]
    assert judged(front) == []
    assert judged(shell)[0].endswith("of the occluder meets the target")
    needle = [[(20, 1, 1), (30, 1, 1), (30, 2, 1)]]  # the tip touches the target from behind
    assert judged(front + needle) == [f"face {1 + len(front)} of the occluder meets the target"]
    needle = [[(20, 0, 1), (30, 1, 1), (30, 2, 1)]]  # at the border of the target
    assert judged(front + needle) == []
    twin = [TARGET]
    assert judged(front + twin) == [f"face {1 + len(front)} of the occluder meets the target"]


def test_2_the_occluder_keeps_off_the_box() -> None:
    targets = wall(20, (0, 0), (4, 4))
    needle = [[(20, 4, 4), (30, 9, 9), (30, 9, 10)]]
    assert judged_box(wall(10) + needle, targets) == ["face 4 of the occluder meets the target"]
    needle = [[(21, 4, 4), (30, 9, 9), (30, 9, 10)]]
    assert judged_box(wall(10) + needle, targets) == []
    assert judged_box(wall(10) + targets[:1], targets)[0].endswith("of the occluder meets the target")


@pytest.mark.parametrize("copies", [1, 2, 3])
def test_3_the_number_of_crossings_is_odd(copies: int) -> None:
    even = ["no segment in general position that crosses an odd number of faces"]
    assert judged(wall(10) * copies) == ([] if copies % 2 else even)
    assert judged(wall(10) + box_triangles((12, -9, -9), (14, 13, 13))) == []
    assert judged(box_triangles((12, -9, -9), (14, 13, 13))) == even
    assert judged(box_triangles((12, 30, -9), (14, 33, 13))) == even


def test_3_a_shell_around_the_target_does_hide_it() -> None:
    assert judged(box_triangles((12, -9, -9), (24, 13, 13))) == []
    assert judged(box_triangles((-12, -9, -9), (5, 13, 13))) == []  # and one around the region


def test_faces_without_area_are_no_occluders() -> None:
    assert judged([*wall(10), [(10, 0, 40), (10, 0, 41), (10, 0, 42)]]) == [
        "face 3 of the occluder has no area"
    ]


class Middle:
    """Draws that are all alike, so that points are centres; the first ones only, if their number is given."""

    def __init__(self, first: int = 1000) -> None:
        self.left, self.random = first, np.random.default_rng(1)

    def integers(self, low: int, high: int, shape: tuple[int, ...]) -> np.ndarray:
        self.left -= 1
        return np.full(shape, 7) if self.left >= 0 else self.random.integers(low, high, shape)


def test_segments_through_an_edge_count_for_nothing() -> None:
    # The middle of the region and that of the target are both in the plane y = z, as is the diagonal.
    target = [[20, 0, 0], [20, 4, 2], [20, 2, 4]]
    scene = one_certificate([target, *wall(10, (-9, -9), (13, 13))], REGION, [0], [[1, 2]])
    batch = next(proofs.batches(scene))
    assert complaints(scene) == []
    stuck = [finding.measured for finding in proofs.faults(scene, batch, Middle())]  # type: ignore[arg-type]
    assert stuck == ["no segment in general position that crosses an odd number of faces"]
    # A start and an end are two draws: the second segment is in general position.
    assert list(proofs.faults(scene, batch, Middle(2))) == []  # type: ignore[arg-type]


def test_points_are_inside() -> None:
    corners = np.array([[[0, 0, 0], [256, 0, 0], [0, 256, 0]]] * 1000)
    points = parity._inner(corners, np.random.default_rng(0)) / parity.SCALE
    assert (points[:, :2] > 0).all()
    assert (points[:, 0] + points[:, 1] < 256).all()
    assert len(np.unique(points, axis=0)) > 900


def test_every_leaf_has_its_own_parts() -> None:
    # The upper half of the region is behind a high wall, the lower one behind a low one.
    high, low = wall(10, (-9, 2)), wall(9, high=(13, 2))
    triangles = [[(20, 0, 2), (20, 4, 2), (20, 0, 2)], *high, *low]
    triangles[0] = [(20, 0, 2), (20, 4, 2), (20, 2, 3)]
    region = [0, 0, 0, 4, 4, 4]
    assert complaints(one_certificate(triangles, region, [0], [[1, 2], [3, 4]], (3, 0, 0))) != []
    triangles[3:] = wall(9, high=(13, 3))
    assert complaints(one_certificate(triangles, region, [0], [[1, 2], [3, 4]], (3, 0, 0))) == []
    assert complaints(one_certificate(triangles, region, [0], [[3, 4], [1, 2]], (3, 0, 0))) != []
    for single in ([1, 2], [3, 4]):
        assert len(complaints(one_certificate(triangles, region, [0], [single]))) == 1


# ------------------------------------------------------------------ trees


def test_trees_are_read_in_preorder() -> None:
    box, triangle = (0, 0, 0, 5, 4, 2, 0, 4), (0, 0, 0, 8, 0, 0, 0, 8, 0)
    found = list(cuttrees.leaves(bytes([1, 4, 0, 0, 3, 0, 0]), box, 0, triangle))
    assert [(part[:6], rest) for part, rest in found] == [
        ((2, 0, 0, 5, 4, 2), (0, 0, 0, 4, 0, 0, 0, 8, 0)),
        ((2, 0, 0, 5, 4, 2), (4, 0, 0, 8, 0, 0, 0, 8, 0)),
        ((0, 0, 1, 2, 4, 2), triangle),
        ((0, 0, 0, 2, 4, 1), triangle),
    ]
    halves = list(cuttrees.leaves(bytes([6, 0, 0]), box, 0, triangle))  # from corner 2 to corner 0
    assert [part for _, part in halves] == [(0, 4, 0, 8, 0, 0, 0, 8, 0), (0, 0, 0, 8, 0, 0, 0, 4, 0)]
    negative = list(cuttrees.leaves(bytes([2, 0, 0]), (0, -3, 0, 1, 0, 1, -3, 0), 0, triangle))
    assert [(part[1], part[4]) for part, _ in negative] == [(-2, 0), (-3, -2)]


@pytest.mark.parametrize(
    ("codes", "said"),
    [
        ([], "after 0 codes 1 parts"),
        ([1, 0], "after 2 codes 1 parts"),
        ([0, 0], "code 1: 1 codes after"),
        ([7], "code 0: 7, with one target"),
        ([3, 3, 0, 0, 0], "code 1: a cut across axis 2 of a part that is one unit wide"),
        ([5, 5, 5, 5, 0, 0, 0, 0, 0], "code 3: the middle of edge 1 is not an integer"),
    ],
)
def test_what_is_no_tree(codes: list[int], said: str) -> None:
    with pytest.raises(cuttrees.TreeError, match=said):
        list(cuttrees.leaves(bytes(codes), (0, 0, 0, 5, 4, 2, 0, 4), 0, (0, 0, 0, 8, 0, 0, 0, 8, 0)))


@pytest.mark.parametrize("code", [1, 4])
def test_boxes_of_several_targets_are_not_cut(code: int) -> None:
    with pytest.raises(cuttrees.TreeError, match="with several targets"):
        list(cuttrees.leaves(bytes([code, 0, 0]), (0, 0, 0, 5, 4, 2, 0, 4), 0, ()))


# ------------------------------------------------------------------ keeping off, against rational clipping

SMALL = st.integers(-3, 3)
POINT = st.tuples(SMALL, SMALL, SMALL)
TRIANGLE = st.tuples(POINT, POINT, POINT).filter(
    lambda t: bool(np.cross(np.subtract(t[1], t[0]), np.subtract(t[2], t[0])).any())
)

@settings(max_examples=300)
@given(triangle=TRIANGLE, corners=st.tuples(POINT, POINT))
def test_keeping_off_boxes(triangle: Any, corners: Any) -> None:
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    found = separation.keep_off_closed_boxes(np.array([triangle]), low[None], high[None])
    if (low == high).sum() < 2:
        assert found[0] != common(triangle, box_sides(low, high), [False] * 6)
    if (low < high).all():
        found = separation.keep_off_open_boxes(np.array([triangle]), low[None], high[None])
        assert found[0] != common(triangle, box_sides(low, high), [True] * 6)


@settings(max_examples=500)
@given(triangle=TRIANGLE, other=TRIANGLE)
def test_keeping_off_triangles(triangle: Any, other: Any) -> None:
    check_keeping_off(triangle, other)


IN_PLANE = st.tuples(SMALL, SMALL).map(lambda p: (p[0], p[1], p[0] - 2 * p[1]))
IN_PLANE_TRIANGLE = st.tuples(IN_PLANE, IN_PLANE, IN_PLANE).filter(
    lambda t: bool(np.cross(np.subtract(t[1], t[0]), np.subtract(t[2], t[0])).any())
)


@settings(max_examples=300)
@given(triangle=IN_PLANE_TRIANGLE, other=IN_PLANE_TRIANGLE)
def test_keeping_off_triangles_in_the_same_plane(triangle: Any, other: Any) -> None:
    check_keeping_off(triangle, other)


def check_keeping_off(triangle: Any, other: Any) -> None:
    a, b, c = (np.array(corner) for corner in other)
    normal = np.cross(b - a, c - a)
    sides = [along(normal, a), along(-normal, a)]
    sides += [along(np.cross(normal, q - p), p) for p, q in ((a, b), (b, c), (c, a))]
    found = separation.keep_off_triangles(np.array([triangle]), np.array([other]))
    assert found[0] != common(triangle, sides, [False, False, True, True, True])


def test_all_pairs_of_triangles_in_a_plane() -> None:
    points = list(product(range(3), range(3), [0]))
    some = [
        (points[0], points[2], points[6]),
        (points[8], points[2], points[6]),
        (points[1], points[3], points[4]),
    ]
    away = [[separation.keep_off_triangles(np.array([a]), np.array([b]))[0] for b in some] for a in some]
    assert [[bool(x) for x in row] for row in away] == [
        [False, True, False],
        [True, False, True],
        [False, True, False],
    ]


@pytest.mark.parametrize(
    ("end", "crossed", "general"),
    [
        ((1, 1, 9), True, True),
        ((1, 1, -1), False, True),  # short of the plane
        ((9, 1, 9), False, True),  # past it
        ((2, 0, 9), False, False),  # through the inside of an edge
        ((0, 0, 9), False, False),  # through a corner
        ((-2, 0, 9), False, True),  # through the line of an edge, beside it
        ((1, 1, 0), False, False),  # up to the face
        ((9, 9, 0), False, True),  # up to its plane
    ],
)
def test_crossings(end: tuple[int, ...], crossed: bool, general: bool) -> None:
    start = np.array([[end[0], end[1], -9]])
    face = np.array([[[0, 0, 0], [4, 0, 0], [0, 4, 0]]])
    for one, other in ((start, np.array([end])), (np.array([end]), start)):
        found = parity._crossings(one, other, face)
        assert [bool(x[0]) for x in found] == [crossed, general]


def test_a_segment_in_the_plane_of_a_face_is_not_in_general_position() -> None:
    face = np.array([[[0, 0, 0], [4, 0, 0], [0, 4, 0]]])
    crossed, general = parity._crossings(np.array([[-1, 1, 0]]), np.array([[9, 1, 0]]), face)
    assert (bool(crossed[0]), bool(general[0])) == (False, False)
