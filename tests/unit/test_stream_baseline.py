"""Ordinary streaming: which tiles are shown, by the definition of the screen-space error."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tilesnav_ref.stream.bandwidth import Series
from tilesnav_ref.stream.baseline import ScreenSettings, follow, range_selection, screen_selection
from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.tiles import TileTree, read_tiles

CAMERA = ScreenSettings()


def box(x: float, y: float, z: float, half: float) -> dict[str, Any]:
    return {"box": [x, y, z, half, 0, 0, 0, half, 0, 0, 0, half]}


def content(number: int, level: int) -> dict[str, Any]:
    extension = {"contentId": number, "level": level}
    return {"content": {"uri": f"{number}-{level}.glb", "extensions": {"3DTILES_nav": extension}}}


def chain(number: int, x: float, errors: tuple[float, ...]) -> dict[str, Any]:
    """A tile of a coarse level around finer ones; errors fall."""
    tile: dict[str, Any] = {
        "boundingVolume": box(x, 0, 0, 5),
        "geometricError": errors[0],
        **content(number, len(errors) - 1),
    }
    if len(errors) > 1:
        tile |= {"refine": "replace", "children": [chain(number, x, errors[1:])]}
    return tile


def written(folder: Path, root: dict[str, Any]) -> Path:
    path = folder / "tileset.json"
    path.write_text(json.dumps({"asset": {"version": "1.1"}, "geometricError": 100, "root": root}))
    return path


def town(folder: Path, **members: Any) -> TileTree:
    """Two chains, 100 m apart, under a root that adds."""
    root = {
        "boundingVolume": box(50, 0, 0, 60),
        "geometricError": 100.0,
        "refine": "ADD",
        "children": [chain(0, 0.0, (2.0, 0.5, 0.0)), chain(1, 100.0, (1.0, 0.0))],
        **members,
    }
    return read_tiles(written(folder, root))


def shown(tree: TileTree, *point: float, settings: ScreenSettings = CAMERA) -> list[tuple[int, int]]:
    tiles = screen_selection(tree, np.array(point, np.float64), settings)
    return [(one.content_id, one.level) for tile in tiles for one in tree.contents[tile]]


def test_a_metre_at_a_metre_is_so_many_pixels() -> None:
    assert CAMERA.pixels == pytest.approx(540 / math.tan(math.pi / 6))
    assert ScreenSettings(16, 1000, 90).pixels == pytest.approx(500)


def test_the_level_follows_the_distance_of_the_box(tmp_path: Path) -> None:
    tree = town(tmp_path)
    # An error of e is 16 pixels at e * 935.3 / 16 = 58.46 e: 29.2 m for 0.5, 116.9 m for 2, 58.5 m for 1.
    assert shown(tree, 0, 0, 5 + 29.0) == [(0, 0), (1, 1)]
    assert shown(tree, 0, 0, 5 + 29.5) == [(0, 1), (1, 1)]
    assert shown(tree, 0, 0, 5 + 116.5) == [(0, 1), (1, 1)]
    assert shown(tree, 0, 0, 5 + 117.5) == [(0, 2), (1, 1)]
    assert shown(tree, 100, 0, 0) == [(0, 1), (1, 0)]
    assert shown(tree, 100 + 5 + 58, 0, 0)[1] == (1, 0)
    assert shown(tree, 100 + 5 + 59, 0, 0)[1] == (1, 1)


def test_more_pixels_allowed_show_less(tmp_path: Path) -> None:
    tree = town(tmp_path)
    assert shown(tree, 0, 0, 34, settings=ScreenSettings(maximum_error=64)) == [(0, 1), (1, 1)]
    assert shown(tree, 0, 0, 34, settings=ScreenSettings(maximum_error=0.01)) == [(0, 0), (1, 0)]


def test_transforms_move_boxes_and_scale_errors(tmp_path: Path) -> None:
    twice = [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 10, 0, 0, 1]
    tree = town(tmp_path, transform=twice)
    assert tree.errors.tolist() == [200.0, 4.0, 1.0, 0.0, 2.0, 0.0]
    assert tree.distances(np.array((10.0, 0.0, 17.0)))[1] == pytest.approx(7.0)
    assert tree.distances(np.array((10.0, 0.0, 9.0)))[1] == 0.0


def test_adding_tiles_stay_beside_their_children_and_refinement_is_inherited(tmp_path: Path) -> None:
    inner = {"boundingVolume": box(0, 0, 0, 5), "geometricError": 1.0, **content(1, 1)}
    leaf = {"boundingVolume": box(0, 0, 0, 5), "geometricError": 0.0, **content(2, 0)}
    root = {"boundingVolume": box(0, 0, 0, 5), "geometricError": 9.0, **content(0, 2)}
    added = {**root, "refine": "ADD", "children": [{**inner, "children": [leaf]}]}
    assert shown(read_tiles(written(tmp_path, added)), 0, 0, 0) == [(0, 2), (1, 1), (2, 0)]
    replaced = {**added, "refine": "REPLACE"}
    assert shown(read_tiles(written(tmp_path, replaced)), 0, 0, 0) == [(2, 0)]
    # A leaf has nothing to be replaced by, however large its error is.
    assert shown(read_tiles(written(tmp_path, {**root})), 0, 0, 0) == [(0, 2)]


@given(st.lists(st.floats(-150, 150), min_size=3, max_size=3), st.floats(0.5, 64))
def test_every_object_is_shown_once_at_the_level_that_the_definition_names(
    tmp_path_factory: pytest.TempPathFactory, values: list[float], pixels: float
) -> None:
    tree = town(tmp_path_factory.mktemp("tree"))
    settings = ScreenSettings(maximum_error=pixels)
    found = dict(shown(tree, *values, settings=settings))
    for number, x, errors in ((0, 0.0, (2.0, 0.5, 0.0)), (1, 100.0, (1.0, 0.0))):
        away = np.linalg.norm(np.maximum(np.abs(np.array(values) - (x, 0, 0)) - 5, 0))
        # The first of the chain, from coarse to fine, whose error is small enough from there; the last is 0.
        allowed = pixels * away / CAMERA.pixels
        place = next(k for k, error in enumerate(errors) if error <= allowed or error == 0.0)
        assert found[number] == len(errors) - 1 - place


def test_everything_within_range_is_of_the_finest_level(tmp_path: Path) -> None:
    tree = town(tmp_path)
    chosen = [tree.contents[tile] for tile in range_selection(tree, np.array((0.0, 0, 0)), 94.0)]
    assert [(one.content_id, one.level) for (one,) in chosen] == [(0, 0)]
    chosen = [tree.contents[tile] for tile in range_selection(tree, np.array((0.0, 0, 0)), 95.0)]
    assert [(one.content_id, one.level) for (one,) in chosen] == [(0, 0), (1, 0)]


@pytest.mark.parametrize(("forgets", "loads"), [(True, [2, 1, 1, 0]), (False, [2, 1, 0, 0])])
def test_what_is_not_held_is_loaded(tmp_path: Path, forgets: bool, loads: list[int]) -> None:
    tree = town(tmp_path)
    near, far = (
        screen_selection(tree, np.array((0.0, 0, 34.0)), CAMERA),
        screen_selection(tree, np.array((0.0, 0, 40.0)), CAMERA),
    )
    found = follow(tree, [near, far, near, near], forgets)
    assert [len(one) for one in found.loaded] == loads
    assert [len(one) for one in found.held] == ([2, 2, 2, 2] if forgets else [2, 3, 3, 3])


@pytest.mark.parametrize(
    ("root", "message"),
    [
        (
            {"boundingVolume": {"sphere": [0, 0, 0, 1]}, "geometricError": 1},
            r"root.boundingVolume.box: .*allowed: a box",
        ),
        ({"boundingVolume": box(0, 0, 0, 1)}, "geometricError: found nothing"),
    ],
)
def test_trees_that_cannot_be_followed_are_refused(
    tmp_path: Path, root: dict[str, Any], message: str
) -> None:
    with pytest.raises(TilesetError, match=message):
        read_tiles(written(tmp_path, root))


def test_trees_too_deep_are_refused(tmp_path: Path) -> None:
    tile: dict[str, Any] = {"boundingVolume": box(0, 0, 0, 1), "geometricError": 0}
    for _ in range(64):
        tile = {"boundingVolume": box(0, 0, 0, 1), "geometricError": 0, "children": [tile]}
    with pytest.raises(TilesetError, match="more than 64 levels"):
        read_tiles(written(tmp_path, tile))


@pytest.mark.parametrize("values", [(0, 1080, 60), (16, 0, 60), (16, 1080, 180), (-1, 1080, 60)])
def test_cameras_that_see_nothing_are_refused(values: tuple[float, int, float]) -> None:
    with pytest.raises(ValueError, match="allowed: positive values"):
        ScreenSettings(*values)


def test_figures_of_a_series_by_hand() -> None:
    series = Series(
        np.array((0.0, 0.0, 0.5, 1.25, 4.0)),
        np.array((700, 300, 50, 70, 200)),
        np.array((1, 4, 8, 0, 2)),
        5.0,
    )
    assert (series.first, series.total) == (1000, 1320)
    assert series.mean == pytest.approx(320 / 5.0)
    assert series.peak == 200.0
    assert series.rates(np.array((0.0, 0.6, 1.25, 1.6, 2.5, 4.9, 5.0))).tolist() == [
        0,
        50,
        120,
        70,
        0,
        200,
        0,
    ]
    assert series.received(np.array((0.0, 0.5, 4.5))).tolist() == [1000, 1050, 1320]
    assert series.mean_held == pytest.approx((4 * 0.5 + 8 * 0.75 + 0 * 2.75 + 2 * 1.0) / 5.0)
    summary = series.summary(64.0)
    assert summary["bytes_per_metre"] == pytest.approx(5.0)
    assert summary["mean_kB_s"] == pytest.approx(0.064)
