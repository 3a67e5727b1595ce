"""Vertices on edges, and faces divided at them, on cases worked by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tilesnav_ref.scene import SceneError
from tilesnav_ref.scene.junctions import find_junctions
from tilesnav_ref.scene.noding import count_junctions, node
from tilesnav_ref.scene.resplit import resplit
from tilesnav_ref.scene.topology import count_topology, edge_keys
from tilesnav_ref.scene.weld import has_area, weld

TOP = (1 << 23) - 1


def ints(rows: object) -> np.ndarray:
    return np.array(rows, np.int64)


def test_vertices_on_an_edge_are_found_in_their_order() -> None:
    vertices = ints([(0, 0, 0), (12, 6, 3), (8, 4, 2), (4, 2, 1), (4, 2, 2), (16, 8, 4), (-4, -2, -1)])
    edge, vertex = find_junctions(vertices, ints([(0, 1), (1, 0), (0, 4)]))
    assert edge.tolist() == [0, 0, 1, 1]
    assert vertex.tolist() == [3, 2, 2, 3]


def test_ends_and_near_misses_are_no_junctions() -> None:
    vertices = ints([(0, 0, 0), (100, 0, 0), (50, 1, 0), (50, 0, -1), (101, 0, 0), (-1, 0, 0)])
    edge, _ = find_junctions(vertices, ints([(0, 1)]))
    assert len(edge) == 0


def test_junctions_are_exact_over_the_whole_range() -> None:
    low, high = (-TOP, -TOP, -TOP), (TOP, TOP, TOP - 1)
    vertices = ints([low, high, (0, 0, 0), (TOP, -TOP, TOP), (-TOP, TOP, -TOP)])
    edge, vertex = find_junctions(vertices, ints([(0, 1), (3, 4)]))
    assert (edge.tolist(), vertex.tolist()) == ([1], [2])


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("count", [1, 7, 300])
def test_long_edges_with_many_vertices(axis: int, count: int) -> None:
    generator = np.random.default_rng(3)
    along = np.unique(generator.integers(1, 99_999, count))
    vertices = np.zeros((len(along) + 2, 3), np.int64)
    vertices[0, axis], vertices[1, axis] = 0, 100_000
    vertices[2:, axis] = along
    noise = generator.integers(-3000, 3000, (200, 3))
    noise[:, (axis + 1) % 3] |= 1  # never on the line
    edge, vertex = find_junctions(np.concatenate((vertices, noise)), ints([(0, 1), (1, 0)]))
    assert vertex[edge == 0].tolist() == list(range(2, len(along) + 2))
    assert vertex[edge == 1].tolist() == list(range(len(along) + 1, 1, -1))


def test_junctions_refuse_wrong_shapes_and_magnitudes() -> None:
    with pytest.raises(ValueError, match="shapes"):
        find_junctions(ints([(0, 0)]), ints([(0, 0)]))
    with pytest.raises(ValueError, match="2\\*\\*23"):
        find_junctions(ints([(0, 0, 0), (TOP + 1, 0, 0)]), ints([(0, 1)]))


def area_vectors(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Twice the area times the normal, of every face; exact."""
    corners = vertices[faces]
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


