"""What must hold for the cells of any scene, on random triangles, beside brute force and fractions."""

from __future__ import annotations

import dataclasses
from itertools import combinations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from test_cells_overlap import meets_by_clipping

from tilesnav_ref.cells import CellComplex, CellError, CellSettings, decompose
from tilesnav_ref.scene.model import Scene

EXPONENT = -2
"""Steps of a quarter metre: triangles then touch boxes often."""
ALL = CellSettings(
    min_size=1.0,
    max_size=4.0,
    clearance=0.25,
    region=(0.0, 0.0, 8.0, 8.0),
    altitude_max=8.0,
    altitude_above="lowest",
    keep_interiors=True,
    method="boxes",
    coverage_points=50,
)


def make_scene(corners: np.ndarray) -> Scene:
    """Triangles (F, 3, 3) on the grid, and a floor in the corner of the domain that fixes its bounds."""
    floor = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[32, 32, 0], [31, 32, 0], [32, 31, 0]]])
    corners = np.concatenate((floor, corners.reshape(-1, 3, 3)))
    edges = corners[:, 1:] - corners[:, :1]
    corners = corners[np.any(np.cross(edges[:, 0], edges[:, 1]) != 0, axis=1)]
    faces = np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
    return Scene(
        corners.reshape(-1, 3), faces, np.zeros(len(faces), np.int32), np.zeros(1, np.int32), ("",), EXPONENT
    )


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    """A few random triangles over the floor, some in planes of the grid."""
    seed, count = draw(st.integers(0, 2**32 - 1)), draw(st.integers(0, 7))
    rng = np.random.default_rng(seed)
    corners = rng.integers(-4, 36, (count, 3, 3))
    corners[:, :, 2] = np.abs(corners[:, :, 2])
    for i in range(count):
        if rng.random() < 0.5:
            axis = rng.integers(0, 3)
            corners[i, :, axis] = corners[i, 0, axis]
    return make_scene(corners)


def boxes_of(cells: CellComplex) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    return [(tuple(a.tolist()), tuple(b.tolist())) for a, b in zip(cells.lower, cells.upper, strict=True)]


def run(scene: Scene, **change: object) -> CellComplex | None:
    """Cells, or None where there is no free space."""
    try:
        return decompose(scene, dataclasses.replace(ALL, **change))
    except CellError as error:
        if "no free space" not in str(error):
            raise
        return None


@given(scenes(), st.sampled_from([0.0, 0.25, 0.5]), st.sampled_from(["boxes", "voxel"]))
@settings(max_examples=60, deadline=None)
def test_cells_are_empty_disjoint_and_inside_the_domain(scene: Scene, clearance: float, method: str) -> None:
    cells = run(scene, clearance=clearance, method=method, voxel_size=1.5)
    if cells is None:
        return
    assert cells.clearance == round(clearance * 4)
    lower, upper = cells.lower - cells.clearance, cells.upper + cells.clearance
    for low, high in zip(lower, upper, strict=True):
        assert not any(meets_by_clipping(triangle, low, high) for triangle in scene.corners())
    for i, j in combinations(range(cells.count), 2):
        assert np.any((cells.lower[i] >= cells.upper[j]) | (cells.lower[j] >= cells.upper[i]))
    assert np.all(cells.lower >= 0)
    assert np.all(cells.upper <= 32)
    sizes = cells.upper - cells.lower
    assert np.all(sizes >= (4 if method == "boxes" else 6))
    assert np.all(sizes <= (16 if method == "boxes" else 6))
    assert 0.0 <= cells.coverage <= 1.0


