"""Settings that no work can be done with are refused before any memory is taken."""

import pytest

from tilesnav_ref.commands.arguments import UsageError, parse
from tilesnav_ref.visibility.settings import VisibilitySettings


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("rays", -1),
        ("rays", 100_000_001),
        ("seed", -1),
        ("attempts", -1),
        ("depth", -1),
        ("depth", 1001),
        ("occluder_faces", 0),
        ("block_cells", 0),
    ],
)
def test_a_value_out_of_range_is_named(name, value):
    with pytest.raises(ValueError, match=f"{name}: found {value}; allowed"):
        VisibilitySettings(**{name: value})


def test_the_ends_of_the_ranges_are_allowed():
    nothing = {"rays": 0, "seed": 0, "attempts": 0, "depth": 0, "leaf_segments": 0}
    least = VisibilitySettings(**nothing, occluder_faces=1, block_cells=1)
    most = VisibilitySettings(rays=100_000_000, depth=1000)
    assert (least.rays, least.depth, least.occluder_faces, least.block_cells) == (0, 0, 1, 1)
    assert (most.rays, most.depth) == (100_000_000, 1000)


@pytest.mark.parametrize("option", [("--depth", "1001"), ("--rays", "100000001")])
def test_the_command_refuses_the_same(option):
    with pytest.raises(UsageError, match=f"{option[0]}: found {option[1]}; allowed"):
        parse(["encode", "scene.ply", "out", *option])
