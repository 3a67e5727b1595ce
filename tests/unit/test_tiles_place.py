"""Where a tileset is on Earth, to better than a millimetre, by formulas of the test's own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tileset_fixture import (
    TRIANGLE,
    Y_UP_TO_Z_UP,
    A,
    B,
    axes,
    b3dm,
    earth_transform,
    ecef,
    glb,
    model,
    moved,
    tile,
    tileset,
    write,
)

from tilesnav_ref.scene import Scene, SceneError, SceneSettings, load_scene
from tilesnav_ref.scene.tiles.place import near_earth

PLACES = [
    (4.9, 52.4, 40.0),
    (-75.5, 39.15, -8.0),
    (151.2, -33.9, 60.0),
    (179.9999, 0.0, 0.0),
    (10.0, 89.0, 5.0),
]
HALF_STEP = np.sqrt(3) / 2 / 1024
"""Metres: the most that snapping to the grid moves a vertex; less than a millimetre."""
HOUSE = np.array(((-30, 5, 12), (41, 2, -9), (3, 20, 33), (0, -4, 0)), float)
"""Corners in the axes of glTF: x east, y up, z south."""
FACES = [[0, 1, 2], [0, 3, 1]]


def on_earth(scene: Scene) -> np.ndarray:
    """(V, 3) where the output says that its vertices are, in order."""
    nav = scene.vertices * scene.step
    found = nav @ scene.tileset_from_nav[:3, :3].T + scene.tileset_from_nav[:3, 3]
    return found[np.lexsort(np.round(found, 1).T)]


def ordered(positions: np.ndarray) -> np.ndarray:
    return positions[np.lexsort(np.round(positions, 1).T)]


def load(folder: Path, root: dict[str, Any], content: bytes, **settings: Any) -> tuple[Scene, Any]:
    name = root["content"]["uri"]
    path = write(folder, {"tileset.json": tileset(root), name: content})
    return load_scene(path, SceneSettings(**settings))


@pytest.mark.parametrize("place", PLACES)
def test_tiles_with_a_transform(place: tuple[float, float, float], tmp_path: Path) -> None:
    root = tile("a.glb", transform=earth_transform(*place))
    scene, _ = load(tmp_path, root, glb(*model(HOUSE, FACES)))
    enu = HOUSE @ Y_UP_TO_Z_UP.T
    expected = ecef(*place) + enu @ axes(*place[:2])
    assert np.abs(on_earth(scene) - ordered(expected)).max() < HALF_STEP
    # the nav frame is upright there, and near: heights are those above the tile's ground but for a shift
    heights = np.sort(scene.vertices[:, 2] * scene.step)
    assert np.diff(heights) == pytest.approx(np.diff(np.sort(enu[:, 2])), abs=0.005)
    assert np.abs(scene.vertices * scene.step).max() < 60


def test_frame_by_hand_where_the_axes_are_plain(tmp_path: Path) -> None:
    """On the equator at longitude zero up is x, east is y and north is z."""
    root = tile("a.b3dm", transform=moved(A + 100, 0, 0))
    content = b3dm(glb(*model(HOUSE, FACES)), {"BATCH_LENGTH": 0, "RTC_CENTER": [0, 7, 0]})
    scene, report = load(tmp_path, root, content, crs="EPSG:4978", origin=(0.0, 0.0, 0.0))
    turned = np.array([(y, z, x) for x, y, z in HOUSE @ Y_UP_TO_Z_UP.T + (A + 100, 7, 0)]) - (0, 0, A)
    nav = scene.vertices * scene.step
    assert np.abs(ordered(nav) - ordered(turned)).max() < HALF_STEP
    assert np.array_equal(scene.tileset_from_nav, [[0, 0, 1, A], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    assert report.up == "z"


def test_positions_far_from_the_origin_in_the_content_itself(tmp_path: Path) -> None:
    """CESIUM_RTC and a node in float64 keep millimetres that float32 positions could not."""
    place = (11.57, 48.14, 560.0)
    base = ecef(*place)
    center = np.round(base)
    enu = HOUSE @ Y_UP_TO_Z_UP.T
    relative = base - center + enu @ axes(*place[:2])
    document, binary = model(
        relative @ Y_UP_TO_Z_UP, FACES, extensions={"CESIUM_RTC": {"center": center.tolist()}}
    )
    scene, _ = load(tmp_path / "rtc", tile("a.glb"), glb(document, binary))
    expected = ordered(center + np.float64(np.float32(relative)))
    assert np.abs(on_earth(scene) - expected).max() < HALF_STEP
    move = {"translation": (center @ Y_UP_TO_Z_UP).tolist()}
    scene, _ = load(tmp_path / "node", tile("a.glb"), glb(*model(relative @ Y_UP_TO_Z_UP, FACES, node=move)))
    assert np.abs(on_earth(scene) - expected).max() < HALF_STEP


def test_local_tilesets_stay_where_they_are(tmp_path: Path) -> None:
    root = tile("a.glb", transform=moved(499946.281, 6783362.155, 87.4))  # web Mercator metres
    scene, report = load(tmp_path, root, glb(*model(HOUSE, FACES)))
    expected = HOUSE @ Y_UP_TO_Z_UP.T + (499946.281, 6783362.155, 87.4)
    assert np.abs(on_earth(scene) - ordered(expected)).max() < HALF_STEP
    assert np.array_equal(scene.tileset_from_nav[:3, :3], np.eye(3))
    assert scene.tileset_from_nav[:3, 3].tolist() == [499952.0, 6783350.0, 83.0]
    assert "taken as local metres, z up; nav frame around x 499952.000" in report.notes[0]


def test_the_zero_of_a_local_tileset_may_be_set(tmp_path: Path) -> None:
    root = tile("a.glb", transform=moved(10, 20, 30))
    scene, _ = load(tmp_path, root, glb(*model()), origin=(10.0, 20.0, 30.0))
    expected = ordered(TRIANGLE @ Y_UP_TO_Z_UP.T)
    assert np.array_equal(ordered(scene.vertices * scene.step), expected)
    assert np.array_equal(on_earth(scene), expected + np.array((10, 20, 30)))


def test_a_local_tileset_whose_place_is_said(tmp_path: Path) -> None:
    scene, _ = load(tmp_path, tile("a.glb"), glb(*model(HOUSE, FACES)), crs="enu", origin=(4.9, 52.4, 40.0))
    expected = ecef(4.9, 52.4, 40.0) + HOUSE @ Y_UP_TO_Z_UP.T @ axes(4.9, 52.4)
    assert np.abs(on_earth(scene) - ordered(expected)).max() < HALF_STEP


def test_positions_of_which_some_are_on_earth(tmp_path: Path) -> None:
    vertices = [[A, 0, 0], [A, 0, 9], [0, 0, 0]]
    with pytest.raises(
        SceneError, match="positions: found 2 of 3 within 20000 m of the ellipsoid; allowed: all"
    ):
        load(tmp_path, tile("a.glb"), glb(*model(vertices)))


def test_what_is_near_the_earth() -> None:
    points = [
        ecef(lon, lat, h) for lon in (0, 123) for lat in (-90, -30, 0, 45.3, 90) for h in (-500, 0, 9000)
    ]
    assert near_earth(np.array(points)).all()
    away = [(0, 0, 0), (A + 21_000, 0, 0), (0, 0, B - 21_000), (499946.0, 6783362.0, 87.0), (0, 0, A + 2_000)]
    assert not near_earth(np.array(away, float)).any()


def test_a_region_is_in_the_nav_frame_and_volumes_are_not_believed(tmp_path: Path) -> None:
    """The declared volumes lie 100 km off; what counts is where the content is."""
    near, far = moved(0, 0), moved(300, 0)
    root = tile(transform=earth_transform(4.9, 52.4, 0.0))
    root["children"] = [tile("a.glb", transform=near), tile("b.glb", transform=far)]
    files = {"tileset.json": tileset(root), "a.glb": glb(*model()), "b.glb": glb(*model())}
    path = write(tmp_path, files)
    settings = SceneSettings(region=(100.0, -50.0, 200.0, 50.0))
    scene, report = load_scene(path, settings)
    assert (scene.face_count, report.cropped_faces) == (1, 1)
    expected = ecef(4.9, 52.4, 0.0) + (TRIANGLE @ Y_UP_TO_Z_UP.T + (300, 0, 0)) @ axes(4.9, 52.4)
    assert np.abs(on_earth(scene) - ordered(expected)).max() < HALF_STEP


def test_the_zero_is_at_the_middle_of_a_large_town(tmp_path: Path) -> None:
    """A town of 12 km in the shape of a triangle: all of it has to be within 8,192 m of the zero."""
    far = np.array(((-6000, 0, 7800), (6000, 0, 7800), (-6000, 20, -7800)), float)
    root = tile("a.glb", transform=earth_transform(-75.5, 39.15, 0.0))
    scene, _ = load(tmp_path, root, glb(*model(far)))
    nav = scene.vertices * scene.step
    middle = (nav.min(axis=0) + nav.max(axis=0)) / 2
    assert np.abs(middle[:2]).max() < 1.0  # the plan itself is bent by a few centimetres
    assert nav[:, 2].min() == pytest.approx(0.0, abs=0.01)
    expected = ecef(-75.5, 39.15, 0.0) + far @ Y_UP_TO_Z_UP.T @ axes(-75.5, 39.15)
    assert np.abs(on_earth(scene) - ordered(expected)).max() < HALF_STEP
