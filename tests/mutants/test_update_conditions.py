"""Each condition under which a set is taken over, removed from a copy of the sources: a set becomes wrong."""

from pathlib import Path

import pytest
from test_visibility_conditions import answer_without, ask, copy_of_package

PROBES = Path(__file__).parent / "update_probes.py"

MUTANTS = {
    "the set lists no face that is gone": (
        "update/changes.py",
        "if not gone[faces].any():\n            sets[cell] = faces",
        "if True:\n            sets[cell] = faces[~gone[faces]]",
        "wall_is_removed",
    ),
    "new faces are hidden": (
        "update/changes.py",
        "Change(scene, added)",
        "Change(scene, added & False)",
        "box_is_added",
    ),
    "what is not decided is not hidden": (
        "visibility/unseen.py",
        "budget) != HIDDEN",
        "budget) < 0",
        "face_is_added_behind_a_hole",
    ),
    "backs of faces that are gone were hidden": (
        "update/changes.py",
        "Change(previous.scene, backs)",
        "Change(previous.scene, backs & False)",
        "one_sided_wall_is_removed",
    ),
    "hidden means from both sides": (
        "visibility/unseen.py",
        "replace(scene, object_one_sided=np.zeros(0, np.bool_))",
        "scene",
        "one_sided_wall_is_removed",
    ),
    "a face that turns porous is another face": (
        "update/matching.py",
        "np.stack([scene.porous, scene.one_sided], axis=1)",
        "np.stack([scene.one_sided, scene.one_sided], axis=1)",
        "wall_turns_porous",
    ),
    "a face that becomes two-sided is another face": (
        "update/matching.py",
        "np.stack([scene.porous, scene.one_sided], axis=1)",
        "np.stack([scene.porous, scene.porous], axis=1)",
        "wall_becomes_two_sided",
    ),
    "a one-sided face that is turned is another face": (
        "update/matching.py",
        "np.where(scene.one_sided[:, None], turned, order)",
        "order",
        "one_sided_wall_is_turned",
    ),
    "the copies of a face are counted": (
        "update/matching.py",
        "own * most + _ranks(own)",
        "own * most",
        "number_of_copies",
    ),
    "sets belong to their cells": (
        "update/matching.py",
        "np.ascontiguousarray(planes, np.float64)",
        "np.ascontiguousarray(planes * [[[1.0], [0.0]] * 3], np.float64)",
        "cell_grows",
    ),
    "faces have their new numbers": (
        "update/changes.py",
        "np.sort(new_number[faces])",
        "np.sort(faces)",
        "faces_are_renumbered",
    ),
}


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    return copy_of_package(tmp_path_factory.mktemp("update"))


def test_the_sources_answer_every_probe_rightly(copy):
    answers = ask(copy, PROBES)
    assert len(answers) >= 9
    assert all(answers.values()), answers


@pytest.mark.parametrize("condition", MUTANTS)
def test_without_the_condition_a_set_is_wrong(condition, copy):
    assert answer_without(MUTANTS[condition], copy, PROBES) is False
