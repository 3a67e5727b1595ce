"""What is delivered in a cell, beside the plain definition."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from delivery_fixture import Parts, Sizes, edit_json, plain_held, random_map, written
from test_tileset_coarse import coarse_map
from test_tileset_small_map import small_map

from tilesnav_ref.packet.model import ObjectFaces
from tilesnav_ref.stream.delivery import Delivery
from tilesnav_ref.stream.errors import TilesetError
from tilesnav_ref.stream.levels import smallest_first
from tilesnav_ref.stream.policy import LevelPolicy
from tilesnav_ref.stream.reader import open_tileset
from tilesnav_ref.tileset.model import NavMap

SEEDS = range(12)


def as_lists(parts: tuple[ObjectFaces, ...]) -> Parts:
    for part in parts:
        assert (part.faces.dtype, part.corners.dtype) == (np.uint32, np.int32)
    return [(p.object, p.level, p.flags, p.faces.tolist(), p.corners.tolist()) for p in parts]


def auto_levels(one: NavMap, cell: int, resolution: float) -> dict[int, int]:
    """Place of the level of each object, by the rule: the coarsest with e * reference / base^k <= tau."""
    first, last = one.lod.lod_offsets[cell], one.lod.lod_offsets[cell + 1]
    chosen = {}
    for number, code in zip(one.lod.lod_objects[first:last], one.lod.lod_codes[first:last], strict=True):
        fits = [0]
        for place, level in enumerate(one.coarse, start=1):
            if code > 0 and level.errors[number] * 1.0 / 2.0 ** int(code) <= resolution:
                fits.append(place)
        chosen[int(number)] = max(fits)
    return chosen


@pytest.mark.parametrize("seed", SEEDS)
def test_held_is_what_the_definition_says(tmp_path: Path, seed: int) -> None:
    one = random_map(seed, levels=(1, 3) if seed % 2 else (1, 2))
    delivery = Delivery(written(tmp_path / "out", one))
    everything = range(one.scene.object_count)
    resolution = 0.1
    for cell in range(one.cells.count):
        expected = {
            "fine": dict.fromkeys(everything, 0),
            "coarse": dict.fromkeys(everything, 2),
            "auto": auto_levels(one, cell, resolution),
        }
        for name, chosen in expected.items():
            held = delivery.held(cell, LevelPolicy(name, resolution))
            assert as_lists(held) == plain_held(one, cell, chosen)


def test_random_maps_take_every_level() -> None:
    """The test above would be empty if the rule always gave the same."""
    chosen = [
        level for seed in SEEDS for level in auto_levels(random_map(seed), 2, 0.1).values() if seed % 2 == 0
    ]
    assert set(chosen) == {0, 1, 2}


def test_without_coarse_levels_everything_is_of_level_0(tmp_path: Path) -> None:
    one = small_map()
    one = replace(one, scene=replace(one.scene, object_porous=np.array([0, 1, 0], bool)))
    one = replace(one, scene=replace(one.scene, object_one_sided=np.array([0, 1, 1], bool)))
    delivery = Delivery(written(tmp_path, one))
    for name in ("fine", "coarse", "auto"):
        held = delivery.held(1, LevelPolicy(name))
        assert [(p.object, p.level, p.flags, p.faces.tolist()) for p in held] == [
            (0, 0, 0, [0]),
            (1, 0, 3, [0, 1]),
            (2, 0, 2, [0]),
        ]
    assert held[2].corners.tolist() == [[[0, -1024, 5120], [8192, -1024, 5120], [4096, 3072, 6144]]]


def test_contents_of_a_level_may_lie_in_another_order(tmp_path: Path) -> None:
    """A coarse content 0 that stands for the last objects: what is delivered is the same."""
    one = random_map(5)
    delivery = Delivery(written(tmp_path, one))
    before = [as_lists(delivery.held(cell, LevelPolicy("coarse"))) for cell in range(3)]

    def swap(document: dict) -> None:
        for child in document["root"]["children"]:
            facts = child["content"]["extensions"]["3DTILES_nav"]
            facts["contentId"] = 1 - facts["contentId"]

    edit_json(tmp_path / "tileset.json", swap)
    tileset = open_tileset(tmp_path)
    assert tileset.coarse[2][0].path.name == "1-2.glb"
    after = [as_lists(Delivery(tileset).held(cell, LevelPolicy("coarse"))) for cell in range(3)]
    assert after == before
    assert before[2]
    assert np.array_equal(tileset.levels[1].errors, one.coarse[1].errors)


def test_a_content_for_viewers_only_is_no_level(tmp_path: Path) -> None:
    written(tmp_path, coarse_map())

    def strip(document: dict) -> None:
        for child in document["root"]["children"]:
            facts = child["content"]["extensions"]["3DTILES_nav"]
            del facts["faceMap"]
            facts["contentId"] = 7

    edit_json(tmp_path / "tileset.json", strip)
    tileset = open_tileset(tmp_path)
    assert [level.level for level in tileset.levels] == [1]
    assert {p.level for p in Delivery(tileset).held(1, LevelPolicy("coarse"))} == {1}


def test_levels_are_those_of_the_encoder(tmp_path: Path) -> None:
    one = coarse_map()
    tileset = written(tmp_path, one)
    assert [level.level for level in tileset.levels] == [1, 2]
    for found, made in zip(tileset.levels, one.coarse, strict=True):
        assert np.array_equal(found.errors, made.errors)
        assert np.array_equal(found.fine_faces.offsets, made.offsets)
        assert np.array_equal(found.fine_faces.values, made.fine_faces)
        assert np.array_equal(np.sort(found.geometry.corners, axis=1), np.sort(made.scene.corners(), axis=1))
        for face in range(one.scene.face_count):
            rows = [
                row for row in range(made.scene.face_count) if face in found.fine_faces.row(row).tolist()
            ]
            assert found.standing.row(face).tolist() == rows


def test_cells_that_are_not_there(tmp_path: Path) -> None:
    delivery = Delivery(written(tmp_path, small_map()))
    for cell in (-1, 3):
        with pytest.raises(IndexError, match=f"cell {cell}"):
            delivery.held(cell, LevelPolicy())


def test_objects_that_do_not_match_the_faces(tmp_path: Path) -> None:
    one = small_map()
    objects = one.lod.lod_objects.copy()
    objects[1] = 2
    (tmp_path / "a").mkdir()
    delivery = Delivery(written(tmp_path / "a", replace(one, lod=replace(one.lod, lod_objects=objects))))
    with pytest.raises(TilesetError, match="2 objects that do not match the faces of cell 0"):
        delivery.held(0, LevelPolicy("fine"))


def test_the_least_rotation_is_taken_and_the_turn_stays() -> None:
    rng = np.random.default_rng(3)
    corners = rng.integers(-3, 3, (500, 3, 3)).astype(np.int32)
    corners[:9] *= (1 << 23) - 1
    corners[5:9, 1] = corners[5:9, 0]
    corners = np.clip(corners, 1 - (1 << 23), (1 << 23) - 1).astype(np.int32)
    for before, after in zip(corners.tolist(), smallest_first(corners).tolist(), strict=True):
        assert after == min(before[k:] + before[:k] for k in range(3))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"name": "median"}, "setting policy: found 'median'; allowed: fine, coarse, auto"),
        ({"resolution": 0.0}, "setting resolution: found 0.0"),
        ({"resolution": math.nan}, "setting resolution: found nan"),
    ],
)
def test_bad_policies(settings: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        LevelPolicy(**settings)


def test_code_0_is_without_an_upper_end(tmp_path: Path) -> None:
    """However large the angle is, an object of code 0 comes in level 0: its L may be any."""
    one = random_map(1, Sizes(3, 5))
    one = replace(one, lod=replace(one.lod, lod_codes=np.zeros_like(one.lod.lod_codes)))
    errors = tuple(replace(level, errors=np.zeros_like(level.errors)) for level in one.coarse)
    for chosen in (one, replace(one, coarse=errors)):
        (tmp_path / str(chosen is one)).mkdir()
        held = Delivery(written(tmp_path / str(chosen is one), chosen)).held(2, LevelPolicy(resolution=1e9))
        assert {p.level for p in held} == {0}


def test_an_angle_on_the_threshold_takes_the_coarser_level(tmp_path: Path) -> None:
    one = random_map(1, Sizes(3, 5))
    one = replace(one, lod=replace(one.lod, lod_codes=np.full_like(one.lod.lod_codes, 3)))
    one = replace(one, coarse=tuple(replace(x, errors=np.full_like(x.errors, x.level)) for x in one.coarse))
    delivery = Delivery(written(tmp_path, one))
    for resolution, level in ((0.124, 0), (0.125, 1), (0.249, 1), (0.25, 2)):
        assert {p.level for p in delivery.held(2, LevelPolicy(resolution=resolution))} == {level}