@given(scenes(), st.sampled_from([0.0, 0.25]))
@settings(max_examples=60, deadline=None)
def test_portals_are_all_contacts_that_no_face_meets(scene: Scene, clearance: float) -> None:
    cells = run(scene, clearance=clearance)
    if cells is None:
        return
    sources = np.repeat(np.arange(cells.count), np.diff(cells.portal_offsets))
    found = {}
    for s, t, p in zip(sources, cells.portal_targets, cells.portal_polygons, strict=True):
        assert (int(s), int(t)) not in found
        found[int(s), int(t)] = int(p)
    expected = {}
    for i, j in combinations(range(cells.count), 2):
        low = np.maximum(cells.lower[i], cells.lower[j])
        high = np.minimum(cells.upper[i], cells.upper[j])
        if sorted(np.sign(high - low).tolist()) != [0, 1, 1] or np.sum(high - low) == 2:
            continue  # apart, or a square grid step, which is too little for a portal
        if not any(meets_by_clipping(triangle, low, high) for triangle in scene.corners()):
            expected[i, j] = expected[j, i] = (low.tolist(), high.tolist())
    assert found.keys() == expected.keys()
    for (i, j), (low, high) in expected.items():
        assert found[i, j] == found[j, i]
        polygon = cells.polygon_vertices[slice(*cells.polygon_offsets[found[i, j] :][:2])]
        assert polygon.min(axis=0).tolist() == low
        assert polygon.max(axis=0).tolist() == high
        assert np.all(np.count_nonzero(polygon != np.roll(polygon, 1, axis=0), axis=1) == 1)
        assert len({tuple(v) for v in polygon.tolist()}) == 4


@given(scenes(), st.tuples(*[st.integers(-10_000, 10_000)] * 3))
@settings(max_examples=30, deadline=None)
def test_cells_move_with_the_scene(scene: Scene, shift: tuple[int, int, int]) -> None:
    move = np.array(shift)
    moved = dataclasses.replace(scene, vertices=scene.vertices + move)
    x, y = shift[0] / 4, shift[1] / 4
    cells, other = run(scene), run(moved, region=(x, y, x + 8, y + 8))
    if cells is None or other is None:
        assert cells is other
        return
    assert np.array_equal(cells.lower + move, other.lower)
    assert np.array_equal(cells.upper + move, other.upper)
    assert np.array_equal(cells.portal_targets, other.portal_targets)
    assert np.array_equal(cells.polygon_vertices + move, other.polygon_vertices)
    assert np.array_equal(cells.kinds, other.kinds)


@given(scenes())
@settings(max_examples=30, deadline=None)
def test_voxels_turn_with_the_scene(scene: Scene) -> None:
    """Recursive boxes break ties by the order of the axes; voxels have none to break."""
    turned = dataclasses.replace(scene, vertices=np.ascontiguousarray(scene.vertices[:, [1, 0, 2]]))
    cells, other = (run(one, method="voxel", voxel_size=1.0) for one in (scene, turned))
    if cells is None or other is None:
        assert cells is other
        return
    swapped = [((a[1], a[0], a[2]), (b[1], b[0], b[2])) for a, b in boxes_of(other)]
    assert sorted(boxes_of(cells)) == sorted(swapped)
    assert cells.portal_count == other.portal_count


@given(scenes(), st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_one_more_face_adds_no_free_voxel(scene: Scene, seed: int) -> None:
    extra = np.random.default_rng(seed).integers(0, 32, (1, 3, 3))
    more = make_scene(np.concatenate((scene.corners(), extra)))
    cells, fewer = (run(one, method="voxel", voxel_size=1.0) for one in (scene, more))
    if fewer is not None:
        assert cells is not None
        assert set(boxes_of(fewer)) <= set(boxes_of(cells))


@given(scenes())
@settings(max_examples=30, deadline=None)
def test_cells_from_the_sky_are_connected_cells_of_all(scene: Scene) -> None:
    """The flood selects among the same boxes, and every kept component reaches the open sky."""
    everything, kept = run(scene), run(scene, keep_interiors=False)
    if everything is None or kept is None:
        return
    assert set(boxes_of(kept)) <= set(boxes_of(everything))
    reached = set(np.flatnonzero(kept.upper[:, 2] == 32).tolist())
    pending = list(reached)
    while pending:
        cell = pending.pop()
        for target in kept.portal_targets[kept.portal_offsets[cell] : kept.portal_offsets[cell + 1]].tolist():
            if target not in reached:
                reached.add(target)
                pending.append(target)
    assert len(reached) == kept.count


def test_same_cells_whatever_the_number_of_threads() -> None:
    scene = make_scene(np.random.default_rng(3).integers(0, 32, (6, 3, 3)))
    results = []
    for count in (1, 4, 4):
        results.append(run(scene, max_size=1.0, threads=count))
    first = results[0]
    assert first is not None
    for other in results[1:]:
        assert other is not None
        for field in dataclasses.fields(CellComplex):
            assert np.array_equal(getattr(first, field.name), getattr(other, field.name)), field.name
