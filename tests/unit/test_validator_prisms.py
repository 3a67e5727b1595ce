"""Regions that slant: their form, their cuts, what they hold, and what keeps off them."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from certificate_fixture import complaints, one_certificate
from clipping_reference import along, common
from hypothesis import given, settings
from hypothesis import strategies as st
from prism_reference import SHAPES, corners_of, halves, rows, sides

from tilesnav_validator import certfile, cuttrees, prisms, regions, separation, shafts

PRISM = (0, 0, 0, 8, 8, 4, -4, 8)
"""Shape 1: 0 < x < 8, -x / 2 < y < 8, 0 < z < 4."""
TRIANGLE = (0, 0, 0, 8, 0, 0, 0, 8, 0)


def corners(row: Any, shape: int) -> Any:
    return prisms.corners(np.array([row]), np.array([shape]))


# ------------------------------------------------------------------ form


def test_axes_are_those_of_the_specification() -> None:
    run, slanted = "xyzxyz", "yzxzxy"
    assert ["xyz"[u] + "xyz"[v] for u, v in prisms.AXES[1:]] == [
        u + v for u, v in zip(run, slanted, strict=True)
    ]


def test_corners_of_a_prism() -> None:
    assert corners(PRISM, 1)[0].tolist() == [
        [0, 0, 0], [8, -4, 0], [0, 8, 0], [8, 8, 0],
        [0, 0, 4], [8, -4, 4], [0, 8, 4], [8, 8, 4],
    ]  # fmt: skip


@given(data=st.lists(rows(), min_size=1, max_size=4))
def test_corners_of_prisms_and_boxes(data: list[tuple[tuple[int, ...], int]]) -> None:
    table = np.array([row for row, _ in data] * 2)
    shapes = np.array([shape for _, shape in data] + [0] * len(data))
    found = prisms.corners(table, shapes).tolist()
    assert found == [corners_of(row, shape) for row, shape in zip(table, shapes, strict=True)]


def test_a_box_is_a_prism_with_the_same_bounds_at_both_ends() -> None:
    assert prisms.filled([1, 2, 3, 4, 5, 6, 0, 0], 0) == (1, 2, 3, 4, 5, 6, 2, 5)
    assert prisms.filled([1, 2, 3, 4, 5, 6, 7, 8], 3) == (1, 2, 3, 4, 5, 6, 7, 8)


@pytest.mark.parametrize(
    ("row", "shape", "said"),
    [
        (PRISM, 1, []),
        (PRISM, 5, []),
        (PRISM, 7, ["7"]),
        (PRISM, 0, ["p and q [-4, 8]"]),
        ((0, 0, 0, 8, 8, 4, 0, 0), 0, []),
        ((0, 0, 0, 8, 8, 4, 0, 8), 1, ["shape 1, p and q [0, 8]"]),
        ((0, 0, 0, 8, 8, 4, 0, 8), 2, []),  # from 0 and 4 to 0 and 8
        ((0, 0, 0, 8, 8, 4, 8, 8), 1, ["shape 1, p and q [8, 8]"]),
        ((0, 0, 0, 8, 8, 4, 9, 8), 1, ["shape 1, p and q [9, 8]"]),
        ((0, 0, 0, 8, 0, 4, -4, 8), 1, ["from [0, 0, 0] to [8, 0, 4], p and q [-4, 8]"]),
        ((0, 0, 0, 8, 8, 4, 1 - 2**29, 8), 1, []),
        ((0, 0, 0, 8, 8, 4, 0, 2**29), 1, ["from [0, 0, 0] to [8, 8, 4], p and q [0, 536870912]"]),
    ],
)
def test_regions_have_one_form(row: tuple[int, ...], shape: int, said: list[str]) -> None:
    scene = one_certificate([TRIANGLE], [*row, shape], [0], [[0]])
    assert [finding.measured for finding in certfile.region_faults(scene.found)] == said


# ------------------------------------------------------------------ cuts


def parts(row: tuple[int, ...], shape: int, *codes: int) -> list[tuple[int, ...]]:
    found = cuttrees.leaves(bytes(codes), prisms.filled(list(row), shape), shape, TRIANGLE)
    return [part for part, _ in found]


def test_parts_of_a_prism() -> None:
    assert parts(PRISM, 1, 1, 0, 0) == [(4, -2, 0, 8, 8, 4, -4, 8), (0, 0, 0, 4, 8, 4, -2, 8)]
    assert parts(PRISM, 1, 2, 0, 0) == [(0, 4, 0, 8, 8, 4, 2, 8), (0, 0, 0, 8, 4, 4, -4, 2)]
    assert parts(PRISM, 1, 3, 0, 0) == [(0, 0, 2, 8, 8, 4, -4, 8), (0, 0, 0, 8, 8, 2, -4, 8)]


def test_a_part_that_is_a_box_is_cut_as_a_box() -> None:
    # The lower of the parts is -4 < y < -2 at both ends, and 7 is the middle of 0 and 15, rounded down.
    row = (0, -4, 0, 15, 0, 4, -4, 1)
    assert parts(row, 1, 2, 0, 1, 0, 0)[1:] == [(7, -4, 0, 15, -2, 4, -4, -2), (0, -4, 0, 7, -2, 4, -4, -2)]


@pytest.mark.parametrize(
    ("row", "codes", "said"),
    [
        ((0, 0, 0, 9, 8, 4, -4, 8), (1,), "code 0: a cut across axis 0 through a middle that is not an int"),
        ((0, 1, 0, 8, 8, 4, -4, 8), (1,), "code 0: a cut across axis 0 through a middle that is not an int"),
        ((0, 0, 0, 8, 8, 4, -4, 9), (1,), "code 0: a cut across axis 0 through a middle that is not an int"),
        ((0, 0, 0, 8, 1, 4, -4, 8), (2,), "code 0: a cut across axis 1 of a part that is one unit wide"),
        ((0, 0, 0, 8, 8, 4, 7, 8), (2,), "code 0: a cut across axis 1 of a part that is one unit wide"),
        ((0, 0, 0, 8, 8, 1, -4, 8), (3,), "code 0: a cut across axis 2 of a part that is one unit wide"),
        ((0, 0, 0, 2, 8, 4, -4, 8), (1, 1), "code 1: a cut across axis 0 through a middle that is not an"),
    ],
)
def test_cuts_that_do_not_divide(row: tuple[int, ...], codes: tuple[int, ...], said: str) -> None:
    with pytest.raises(cuttrees.TreeError, match=said):
        parts(row, 1, *codes, *[0] * (len(codes) + 1))


@settings(max_examples=300)
@given(
    prism=st.one_of(rows(size=9), rows(size=5, step=8)),
    codes=st.lists(st.integers(1, 3), min_size=1, max_size=6),
)
def test_cuts_are_middles_of_edges(prism: tuple[tuple[int, ...], int], codes: list[int]) -> None:
    row, shape = prism
    # Each cut has a leaf above it and the next cut below.
    tree = [code for cut in codes for code in (cut, 0)] + [0]
    expected: list[Any] = []
    rest: Any = corners_of(row, shape)
    for code in codes:
        found = halves(rest, code - 1)
        if found is None:
            with pytest.raises(cuttrees.TreeError):
                parts(row, shape, *tree)
            return
        above, rest = found
        expected.append(above)
    assert [corners_of(part, shape) for part in parts(row, shape, *tree)] == [*expected, rest]


def least_height(point: Any, some: Any) -> Fraction:
    """Positive inside a prism of eight corners, 0 on its border."""
    return min(along(normal, base)(point) for normal, base in sides(some))


@settings(max_examples=100)
@given(prism=rows(size=5, step=8), data=st.data())
def test_parts_fill_a_prism(prism: tuple[tuple[int, ...], int], data: st.DataObject) -> None:
    """Every point of the prism off the cuts is in exactly one part, and no other point is in one."""
    row, shape = prism
    codes = data.draw(st.permutations([1, 2, 3]))
    tree = [codes[0], codes[1], 0, 0, codes[2], 0, 0]
    number = st.fractions(-40, 40, max_denominator=7)
    some = [corners_of(part, shape) for part in parts(row, shape, *tree)]
    for _ in range(10):
        point = [data.draw(number) for _ in range(3)]
        heights = [least_height(point, part) for part in some]
        whole = least_height(point, corners_of(row, shape))
        assert (whole >= 0) == (max(heights) >= 0)
        assert sum(height > 0 for height in heights) == (whole > 0 and 0 not in heights)


# ------------------------------------------------------------------ holding


def held(row: Any, shape: int, points: list[list[Fraction]]) -> bool:
    return list(regions.outside(points, np.array([row]), np.array([shape]))) == []


@settings(max_examples=200)
@given(prism=rows(), data=st.data())
def test_what_a_region_holds(prism: tuple[tuple[int, ...], int], data: st.DataObject) -> None:
    row, shape = prism
    number = st.fractions(-5, 5, max_denominator=3)
    points = [[data.draw(number) for _ in range(3)] for _ in range(data.draw(st.integers(1, 2)))]
    least = min(least_height(point, corners_of(row, shape)) for point in points)
    assert held(row, shape, points) == (least >= 0)


def test_a_corner_that_is_out_is_named() -> None:
    hair = Fraction(1, 2**60)
    points = [[Fraction(4), Fraction(-2), Fraction(1)], [Fraction(4), Fraction(-2) - hair, Fraction(1)]]
    assert held(PRISM, 1, points[:1])
    table, shapes = np.array([PRISM] * 3), np.array([1, 2, 1])
    found = dict(regions.outside(points, table, shapes))
    assert found[0] == found[2] == "corner [4.0, -2.0, 1.0] units"
    assert found[1].startswith("from [4.0, -2.0, 1.0]")


# ------------------------------------------------------------------ keeping off

SMALL = st.integers(-4, 4)
POINT = st.tuples(SMALL, SMALL, SMALL)
FACE = st.tuples(POINT, POINT, POINT).filter(
    lambda t: bool(np.cross(np.subtract(t[1], t[0]), np.subtract(t[2], t[0])).any())
)


@settings(max_examples=1000)
@given(prism=rows(), face=FACE)
def test_keeping_off_prisms(prism: tuple[tuple[int, ...], int], face: Any) -> None:
    row, shape = prism
    found = separation.keep_off_open_prisms(np.array([face]), corners(row, shape))
    planes = [along(normal, base) for normal, base in sides(corners_of(row, shape))]
    assert found[0] != common(face, planes, [True] * 6)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("shape", SHAPES)
def test_contact_with_a_slanted_side(shape: int, side: int) -> None:
    u, v = SHAPES[shape]
    w = 3 - u - v
    row = [0] * 3 + [8] * 3 + [-4, 8]  # v > -u / 2
    if side < 0:
        row[v], row[v + 3], row[6:] = -8, 0, [-8, 4]  # v < u / 2

    def face(depth: int, far: int = 0) -> list[list[int]]:
        """A triangle before the slanted side, its last corner ``depth`` behind it, ``far`` along the run."""
        points = [[0, 0, 0] for _ in range(3)]
        for point, (at_u, at_v, at_w) in zip(
            points, ((-4, -2, 4), (12, -20, 4), (4 + far, depth - 2, 4)), strict=True
        ):
            point[u], point[v], point[w] = at_u, side * at_v, at_w
        return points

    faces = np.array([face(0), face(1), face(-1), face(0, 2), face(0, -2)])
    away = separation.keep_off_open_prisms(faces, np.repeat(corners(row, shape), 5, axis=0))
    assert away.tolist() == [True, False, True, False, True]


def test_faces_and_regions_of_both_kinds_are_told_apart() -> None:
    wall = [[(10, -30, -30), (10, 30, -30), (10, 0, 60)]]
    target = [(20, 0, 0), (20, 4, 0), (20, 0, 4)]
    met = "face 1 of the occluder meets the region"
    # Shape 5 runs along y and slants in x, up to 10 and one beyond.
    assert met not in complaints(one_certificate([target, *wall], [0, 0, 0, 4, 4, 4, 0, 10, 5], [0], [[1]]))
    assert met in complaints(one_certificate([target, *wall], [0, 0, 0, 4, 4, 4, 0, 11, 5], [0], [[1]]))


# ------------------------------------------------------------------ edges


def _sign(value: int) -> int:
    return (value > 0) - (value < 0)


@settings(max_examples=200)
@given(data=st.data(), far=st.sampled_from([1, 2**10, 2**22]))
def test_lines_that_pass_a_prism_closely(data: st.DataObject, far: int) -> None:
    row, shape = data.draw(rows(size=2**28))
    prism = corners_of(row, shape)
    number = st.integers(-(2**28), 2**28)
    target = [[data.draw(number) for _ in range(3)] for _ in range(3)]
    through = data.draw(st.sampled_from([*prism, *target]))
    way, off = (np.array([data.draw(st.integers(-9, 9)) for _ in range(3)]) for _ in range(2))
    start, end = through + far * way, through - 7 * far * way + off // 5
    some = shafts.Parts(corners(row, shape), np.array([target]))
    found = shafts._past_segments(some, np.zeros(1, np.int64), start[None], end[None])
    signs = set()
    for c in prism:
        for t in target:
            a, b, d = ([int(x) for x in np.subtract(p, start)] for p in (end, c, t))
            value = sum(
                a[i] * (b[j] * d[k] - b[k] * d[j]) for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
            )
            signs.add(_sign(value))
    assert found[0] == (signs in ({1}, {-1}, {0, 1}, {0, -1}))


def test_an_edge_that_only_the_prism_keeps_clear() -> None:
    # From (3, -1.5) to (-3, 2) the way meets x = 0 at y = 0.25; from the corner (1, -1.5) of the box around
    # the prism it would meet y = -0.625. Lengths are in quarters.
    row, box = (4, 0, 2, 12, 8, 8, -6, 8), (4, -6, 2, 12, 8, 8, -6, 8)
    target = np.array([[[-12, 8, 2], [-12, 12, 2], [-12, 12, 8]]] * 4)
    both = np.concatenate([corners(row, 1), corners(box, 0), corners(row, 1), corners(box, 0)])
    some = shafts.Parts(both, target)
    assert some.slanted.tolist() == [True, False, True, False]
    start, end = np.array([[0, 1, 0]] * 3 + [[0, -3, 0]]), np.array([[0, 1, 16]] * 3 + [[0, -3, 16]])
    start[2, 1] = end[2, 1] = 2  # half a metre: the prism sees past it
    assert shafts.open_edges(some, np.arange(4), start, end).tolist() == [1, 2]
