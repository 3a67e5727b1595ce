"""Bounds of the largest L, and level codes judged by them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from validator_fixture import Small, failures, state_digest

from tilesnav_validator import lodbounds, lodjudge
from tilesnav_validator.findings import Settings
from tilesnav_validator.runner import judge

UNIT = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)


def bounds(vertices: Any, triangle: Any, steps: int = 60) -> tuple[float, float]:
    """Bounds of one pair, the greater of both sides of the face, after asking for a few thresholds between
    them."""
    triangles = np.array([triangle], dtype=float)
    normals = lodbounds.unit_normals(triangles)
    ends = [(0.0, 0.0)]
    for sign in (1.0, -1.0):
        pairs = lodbounds.Pairs(np.array([vertices], dtype=float), triangles, sign * normals)
        low, high, height = (float(x[0]) for x in lodbounds.rough(pairs))
        for _ in range(12 if height > 0 else 0):
            threshold = np.array([(max(low, 1e-9) * min(high, 1e12)) ** 0.5])
            found = lodbounds.refine(pairs, threshold, steps)
            low, high = max(low, float(found[0][0])), min(high, float(found[1][0]))
        ends.append((low, high))
    return max(low for low, _ in ends), max(high for _, high in ends)


def sampled(vertices: Any, triangle: Any, count: int = 20_000) -> float:
    """Largest L among random pairs of points; never more than the truth."""
    random = np.random.default_rng(3)
    p = random.dirichlet([0.15] * len(vertices), count) @ np.array(vertices, dtype=float)
    x = random.dirichlet([0.3] * 3, count) @ np.array(triangle, dtype=float)
    corners = np.array([triangle], dtype=float)
    r = p - x
    return float((np.abs(r @ lodbounds.unit_normals(corners)[0]) / (r**2).sum(axis=1)).max())


KNOWN = {
    "straight below": (UNIT, [(-9, -9, -2), (9, -9, -2), (0, 9, -2)], 1 / 2),
    "other side": (UNIT, [(-9, -9, 5), (9, -9, 5), (0, 9, 5)], 1 / 4),
    # Beside the face: the greatest h / (h^2 + 1) is 1/2, at h = 1.
    "beside": (UNIT, [(-3, -1, 0), (-3, 2, 0), (-1, 0.5, 0)], 1 / 2),
    # h / (h^2 + 4) rises up to the top of the cell, h = 1.
    "beside and far": (UNIT, [(-3, -1, 0), (-3, 2, 0), (-2, 0.5, 0)], 1 / 5),
    "both sides": (UNIT - [0, 0, 0.5], [(-3, -1, 0), (-3, 2, 0), (-2, 0.5, 0)], 0.5 / 4.25),
}


@pytest.mark.parametrize(("vertices", "triangle", "expected"), KNOWN.values(), ids=KNOWN.keys())
def test_known_maxima(vertices: Any, triangle: Any, expected: float) -> None:
    low, high = bounds(vertices, triangle)
    assert low <= expected * (1 + 1e-12)
    assert high >= expected
    assert high - low < 1e-5 * expected


def test_contact_is_infinite() -> None:
    low, high = bounds(UNIT, [(-3, -1, 0), (3, -1, 0), (0, 5, 0)])
    assert low > 1e6
    assert high == np.inf


def test_bounds_hold_for_random_pairs() -> None:
    random = np.random.default_rng(11)
    for _ in range(8):
        vertices = random.uniform(-3, 3, 3) + UNIT * random.uniform(0.5, 3, 3)
        triangle = random.uniform(-5, 5, 3) + random.normal(0, 2, (3, 3))
        for steps in (1, 3, 60):
            low, high = bounds(vertices, triangle, steps)
            best = sampled(vertices, triangle)
            assert high >= best
            assert low <= high * (1 + 1e-8)
        assert low >= best * (1 - 1e-5)


def test_nearest_points_of_a_triangle() -> None:
    triangle = np.array([[(0, 0, 0), (2, 0, 0), (0, 2, 0)]], dtype=float)
    cases = {
        (0.5, 0.5, 3): (0.5, 0.5, 0),
        (-1, -1, 1): (0, 0, 0),
        (1, -2, 0): (1, 0, 0),
        (2, 2, 5): (1, 1, 0),
    }
    for point, expected in cases.items():
        assert lodbounds.nearest(np.array([point], dtype=float), triangle).tolist() == [
            list(map(float, expected))
        ]


def test_scale() -> None:
    scale = lodjudge.Scale(8.0, 2.0, 4)
    codes = np.array([0, 1, 2, 3], dtype=np.uint8)
    assert scale.ceiling(codes).tolist() == [np.inf, 4, 2, 1]
    assert scale.floor(codes).tolist() == [2, 1, 0, 0]


def with_codes(tmp_path: Path, codes: list[int], **lod: Any) -> list[str]:
    """Failures of the small tileset with other codes, its digests and deltas put right."""
    small = Small()
    groups = small.groups
    groups["lod"]["codes"] = codes
    groups["pvs"]["digests"] = [
        state_digest([0, 1, 2, 3, 4], [0, 1, 2], codes[:3]),
        state_digest([0, 1, 2, 3], [0, 1], codes[3:]),
    ]
    there = [(o, codes[3 + o]) for o in (0, 1) if codes[o] != codes[3 + o]]
    back = [(o, codes[o]) for o in (0, 1) if codes[o] != codes[3 + o]] + [(2, codes[2])]
    groups["deltas"]["switchOffsets"] = [0, len(there), len(there) + len(back)]
    groups["deltas"]["switchObjects"] = [o for o, _ in there + back]
    groups["deltas"]["switchCodes"] = [c for _, c in there + back]
    small.extension["lod"].update(lod)
    return failures(small.write(tmp_path), rays=0)


@pytest.mark.parametrize(
    ("codes", "expected"),
    [
        ([1, 3, 15, 1, 1], []),
        ([0, 2, 14, 0, 0], []),
        ([2, 3, 15, 1, 1], ["lod/fine-enough"]),
        ([1, 4, 15, 1, 1], ["lod/fine-enough"]),
        ([1, 1, 15, 1, 1], ["lod/not-wasteful"]),
        ([1, 3, 13, 1, 1], ["lod/not-wasteful"]),
        ([1, 3, 16, 1, 1], ["lod/code-range"]),
        ([2, 1, 15, 1, 1], ["lod/fine-enough", "lod/not-wasteful"]),
    ],
)
def test_codes(tmp_path: Path, codes: list[int], expected: list[str]) -> None:
    assert with_codes(tmp_path, codes) == expected


def test_borders_between_codes(tmp_path: Path) -> None:
    """The floor's largest L is 1/m: with reference 4 that is the border of codes 1 and 2, which is code 2."""
    assert with_codes(tmp_path, [2, 4, 15, 2, 2], reference=4.0) == []
    assert with_codes(tmp_path, [1, 3, 15, 1, 1], reference=4.0) == []
    assert with_codes(tmp_path, [2, 4, 15, 2, 2], reference=4.0 * (1 - 1e-6)) == ["lod/fine-enough"]
    assert with_codes(tmp_path, [0, 2, 15, 0, 0], reference=4.0 * (1 - 1e-6)) == []
    assert with_codes(tmp_path, [0, 2, 15, 0, 0], reference=4.0 * (1 + 1e-6)) == ["lod/not-wasteful"]


def test_a_choice_of_cells_is_said_to_be_one(tmp_path: Path) -> None:
    result = judge(Small().write(tmp_path), Settings(rays=0, lod_pairs=6))
    found = {j.requirement.id: j for j in result.judgements}["lod/fine-enough"]
    assert (found.verdict, found.note) == ("not refuted", "1 of 2 cells, 0 codes undecided, seed 0")


def test_codes_that_the_bounds_cannot_decide_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lodjudge, "STEPS", 0)
    result = judge(Small().write(tmp_path), Settings(rays=0))
    found = {j.requirement.id: (j.verdict, j.note) for j in result.judgements}
    assert found["lod/fine-enough"] == ("pass", "")
    assert found["lod/not-wasteful"] == ("not refuted", "2 of 2 cells, 1 codes undecided, seed 0")
