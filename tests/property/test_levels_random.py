"""Errors and face maps of random meshes: open, non-manifold, folded, doubled."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from levels_reference import farthest

from tilesnav_ref.levels.simplify import simplify_object
from tilesnav_ref.scene.weld import has_area

SIZES = (1, 7, 256)
"""Grid steps of a unit."""


@st.composite
def meshes(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """Few vertices in a small box, so that faces share edges, coincide, and cross."""
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    count = draw(st.integers(4, 12))
    flat = draw(st.booleans())
    spread = np.array((6, 6, 1 if flat else 6))
    vertices = np.unique(random.integers(0, spread, (count, 3)), axis=0) * draw(st.sampled_from(SIZES))
    faces = random.integers(0, len(vertices), (draw(st.integers(1, 24)), 3))
    return vertices, faces[has_area(vertices[faces])]


@settings(deadline=None, max_examples=60)
@given(meshes(), st.sampled_from((0.5, 3.0, 200.0, 2000.0)))
def test_errors_hold_through_the_map(mesh: tuple[np.ndarray, np.ndarray], bound: float) -> None:
    vertices, faces = mesh
    if not len(faces):
        return
    found = simplify_object(vertices, faces, bound)
    assert 1 <= len(found.faces) <= len(faces)
    assert has_area(vertices[found.faces]).all()
    assert found.error <= bound + 2.0**-10
    coarse, fine = found.pairs.T
    assert set(coarse.tolist()) == set(range(len(found.faces)))
    assert set(fine.tolist()) == set(range(len(faces)))
    one, other = vertices[faces] * 1.0, vertices[found.faces] * 1.0
    for face in range(len(faces)):
        assert farthest(one[face], other[coarse[fine == face]], 10) <= found.error
    for face in range(len(found.faces)):
        assert farthest(other[face], one[fine[coarse == face]], 10) <= found.error


@settings(deadline=None, max_examples=20)
@given(meshes())
def test_the_same_mesh_gives_the_same_faces(mesh: tuple[np.ndarray, np.ndarray]) -> None:
    vertices, faces = mesh
    if not len(faces):
        return
    first, second = (simplify_object(vertices, faces, 200.0) for _ in range(2))
    assert np.array_equal(first.faces, second.faces)
    assert np.array_equal(first.pairs, second.pairs)
    assert first.error == second.error
