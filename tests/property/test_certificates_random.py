"""What the validator's checker of certificates accepts is never contradicted by an exact segment."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from certificate_fixture import complaints, one_certificate
from hypothesis import given, settings
from hypothesis import strategies as st
from prism_reference import corners_of

from tilesnav_validator import cuttrees, prisms, proofs, shafts

Point = tuple[Fraction, Fraction, Fraction]
Triangle = tuple[Any, Any, Any]


def minus(a: Any, b: Any) -> tuple[Any, Any, Any]:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def det(a: Any, b: Any, c: Any) -> Any:
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


def blocks(c: Any, t: Any, face: Triangle) -> bool:
    """Whether the half-open segment [c, t) meets a closed triangle; False where it lies in its plane."""
    one, two = minus(face[1], face[0]), minus(face[2], face[0])
    start, end = det(one, two, minus(c, face[0])), det(one, two, minus(t, face[0]))
    if start == end or start * end > 0 or end == 0:
        return False
    turns = [det(minus(t, c), minus(face[i], c), minus(face[(i + 1) % 3], c)) for i in range(3)]
    return min(turns) >= 0 or max(turns) <= 0


def means(random: np.random.Generator, corners: Any, count: int) -> Iterator[Point]:
    """Points of a relative interior, some of them near corners and edges, some in the middle."""
    for _ in range(count):
        power = random.choice([0, 1, 12])
        weights = [Fraction(int(w) ** int(power)) for w in random.integers(1, 9, len(corners))]
        total = sum(weights)
        x, y, z = (
            sum(w * int(p[k]) for w, p in zip(weights, corners, strict=True)) / total for k in range(3)
        )
        yield x, y, z


def box_corners(low: Any, high: Any) -> list[Any]:
    return prisms.box_corners(np.array([low]), np.array([high]))[0].tolist()


def soup(random: np.random.Generator) -> tuple[list[Any], list[int], list[int]]:
    """Triangles about a line of sight along x: two for targets, then a bent sheet with what may spoil it."""
    spread = int(random.integers(1, 5))
    targets = [random.integers((18, 0, 0), np.add((18, 0, 0), spread + 1), (3, 3)) for _ in range(2)]
    reach = int(random.integers(spread, 12))
    y, z = [-reach, 2, reach + spread], [-reach, 1, reach + spread]
    x = random.integers(8, 15, (3, 3))
    grid = [[(int(x[i, j]), y[i], z[j]) for j in range(3)] for i in range(3)]
    sheet: list[Any] = []
    for i in range(2):
        for j in range(2):
            a, b, c, d = grid[i][j], grid[i + 1][j], grid[i + 1][j + 1], grid[i][j + 1]
            sheet += [[a, b, c], [a, c, d]]
    sheet = [face for face in sheet if random.random() > 0.03]
    for _ in range(int(random.integers(0, 2))):
        sheet.append(random.integers(-4, 22, (3, 3)).tolist())
    return [*(t.tolist() for t in targets), *sheet], [0, 1], list(range(2, 2 + len(sheet)))


def flat(face: Any) -> bool:
    a, b, c = (np.array(corner) for corner in face)
    return not np.cross(b - a, c - a).any()


@settings(max_examples=150)
@given(
    seed=st.integers(0, 2**32), several=st.booleans(), cut=st.integers(0, 6), shape=st.integers(0, 6)
)
def test_what_is_accepted_hides(seed: int, several: bool, cut: int, shape: int) -> None:
    accepted(seed, several, 0 if several else cut, shape)


def region_row(random: np.random.Generator, shape: int) -> list[int]:
    """A region before the soup, with eight numbers and its shape."""
    row = [-8, -2, -2, int(random.choice([0, 4, 8])), 8, 8, 0, 0, shape]
    if shape:
        _, v = prisms.AXES[shape]
        row[6] = row[v] + 2 * int(random.integers(-3, 3))
        row[7] = max(row[v + 3] + 2 * int(random.integers(-4, 2)), row[6] + 2)
        row[6] -= 4 * (row[6] == row[v] and row[7] == row[v + 3])
    return row


def accepted(seed: int, several: bool, cut: int, shape: int) -> bool:
    """Whether the checker accepts a random certificate; when it does, segments have been tried in vain."""
    random = np.random.default_rng(seed)
    triangles, targets, sheet = soup(random)
    triangles = [(2 * np.array(face)).tolist() for face in triangles]  # middles of edges are integers
    region = region_row(random, shape)
    used = targets if several else targets[:1]
    if flat(triangles[0]) or any(flat(triangles[face]) for face in sheet):
        return False
    occluders = [sheet] if not cut else [sheet, [f for f in sheet if random.random() > 0.1] or sheet]
    scene = one_certificate(triangles, region, used, occluders, (cut, 0, 0) if cut else (0,))
    if complaints(scene):
        return False
    faces = [tuple(map(tuple, triangles[face])) for part in occluders for face in part]
    for target in used:
        starts = means(random, corners_of(region, shape), 60)
        for c, t in zip(starts, means(random, triangles[target], 60), strict=True):
            assert any(blocks(c, t, face) for face in faces), (seed, several, cut, c, t)
    return True


def test_enough_is_accepted_and_enough_refused() -> None:
    for shapes in ((0,), (1, 2, 3, 4, 5, 6)):
        found = [
            accepted(seed, seed % 2 == 1, (seed // 2) % 7 if seed % 2 == 0 else 0, shapes[seed % len(shapes)])
            for seed in range(120)
        ]
        assert 20 < sum(found) < 100


CORNER = st.tuples(st.integers(-6, 12), st.integers(-6, 12), st.integers(-6, 12))


@settings(max_examples=300)
@given(target=st.tuples(CORNER, CORNER, CORNER), start=CORNER, end=CORNER, seed=st.integers(0, 2**32))
@pytest.mark.parametrize("boxed", [False, True])
def test_cleared_edges_are_not_met(boxed: bool, target: Any, start: Any, end: Any, seed: int) -> None:
    """Lines from a point t of the target through a point x of the edge do not reach the region beyond x."""
    low, high = [0, 0, 0], [4, 4, 4]
    target = [minus(corner, (-6, 0, 0)) for corner in target]
    corners = box_corners(np.min(target, axis=0), np.max(target, axis=0)) if boxed else target
    parts = shafts.Parts(np.array([box_corners(low, high)]), np.array([corners]))
    zero = np.zeros(1, np.int64)
    if len(shafts.open_edges(parts, zero, np.array([start]), np.array([end]))):
        return
    random = np.random.default_rng(seed)
    ends = [tuple(map(Fraction, start)), tuple(map(Fraction, end)), *means(random, [start, end], 20)]
    for t in means(random, corners, 8):
        for x in ends:
            assert x == t or not _reached(t, x, low, high), (target, start, end, t, x)


def _reached(t: Any, x: Any, low: list[int], high: list[int]) -> bool:
    """Whether the ray from t through x has a point at x or beyond in an open box."""
    first, last = Fraction(1), None
    way = minus(x, t)
    for k in range(3):
        if way[k] == 0:
            if not low[k] < t[k] < high[k]:
                return False
            continue
        bounds = sorted(((low[k] - t[k]) / way[k], (high[k] - t[k]) / way[k]))
        first = max(first, bounds[0])
        last = bounds[1] if last is None else min(last, bounds[1])
    return last is None or first < last


def test_parts_of_a_tree_fill_region_and_target() -> None:
    """Every point of region and target, borders of parts left out, is in exactly one leaf."""
    random = np.random.default_rng(4)
    box, triangle = (-8, 0, 3, 8, 16, 19, 0, 16), (0, 0, 0, 64, 0, 0, 0, 64, 0)
    for _ in range(20):
        codes: list[int] = []
        pending = [0]
        while pending:
            depth = pending.pop()
            code = int(random.integers(1, 7)) if depth < 3 and random.random() < 0.8 else 0
            codes.append(code)
            pending += [depth + 1] * (2 if code else 0)
        parts = list(cuttrees.leaves(bytes(codes), box, 0, triangle))
        volume = sum(
            np.prod(np.subtract(part[3:6], part[:3]))
            * abs((t[3] - t[0]) * (t[7] - t[1]) - (t[4] - t[1]) * (t[6] - t[0]))
            for part, t in parts
        )
        assert volume == 16**3 * 64**2
        for c, t in zip(
            means(random, box_corners(box[:3], box[3:6]), 10),
            means(random, np.reshape(triangle, (3, 3)), 10),
            strict=True,
        ):
            assert sum(_in_box(c, part) and _in_triangle(t, corners) for part, corners in parts) <= 1


def _in_box(c: Point, part: tuple[int, ...]) -> bool:
    return all(part[k] < c[k] < part[k + 3] for k in range(3))


def _in_triangle(t: Point, corners: tuple[int, ...]) -> bool:
    points = np.reshape(corners, (3, 3)).tolist()
    turns = []
    for i in range(3):
        a, b = points[i], points[(i + 1) % 3]
        turns.append((b[0] - a[0]) * (t[1] - a[1]) - (b[1] - a[1]) * (t[0] - a[0]))
    return all(turn > 0 for turn in turns) or all(turn < 0 for turn in turns)


def test_batches_hold_every_leaf_once() -> None:
    scene = one_certificate(
        np.arange(27).reshape(3, 3, 3) % 7, [0, 0, 0, 8, 8, 8], [0], [[1], [2], [1]], (1, 0, 2, 0, 0)
    )
    numbers = [int(n) for batch in proofs.batches(scene) for n in batch.number]
    assert numbers == [0, 1, 2]
