"""Patches and sheets: what belongs together, and the edges between."""

import numpy as np
import pytest
from visibility_reference import make_flagged, make_scene

from tilesnav_ref.scene.sample import TownSettings, make_town
from tilesnav_ref.visibility.geometry import FineFrame, build_geometry
from tilesnav_ref.visibility.patches import LARGEST
from tilesnav_ref.visibility.units import Units, divide, is_fine

FRAME = FineFrame(np.zeros(3, np.int64), 64)


def quad(a, b, c, d):
    return [[a, b, c], [a, c, d]]


def box(low, high):
    (x, y, z), (u, v, w) = low, high
    return [
        *quad((x, y, z), (x, v, z), (x, v, w), (x, y, w)),
        *quad((x, y, z), (u, y, z), (u, y, w), (x, y, w)),
        *quad((x, v, z), (u, v, z), (u, v, w), (x, v, w)),
        *quad((x, y, z), (u, y, z), (u, v, z), (x, v, z)),
        *quad((x, y, w), (u, y, w), (u, v, w), (x, v, w)),
        *quad((u, y, z), (u, v, z), (u, v, w), (u, y, w)),
    ]


def window(y, z):
    """A square of 12 of a wall at x = 0 with a pane set back by 1 in the middle."""
    out = [(0, y, z), (0, y + 12, z), (0, y + 12, z + 12), (0, y, z + 12)]
    rim = [(0, y + 3, z + 3), (0, y + 9, z + 3), (0, y + 9, z + 9), (0, y + 3, z + 9)]
    pane = [(1, p[1], p[2]) for p in rim]
    found = quad(*pane)
    for k in range(4):
        j = (k + 1) % 4
        found += quad(out[k], out[j], rim[j], rim[k]) + quad(rim[k], rim[j], pane[j], pane[k])
    return found


def division_of(scene):
    return divide(build_geometry(scene, FRAME), scene.faces)


def test_a_front_with_its_windows_is_one_patch():
    front = [t for y in (0, 12, 24) for z in (0, 12) for t in window(y, z)]
    patches = division_of(make_scene(front)).patches
    assert set(patches.of_face.tolist()) == {0}
    assert len(patches.border) == 10  # the outline: 3 + 3 edges along y, 2 + 2 along z


@pytest.mark.parametrize("turned", [False, True])
def test_the_sides_of_a_box_are_patches_whatever_the_order_of_corners(turned):
    triangles = box((0, 0, 0), (8, 6, 4))
    if turned:
        triangles = [t[::-1] if i % 3 == 0 else t for i, t in enumerate(triangles)]
    division = division_of(make_scene(triangles))
    assert division.patches.of_face.tolist() == [i // 2 for i in range(12)]
    assert set(division.sheets.of_face.tolist()) == {0}
    assert len(division.sheets.border) == 0


def test_boxes_that_share_an_edge_are_two_sheets_with_that_edge_for_a_border():
    division = division_of(make_scene(box((0, 0, 0), (4, 4, 4)) + box((4, 4, 0), (8, 8, 4))))
    sheets = division.sheets
    assert sheets.of_face.tolist() == [0] * 12 + [1] * 12
    assert np.diff(sheets.border_offsets).tolist() == [0, 0]  # two faces of each have the edge
    assert sheets.lower.tolist() == [[0, 0, 0], [256, 256, 0]]
    assert sheets.upper.tolist() == [[256, 256, 256], [512, 512, 256]]


def test_porous_faces_are_alone():
    triangles = box((0, 0, 0), (8, 6, 4))
    division = division_of(make_flagged(triangles, (0, 1)))
    for units in (division.patches, division.sheets):
        assert np.count_nonzero(units.of_face == units.of_face[0]) == 1
        assert np.count_nonzero(units.of_face == units.of_face[1]) == 1
    assert len(division.sheets.border) == 3 + 3 + 4  # of the two porous faces, and of the hole they leave


def faces_and_borders(units: Units, face_edges):
    for unit in range(len(units.offsets) - 1):
        faces = units.faces[units.offsets[unit] : units.offsets[unit + 1]]
        numbers, times = np.unique(face_edges[faces], return_counts=True)
        border = units.border[units.border_offsets[unit] : units.border_offsets[unit + 1]]
        yield faces, numbers[times % 2 == 1], border


def test_units_of_a_town_hold_every_face_once_and_have_the_odd_edges_for_borders():
    scene = make_town(TownSettings(detail="fine", width=25, depth=25))
    geometry = build_geometry(scene, FRAME)
    division = divide(geometry, scene.faces)
    assert is_fine(division)
    for units in (division.single, division.patches, division.sheets):
        assert sorted(units.faces.tolist()) == list(range(scene.face_count))
        for faces, odd, border in faces_and_borders(units, geometry.face_edges):
            assert border.tolist() == odd.tolist()
            assert len(set(units.of_face[faces].tolist())) == 1
    assert np.diff(division.patches.offsets).max() <= LARGEST
    assert (division.sheets.of_face[division.patches.faces[division.patches.offsets[:-1]]] >= 0).all()
