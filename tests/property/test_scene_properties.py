"""Properties of scene input on random meshes."""

from __future__ import annotations

from collections import Counter

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tilesnav_ref.scene import SceneSettings, Soup, build_scene
from tilesnav_ref.scene.crop import meets_rectangle
from tilesnav_ref.scene.noding import count_junctions, node
from tilesnav_ref.scene.weld import has_area, snap, weld

# few different coordinates, so that vertices meet, edges run over vertices and faces repeat
COARSE = st.integers(-4, 4)
WIDE = st.integers(-(1 << 22), 1 << 22)


@st.composite
def meshes(draw, coordinate=COARSE, planes: int = 9) -> tuple[np.ndarray, np.ndarray]:
    """Random triangles; those without area included."""
    points = draw(
        st.lists(st.tuples(coordinate, coordinate, st.integers(0, planes)), min_size=3, max_size=14)
    )
    index = st.integers(0, len(points) - 1)
    faces = draw(st.lists(st.tuples(index, index, index), min_size=1, max_size=20))
    return np.array(points, np.int64), np.array(faces, np.int64)


def with_area(mesh: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    vertices, faces = weld(*mesh)
    return weld(vertices, faces[has_area(vertices[faces])])


def area_vectors(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    corners = vertices[faces]
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


@given(meshes())
def test_welding_twice_is_welding_once(mesh) -> None:
    vertices, faces = weld(*mesh)
    again, same = weld(vertices, faces)
    assert np.array_equal(again, vertices)
    assert np.array_equal(same, faces)
    assert np.array_equal(vertices[faces], mesh[0][mesh[1]])
    assert len({tuple(v) for v in vertices.tolist()}) == len(vertices)


@given(
    st.lists(st.tuples(*[st.floats(-1000, 1000)] * 3), min_size=1, max_size=20), st.tuples(WIDE, WIDE, WIDE)
)
def test_snapping_is_within_half_a_step_and_keeps_grid_points(points, shift) -> None:
    positions = np.array(points)
    snapped = snap(positions, -10, "points")
    assert (np.abs(np.ldexp(snapped.astype(float), -10) - positions) <= 2.0**-11).all()
    exact = snapped + np.array(shift)
    assert np.array_equal(snap(np.ldexp(exact.astype(float), -10), -10, "points"), exact)


@given(meshes(planes=1))
def test_noding_keeps_area_plane_and_orientation_exactly(mesh) -> None:
    vertices, faces = with_area(mesh)
    noded = node(vertices, faces)
    whole, parts = area_vectors(vertices, faces), area_vectors(vertices, noded.faces)
    sums = np.zeros_like(whole)
    np.add.at(sums, noded.source, parts)
    assert np.array_equal(sums, whole)
    assert not np.cross(parts, whole[noded.source]).any()
    assert ((parts * whole[noded.source]).sum(axis=1) > 0).all()
    first = vertices[faces[noded.source, 0]][:, None, :]
    offsets = ((vertices[noded.faces] - first) * whole[noded.source][:, None, :]).sum(axis=2)
    assert not offsets.any()
    assert count_junctions(vertices, noded.faces) == 0
    assert (np.diff(noded.source) >= 0).all()


@given(meshes(planes=1))
def test_junctions_are_those_that_every_pair_shows(mesh) -> None:
    vertices, faces = with_area(mesh)
    edges = {tuple(sorted((int(f[i]), int(f[i - 1])))) for f in faces for i in range(3)}
    expected = 0
    for a, b in edges:
        along = vertices[b] - vertices[a]
        for v in vertices - vertices[a]:
            expected += not np.cross(along, v).any() and 0 < along @ v < along @ along
    assert count_junctions(vertices, faces) == expected


@given(meshes(), st.tuples(WIDE, WIDE, WIDE))
def test_building_a_scene_commutes_with_grid_shifts(mesh, shift) -> None:
    vertices, faces = with_area(mesh)
    if not len(faces):
        return
    part = np.zeros(len(faces), np.int64)
    here = build_scene(Soup(vertices, faces, part, ("a",)), SceneSettings())
    there = build_scene(Soup(vertices + np.array(shift), faces, part, ("a",)), SceneSettings())
    assert _face_set(here.scene.corners() + np.array(shift)) == _face_set(there.scene.corners())
    assert here.topology == there.topology
    assert here.junctions == there.junctions


def _face_set(corners: np.ndarray) -> Counter:
    """Faces without regard to which corner comes first."""
    turns = [np.roll(corners, -k, axis=1).reshape(-1, 9).tolist() for k in range(3)]
    return Counter(min(tuple(t) for t in options) for options in zip(*turns, strict=True))


@given(meshes(), st.integers(1, 6), st.integers(2, 8), st.integers(1, 12))
def test_scene_is_a_permutation_of_the_noded_faces(mesh, least, most, content) -> None:
    vertices, faces = with_area(mesh)
    if not len(faces):
        return
    part = np.arange(len(faces)) % 3
    chosen = SceneSettings(object_faces_min=least, object_faces_max=max(least, most), content_faces=content)
    built = build_scene(Soup(vertices, faces, part, ("a", "b", "c")), chosen)
    scene = built.scene
    noded = node(vertices, faces)
    assert _face_set(scene.corners()) == _face_set(vertices[noded.faces])
    assert sorted(built.source.tolist()) == noded.source.tolist()
    assert (np.diff(scene.face_object) >= 0).all()
    assert (np.diff(scene.object_content) >= 0).all()
    assert np.array_equal(np.unique(scene.face_object), np.arange(scene.object_count))
    assert np.array_equal(np.unique(scene.object_content), np.arange(scene.content_count))
    assert len(scene.object_names) == scene.object_count
    assert np.bincount(scene.face_object).max() <= max(least, most)


@given(st.lists(st.tuples(COARSE, COARSE), min_size=3, max_size=3), st.tuples(COARSE, COARSE, COARSE, COARSE))
def test_triangle_meets_rectangle_as_clipping_finds(triangle, sides) -> None:
    x0, x1 = sorted(sides[:2])
    y0, y1 = sorted(sides[2:])
    polygon = [tuple(map(float, p)) for p in triangle]
    for axis, limit, sign in ((0, x0, 1), (0, x1, -1), (1, y0, 1), (1, y1, -1)):
        polygon = _clip(polygon, axis, limit, sign)
    corners = np.array([triangle], float)
    assert bool(meets_rectangle(corners, (x0, y0, x1, y1))[0]) == bool(polygon)


def _clip(polygon, axis, limit, sign):
    """Part of a convex polygon on one side of a line, by Sutherland and Hodgman; borders belong to it."""
    kept = []
    for p, q in zip(polygon, [*polygon[1:], *polygon[:1]], strict=True):
        a, b = sign * (p[axis] - limit), sign * (q[axis] - limit)
        if a >= 0:
            kept.append(p)
        if (a > 0 > b) or (a < 0 < b):
            s = a / (a - b)
            point = [p[k] + s * (q[k] - p[k]) for k in range(2)]
            point[axis] = float(limit)
            kept.append(tuple(point))
    return kept
