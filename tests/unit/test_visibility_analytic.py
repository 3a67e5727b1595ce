"""Scenes whose answer is known by reasoning."""

import numpy as np
import pytest

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.scene.analytic import SCENES
from tilesnav_ref.visibility import VisibilitySettings, compute_pvs


def table_of(case, work):
    none = np.zeros(0, np.int64)
    cells = CellComplex(
        case.cell_lower[None], case.cell_upper[None], np.zeros(1, np.uint8), np.zeros(2, np.int64),
        none, none, 0, 1.0,
    )  # fmt: skip
    return compute_pvs(case.scene, cells, work)


@pytest.mark.parametrize("name", SCENES)
def test_visible_faces_are_listed_and_hidden_ones_are_never_proven_visible(name):
    case = SCENES[name]()
    table = table_of(case, VisibilitySettings(rays=2000))
    listed = set(table.faces_of(0).tolist())
    assert case.visible <= listed
    assert not case.hidden & set(table.faces_of(0)[table.pvs_proven].tolist())


@pytest.mark.parametrize("name", SCENES)
def test_hidden_faces_are_proved_hidden(name):
    case = SCENES[name]()
    table = table_of(case, VisibilitySettings(rays=2000, attempts=8192, depth=24))
    assert not case.hidden & set(table.faces_of(0).tolist())


@pytest.mark.parametrize("name", SCENES)
def test_no_work_at_all_lists_everything_that_is_visible(name):
    case = SCENES[name]()
    table = table_of(case, VisibilitySettings(rays=1, attempts=1, depth=0, leaf_segments=0, occluder_faces=1))
    assert case.visible <= set(table.faces_of(0).tolist())
