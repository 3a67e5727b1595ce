"""Geometry of cells and portals in a whole tileset: just inside and just outside of each limit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from validator_fixture import FLOOR, WALL, Small, box_planes, failures

from tilesnav_validator.findings import Settings
from tilesnav_validator.runner import judge

STEP = 2.0**-10


def cells(tmp_path: Path, first: list[Any], second: list[Any], **changes: Any) -> list[str]:
    """Failures with other planes; portals, LOD and rays may fail as well and are left out."""
    small = Small()
    small.groups["cells"]["planes"] = [first, second]
    small.extension.update(changes)
    small.extension["sectors"][0]["boundingVolume"]["box"] = [0, 0, 0, 99, 0, 0, 0, 99, 0, 0, 0, 99]
    return [name for name in failures(small.write(tmp_path), rays=0) if name.startswith("cell/")]


A, B = box_planes((-4, -2, 1), (0, 2, 3)), box_planes((0, -2, 1), (3, 2, 3))


def test_flipped_planes_of_every_side(tmp_path: Path) -> None:
    for side in range(6):
        flipped = [list(plane) for plane in A]
        flipped[side] = [-x for x in flipped[side]]
        assert cells(tmp_path, flipped, B) == ["cell/bounded"]


def test_smallest_cells(tmp_path: Path) -> None:
    assert cells(tmp_path, box_planes((-4, -2, 1), (2 * STEP - 4, 2, 3)), B) == []
    assert cells(tmp_path, box_planes((-4, -2, 1), (1.75 * STEP - 4, 2, 3)), B) == ["cell/non-empty"]
    assert cells(tmp_path, box_planes((-4, -2, 1), (-4, 2, 3)), B) == ["cell/non-empty"]
    assert cells(tmp_path, box_planes((0, -2, 1), (-4, 2, 3)), B) == ["cell/non-empty"]


def cut(height: float) -> list[list[float]]:
    """A triangular prism of five planes whose sixth plane cuts its edge off, ``height`` below it."""
    root = float(np.sqrt(0.5))
    planes = box_planes((-4, -2, 1), (-1, 2, 3 - height))
    return [*planes[:1], [root, 0.0, root, -root * (3 - 4)], planes[2], planes[3], planes[4], planes[5]]


def test_planes_that_bound_nothing(tmp_path: Path) -> None:
    assert cells(tmp_path, cut(0.5), B) == []
    assert cells(tmp_path, cut(STEP**2 / 4 * 1.01), B) == []
    assert cells(tmp_path, cut(0.0), B) == ["cell/no-redundant-plane"]
    assert cells(tmp_path, cut(-0.5), B) == ["cell/no-redundant-plane"]
    doubled = cut(0.5)
    doubled[5] = doubled[1]
    assert cells(tmp_path, doubled, B) == ["cell/no-redundant-plane"]


def test_cells_that_overlap(tmp_path: Path) -> None:
    assert cells(tmp_path, A, box_planes((-STEP, -2, 1), (3, 2, 3))) == ["cell/disjoint-interiors"]
    assert cells(tmp_path, A, A) == ["cell/disjoint-interiors"]
    assert cells(tmp_path, A, box_planes((-3, -1, 1.5), (-2, 1, 2))) == ["cell/disjoint-interiors"]
    assert cells(tmp_path, A, box_planes((0, 2, 3), (3, 3, 4))) == []  # a common corner


def ridge(along: int, side: float, top: float) -> list[list[float]]:
    """A prism with a ridge (for side -1 a keel) of 2 m along x or y at z = top; a sixth plane cuts its
    foot."""
    root = float(np.sqrt(0.5))
    across = 1 - along
    planes = []
    for sign in (1.0, -1.0):
        slope, end = [0.0] * 4, [0.0] * 4
        slope[across], slope[2], slope[3] = sign * root, side * root, -side * root * top
        end[along], end[3] = sign, -1.0
        planes += [slope, end]
    foot = [0.0, 0.0, 0.0, -0.5]
    foot[across] = 1.0
    return [*planes, [0.0, 0.0, -side, side * (top - side * 0.75)], foot]


def test_slanted_cells_that_no_facet_parts(tmp_path: Path) -> None:
    lower = ridge(0, 1.0, 2.0)
    assert cells(tmp_path, lower, ridge(1, -1.0, 2.0 + STEP), clearance=0) == []
    assert cells(tmp_path, lower, ridge(1, -1.0, 2.0), clearance=0) == []
    assert cells(tmp_path, lower, ridge(1, -1.0, 2.0 - STEP), clearance=0) == ["cell/disjoint-interiors"]


def test_faces_at_the_clearance(tmp_path: Path) -> None:
    assert cells(tmp_path, A, B, clearance=1.0) == []
    assert cells(tmp_path, A, B, clearance=1.0 + STEP) == ["cell/clear-of-geometry"]
    assert cells(tmp_path, A, box_planes((0, -2, 0.25), (3, 2, 3))) == []
    assert cells(tmp_path, A, box_planes((0, -2, 0.25 - STEP), (3, 2, 3))) == ["cell/clear-of-geometry"]


def test_a_tilted_plane_lets_a_face_poke_in(tmp_path: Path) -> None:
    tilted = [list(plane) for plane in B]
    length = float(np.hypot(1, 0.4))
    tilted[1] = [1 / length, 0.0, 0.4 / length, -(3 + 0.4 * 1) / length]
    assert cells(tmp_path, A, tilted) == []
    tilted[1] = [1 / length, 0.0, -0.4 / length, -(3 - 0.4 * 1) / length]
    assert cells(tmp_path, A, tilted) == ["cell/clear-of-geometry"]


@pytest.mark.parametrize(
    ("plane", "expected"),
    [
        ([1.0 + 2.0**-41, 0.0, 0.0, 0.0], []),
        ([1.0 + 2.0**-39, 0.0, 0.0, 0.0], ["cell/unit-normals"]),
        ([2.0, 0.0, 0.0, 0.0], ["cell/unit-normals"]),
        ([0.0, 0.0, 0.0, 0.0], ["cell/unit-normals"]),
        ([float("nan"), 0.0, 0.0, 0.0], ["cell/unit-normals"]),
        ([1.0, 0.0, 0.0, float("inf")], ["cell/unit-normals"]),
        ([1e300, 1e300, 0.0, 0.0], ["cell/unit-normals"]),
    ],
)
def test_normals(tmp_path: Path, plane: list[float], expected: list[str]) -> None:
    first = [list(p) for p in A]
    first[1] = plane
    assert cells(tmp_path, first, B) == expected


def test_kinds(tmp_path: Path) -> None:
    small = Small()
    small.groups["cells"]["kinds"] = [0, 2]
    assert failures(small.write(tmp_path), rays=0) == ["cell/known-kind"]


def test_volumes_of_sectors(tmp_path: Path) -> None:
    for half, expected in ((3.5, []), (3.5 - STEP, []), (3.5 - 1.5 * STEP, ["cell/sector-volume-bounds"])):
        small = Small()
        small.extension["sectors"][0]["boundingVolume"]["box"][3] = half
        assert failures(small.write(tmp_path), rays=0) == expected


def portal(tmp_path: Path, vertices: list[Any] | None = None, **changes: Any) -> list[str]:
    small = Small()
    for name, value in changes.items():
        small.groups["portals"][name] = value
    if vertices is not None:
        small.groups["portals"]["vertices"] = vertices
        small.groups["portals"]["polygonOffsets"] = [0, len(vertices)]
    return failures(small.write(tmp_path), rays=0)


SQUARE = [[0, -2, 1], [0, 2, 1], [0, 2, 3], [0, -2, 3]]


def moved(index: int, *by: float) -> list[list[float]]:
    return [
        [x + d for x, d in zip(v, by, strict=True)] if i == index else list(v) for i, v in enumerate(SQUARE)
    ]


def test_polygons_as_they_should_be(tmp_path: Path) -> None:
    assert portal(tmp_path, SQUARE[::-1]) == []
    assert portal(tmp_path, SQUARE[2:] + SQUARE[:2]) == []
    assert portal(tmp_path, [*SQUARE, [0, -2, 2]]) == []  # a vertex on an edge
    assert portal(tmp_path, moved(1, 0, -STEP, 0)) == []
    assert portal(tmp_path, moved(1, STEP, 0, 0)) == []


@pytest.mark.parametrize(
    "vertices",
    [
        moved(1, 0, -2 * STEP, 0),
        moved(1, 0, 2 * STEP, 0),
        moved(1, 2 * STEP, 0, 0),
        moved(2, 0, float("nan"), 0),
        [SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]],
        SQUARE[:3],
        SQUARE[:2],
        [],
        [SQUARE[0]] * 4,
        [[1, y, z] for _, y, z in SQUARE],
        SQUARE * 2,
    ],
)
def test_polygons_as_they_should_not_be(tmp_path: Path, vertices: list[Any]) -> None:
    assert portal(tmp_path, vertices) == ["portal/shared-polygon"]


def test_a_portal_between_cells_that_only_share_an_edge(tmp_path: Path) -> None:
    small = Small()
    small.groups["cells"]["planes"][1] = box_planes((0, 2, 1), (3, 4, 3))
    small.extension["sectors"][0]["boundingVolume"]["box"] = [0, 0, 0, 9, 0, 0, 0, 9, 0, 0, 0, 9]
    assert "portal/shared-polygon" in failures(small.write(tmp_path), rays=0)


def test_numbers_of_portals(tmp_path: Path) -> None:
    assert portal(tmp_path, targets=[2, 0]) == ["portal/target-exists"]
    assert portal(tmp_path, targets=[0, 0]) == ["portal/target-exists"]
    assert portal(tmp_path, polygons=[0, 1]) == ["portal/target-exists"]
    small = Small()
    small.groups["portals"].update(polygons=[0, 1], polygonOffsets=[0, 4, 8], vertices=SQUARE * 2)
    assert failures(small.write(tmp_path), rays=0) == ["portal/symmetric"]


def test_two_portals_to_the_same_cell(tmp_path: Path) -> None:
    small = Small()
    small.groups["portals"].update(offsets=[0, 2, 3], targets=[1, 1, 0], polygons=[0, 0, 0])
    small.groups["deltas"].update(enteredOffsets=[0, 0, 0, 1], leftOffsets=[0, 1, 2, 2], left=[4, 4])
    small.groups["deltas"].update(
        switchOffsets=[0, 1, 2, 4], switchObjects=[1, 1, 1, 2], switchCodes=[1, 1, 3, 15]
    )
    small.extension["portalCount"] = 3
    assert failures(small.write(tmp_path), rays=0) == ["portal/target-exists"]
    small.groups["portals"]["targets"] = [5, 5, 0]
    assert failures(small.write(tmp_path), rays=0) == ["portal/target-exists"]


def test_a_portal_without_a_way_back(tmp_path: Path) -> None:
    small = Small()
    small.groups["portals"].update(offsets=[0, 1, 1], targets=[1], polygons=[0])
    small.groups["deltas"].update(
        enteredOffsets=[0, 0], entered=[], leftOffsets=[0, 1], left=[4], switchOffsets=[0, 1]
    )
    small.groups["deltas"].update(switchObjects=[1], switchCodes=[1])
    small.extension["portalCount"] = 1
    assert failures(small.write(tmp_path), rays=0) == ["portal/symmetric"]


def test_no_portals_at_all(tmp_path: Path) -> None:
    small = Small()
    small.groups["portals"].update(
        offsets=[0, 0, 0], targets=[], polygons=[], polygonOffsets=[0], vertices=[]
    )
    small.groups["deltas"].update(enteredOffsets=[0], entered=[], leftOffsets=[0], left=[], switchOffsets=[0])
    small.groups["deltas"].update(switchObjects=[], switchCodes=[])
    small.extension["portalCount"] = 0
    assert failures(small.write(tmp_path), rays=0) == []


def test_a_thin_wall_in_the_plane_of_a_portal(tmp_path: Path) -> None:
    def with_wall(triangle: list[Any]) -> list[str]:
        small = Small(objects=[FLOOR, WALL, [triangle]])
        small.extension["clearance"] = 0
        return [
            name for name in failures(small.write(tmp_path), rays=0) if name.startswith(("cell", "portal"))
        ]

    assert with_wall([(0, -1, 1.5), (0, 1, 1.5), (0, 0, 2.5)]) == ["portal/clear-of-geometry"]
    assert with_wall([(0, -1, 0), (0, 1, 0), (0, 0, 1)]) == []  # touches the border only
    assert with_wall([(0, -1, 0), (0, 1, 0), (0, 0, 1 + STEP)]) == ["portal/clear-of-geometry"]
    assert with_wall([(0, 3, 1), (0, 2, 1), (0, 2, 3)]) == []
    # faces without area: a segment in the plane, a point in it, one that crosses it, one on the border
    assert with_wall([(0, -1, 2), (0, 1, 2), (0, 0, 2)]) == ["portal/clear-of-geometry"]
    assert with_wall([(0, 0, 2)] * 3) == ["portal/clear-of-geometry"]
    assert with_wall([(0, -2, 1), (0, 2, 1), (0, 0, 1)]) == []


def test_faces_without_area_reach_into_cells_too(tmp_path: Path) -> None:
    def with_face(*triangle: Any) -> list[str]:
        small = Small(objects=[FLOOR, WALL, [triangle]])
        return [name for name in failures(small.write(tmp_path), rays=0) if name.startswith("cell/")]

    assert with_face((-3, 0, 0), (-3, 0, 2), (-3, 0, 4)) == ["cell/clear-of-geometry"]
    assert with_face(*[(-3, 0, 2)] * 3) == ["cell/clear-of-geometry"]
    assert with_face(*[(-3, 0, 0.75)] * 3) == []  # at the clearance of 0.25


def test_polygons_that_no_portal_names(tmp_path: Path) -> None:
    small = Small()
    portals = small.groups["portals"]
    portals.update(polygonOffsets=[0, 4, 6], vertices=[*portals["vertices"], [9, 9, 9], [float("nan"), 0, 0]])
    assert failures(small.write(tmp_path), rays=0) == []


def test_of_two_planes_of_one_half_space_neither_counts(tmp_path: Path) -> None:
    planes = [list(plane) for plane in A]
    root = float(np.sqrt(0.5))
    planes[0] = [-root, 0.0, root, -root * 7]  # a slope from the upper far edge, so that five planes bound
    planes[5] = planes[3]
    small = Small()
    small.groups["cells"]["planes"] = [planes, B]
    result = judge(small.write(tmp_path), Settings(rays=0))
    row = next(j for j in result.judgements if j.requirement.id == "cell/no-redundant-plane")
    assert [finding.where for finding in row.findings] == ["cell 0 plane 3", "cell 0 plane 5"]
