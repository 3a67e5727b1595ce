"""Every option reaches the setting that it stands for."""

from __future__ import annotations

import pytest

from tilesnav_ref.cells import CellSettings
from tilesnav_ref.commands.arguments import UsageError, encode_settings, parse, town_settings
from tilesnav_ref.encode import EncodeSettings
from tilesnav_ref.scene.sample import TRAINING_SITE, TownSettings


def _settings(*options: str) -> EncodeSettings:
    return encode_settings(parse(["encode", "scene.ply", "out", *options]))


def test_nothing_given_keeps_every_default() -> None:
    assert _settings() == EncodeSettings()


OPTIONS = {
    "--units ft": ("scene", "units", "ft"),
    "--up y": ("scene", "up", "y"),
    "--crs EPSG:25832": ("scene", "crs", "EPSG:25832"),
    "--origin -1,2,3": ("scene", "origin", (-1.0, 2.0, 3.0)),
    "--grid -8": ("scene", "grid_exponent", -8),
    "--region -5,-6,7,8": ("scene", "region", (-5.0, -6.0, 7.0, 8.0)),
    "--region -5,-6,7,9": ("cells", "region", (-5.0, -6.0, 7.0, 9.0)),
    "--cells voxel": ("cells", "method", "voxel"),
    "--cells boxes": ("cells", "method", "boxes"),
    "--cell-price 8": ("cells", "cell_price", 8.0),
    "--min-cell 0.5": ("cells", "min_size", 0.5),
    "--max-cell 32": ("cells", "max_size", 32.0),
    "--voxel-size 3": ("cells", "voxel_size", 3.0),
    "--clearance 0": ("cells", "clearance", 0.0),
    "--altitude-min -2": ("cells", "altitude_min", -2.0),
    "--altitude-max 60": ("cells", "altitude_max", 60.0),
    "--keep-interiors": ("cells", "keep_interiors", True),
    "--seed-point 1,2,3 --seed-point -4,5,6": ("cells", "seeds", ((1.0, 2.0, 3.0), (-4.0, 5.0, 6.0))),
    "--seed 7": ("cells", "coverage_seed", 7),
    "--seed 8": ("visibility", "seed", 8),
    "--threads 3": ("visibility", "threads", 3),
    "--threads 4": ("cells", "threads", 4),
    "--rays 0": ("visibility", "rays", 0),
    "--transparent oak* --transparent f?nce": ("scene", "transparent", ("oak*", "f?nce")),
    "--one-sided *": ("scene", "one_sided", ("*",)),
    "--max-range 120.5": ("visibility", "max_range", 120.5),
    "--attempts 9": ("visibility", "attempts", 9),
    "--depth 5": ("visibility", "depth", 5),
    "--lod-reference 0.5": ("lod", "reference", 0.5),
    "--lod-base 1.5": ("lod", "base", 1.5),
    "--lod-levels 32": ("lod", "level_count", 32),
    "--sector-cells 10": ("tileset", "cells_per_sector", 10),
}


@pytest.mark.parametrize("options", OPTIONS)
def test_option(options: str) -> None:
    stage, name, value = OPTIONS[options]
    assert getattr(getattr(_settings(*options.split()), stage), name) == value


def test_one_option_leaves_other_stages_alone() -> None:
    changed = _settings("--max-cell", "4")
    assert changed.cells == CellSettings(max_size=4.0)
    assert (changed.scene, changed.visibility) == (EncodeSettings().scene, EncodeSettings().visibility)


def test_settings_that_a_stage_refuses_are_usage() -> None:
    with pytest.raises(UsageError, match="max_size"):
        _settings("--max-cell", "1", "--min-cell", "2")


def test_a_range_of_nothing_is_usage() -> None:
    with pytest.raises(UsageError, match="max_range"):
        _settings("--max-range", "0")


@pytest.mark.parametrize("options", [("--one-sided", "*"), ("--max-range", "9")])
def test_certificates_do_not_go_with_what_leaves_faces_out_without_one(options: tuple[str, ...]) -> None:
    with pytest.raises(UsageError, match="certificates"):
        _settings("--certificates", *options)
    assert _settings("--certificates", "--transparent", "tree*").visibility.certificates


def test_town() -> None:
    assert town_settings(parse(["sample", "t.ply"])) == TownSettings()
    given = parse(["sample", "t.ply", "--size", "full", "--detail", "fine", "--seed", "0"])
    assert town_settings(given) == TRAINING_SITE
    assert town_settings(parse(["sample", "t.ply", "--terrain"])).sloped
