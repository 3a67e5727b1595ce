"""A house of a real old town is removed, and built again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from update_reference import previous_of, proven_of, sets_of
from visibility_reference import make_scene

from tilesnav_ref.cells import CellSettings, decompose
from tilesnav_ref.scene import Scene, SceneSettings, load_scene
from tilesnav_ref.update import find_changes
from tilesnav_ref.visibility import VisibilitySettings, compute_pvs

MUNICH = Path(__file__).resolve().parents[3] / "shared" / "data" / "munich_mesh" / "munich.ply"
REGION = (60.0, 20.0, 150.0, 110.0)
WORK = VisibilitySettings(rays=2000, attempts=32, threads=1)
CELLS = CellSettings(region=REGION, altitude_max=8.0, min_size=4.0, coverage_points=1000, method="boxes")
HOUSE = (128.0, 44.0, 135.0, 55.0)
"""Its box, m: 7 m x 10 m, 7 m high, beside larger ones."""


def without_house(scene: Scene) -> Scene:
    corners = scene.corners() * scene.step
    inside = np.all((corners[:, :, :2] >= HOUSE[:2]) & (corners[:, :, :2] <= HOUSE[2:]), axis=(1, 2))
    assert 10 <= inside.sum() <= 20
    return make_scene(scene.corners()[~inside])


@pytest.mark.realdata
@pytest.mark.jit
@pytest.mark.skipif(not MUNICH.exists(), reason=f"{MUNICH} is not there")
def test_a_house_is_removed_and_built_again() -> None:
    loaded, _ = load_scene(MUNICH, SceneSettings(region=REGION))
    town, rest = make_scene(loaded.corners()), without_house(loaded)
    maps = {}
    for name, scene in (("town", town), ("rest", rest)):
        cells = decompose(scene, CELLS)
        maps[name] = (scene, cells, compute_pvs(scene, cells, WORK))
    for before, after in (("town", "rest"), ("rest", "town")):
        scene, cells, full = maps[after]
        found = find_changes(previous_of(*maps[before]), scene, cells, WORK)
        assert cells.count / 4 < len(found.kept) < cells.count
        table = found.merge(compute_pvs(scene, found.todo, WORK))
        pairs = zip(sets_of(table), proven_of(full), sets_of(full), proven_of(table), strict=True)
        for updated, visible, listed, flagged in pairs:
            assert visible <= updated
            assert flagged <= listed
        assert np.all(table.proven_counts <= np.diff(full.pvs_offsets))
        # What the two differ in is hidden and was not decided by one of them.
        assert len(table.pvs_faces) == pytest.approx(len(full.pvs_faces), rel=0.01)
        assert table.proven_counts.sum() > 0.9 * full.proven_counts.sum()