@pytest.mark.parametrize("extra", [(0, 0, 1), (0, 1, 1), (2, 0, 3), (3, 2, 1), (4, 4, 4), (9, 0, 0)])
def test_rings_are_divided_into_triangles_with_area(extra: tuple[int, int, int]) -> None:
    corners = ints([(0, 0, 0), (5040, 0, 2520), (2520, 5040, 0)])
    ring = []
    for i, count in enumerate(extra):
        a, b = corners[i], corners[(i + 1) % 3]
        ring += [a + (b - a) * k // (count + 1) for k in range(count + 1)]
    vertices = ints(ring)
    faces, source = resplit(vertices, np.arange(len(ring)), ints([0, len(ring)]))
    assert len(faces) == len(ring) - 2
    assert not source.any()
    parts = area_vectors(vertices, faces)
    whole = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    assert (parts @ whole > 0).all()
    assert np.array_equal(parts.sum(axis=0), whole)
    assert np.unique(edge_keys(faces), return_counts=True)[1].max() == 2


def test_rings_of_equal_points_are_divided_alike() -> None:
    vertices = ints([(0, 0, 0), (4, 0, 0), (8, 0, 0), (4, 4, 0), (0, 8, 0), (0, 4, 0)])
    ring = [0, 1, 2, 3, 4, 5]
    rings = [ring, ring[2:] + ring[:2], ring[::-1]]
    faces, source = resplit(vertices, ints(rings).ravel(), ints([0, 6, 12, 18]))
    sets = [{tuple(sorted(f)) for f in faces[source == k].tolist()} for k in range(3)]
    assert sets[0] == sets[1] == sets[2]


def test_rings_without_area_are_refused() -> None:
    vertices = ints([(0, 0, 0), (1, 0, 0), (2, 0, 0)])
    with pytest.raises(ValueError, match="without area"):
        resplit(vertices, np.arange(3), ints([0, 3]))
    with pytest.raises(ValueError, match="three points"):
        resplit(vertices, np.arange(2), ints([0, 2]))


def test_walls_that_meet_in_a_junction_share_edges_after_noding() -> None:
    vertices = ints([(0, 0, 0), (8, 0, 0), (8, 0, 8), (4, 0, 0), (0, 0, -8), (8, 0, -8)])
    faces = ints([(0, 1, 2), (0, 4, 3), (3, 5, 1), (4, 5, 3)])
    assert count_junctions(vertices, faces) == 1
    noded = node(vertices, faces)
    assert noded.junctions == 1
    assert noded.source.tolist() == [0, 0, 1, 2, 3]
    assert count_junctions(vertices, noded.faces) == 0
    keys, uses = np.unique(edge_keys(noded.faces), return_counts=True)
    assert uses[np.isin(keys, [(0 << 32) | 3, (1 << 32) | 3])].tolist() == [2, 2]


def test_cuts_that_run_over_a_vertex_within_the_face_are_noded_too() -> None:
    """The vertex in the middle is on no edge at first, but on the cut between the middles of two sides."""
    vertices = ints(
        [(0, 0, 0), (16, 0, 0), (0, 16, 0), (8, 0, 0), (0, 8, 0), (4, 4, 0), (4, 4, 9), (5, 4, 9)]
    )
    faces = ints([(0, 1, 2), (3, 7, 6), (4, 6, 7), (5, 6, 7)])
    noded = node(vertices, faces)
    assert noded.junctions == 2
    assert count_junctions(vertices, noded.faces) == 0
    assert (noded.source == 0).sum() > 3
    whole = area_vectors(vertices, faces)[0]
    assert np.array_equal(area_vectors(vertices, noded.faces[noded.source == 0]).sum(axis=0), whole)


def test_doubled_faces_stay_doubled() -> None:
    vertices = ints([(0, 0, 0), (8, 0, 0), (0, 8, 0), (2, 0, 0), (4, 4, 0), (2, 0, 5), (4, 4, 5)])
    faces = ints([(0, 1, 2), (2, 1, 0), (3, 4, 5), (4, 6, 5)])
    noded = node(vertices, faces)
    assert count_topology(len(vertices), noded.faces).doubled_faces == (noded.source == 0).sum() == 3


def test_noding_beyond_the_limit_is_refused() -> None:
    vertices = ints([(0, 0, 0), (8, 0, 0), (0, 8, 0), (4, 0, 0), (4, -4, 0)])
    with pytest.raises(SceneError, match="more than 2 faces"):
        node(vertices, ints([(0, 1, 2), (3, 4, 1)]), max_faces=2)


def test_weld_orders_and_drops_vertices() -> None:
    vertices, faces = weld(
        ints([(5, 0, 0), (0, 0, 1), (9, 9, 9), (0, 0, 1), (0, 0, 0)]), ints([(0, 1, 4), (3, 4, 0)])
    )
    assert vertices.tolist() == [[0, 0, 0], [0, 0, 1], [5, 0, 0]]
    assert faces.tolist() == [[2, 1, 0], [1, 0, 2]]
    none, no_faces = weld(ints([(1, 2, 3)]), np.zeros((0, 3), np.int64))
    assert (len(none), len(no_faces)) == (0, 0)


def test_area_is_decided_exactly_at_the_limits() -> None:
    flat = [(-TOP, -TOP, -TOP), (0, 0, 0), (TOP, TOP, TOP)]
    bent = [(-TOP, -TOP, -TOP), (0, 0, 1), (TOP, TOP, TOP)]
    assert has_area(ints([flat, bent])).tolist() == [False, True]


def test_topology_of_three_faces_at_an_edge() -> None:
    faces = ints([(0, 1, 2), (1, 0, 3), (0, 1, 4), (5, 6, 7), (7, 5, 6)])
    counts = count_topology(8, faces)
    assert (counts.components, counts.boundary_edges, counts.non_manifold_edges, counts.doubled_faces) == (
        2,
        6,
        1,
        1,
    )
    empty = count_topology(0, np.zeros((0, 3), np.int64))
    assert (empty.components, empty.boundary_edges) == (0, 0)
