"""Each condition under which a sheet hides its own faces, removed: a probe must become unsound."""

from pathlib import Path

import pytest
from test_visibility_conditions import answer_without, ask, copy_of_package

PROBES = Path(__file__).parent / "sheet_probes.py"

MUTANTS = {
    "the border of the sheet clears the shaft": (
        "visibility/backs.py",
        "        if not clears_edge(shaft, (ends",
        "        if False and not clears_edge(shaft, (ends",
        "back_of_a_house_with_a_hole",
    ),
    "the sheet keeps off the region": (
        "visibility/backs.py",
        "states[sheet] = BLOCKED",
        "states[sheet] = OPEN",
        "house_inside_the_region",
    ),
    "what is known of sheets holds for one region": (
        "visibility/backs.py",
        "if not np.array_equal(known, region):",
        "if not known.any():",
        "house_inside_the_next_region",
    ),
    "the region is on one side of the target": (
        "visibility/backs.py",
        "if side == 0 or work.shaft.counts[2] != side:",
        "if side == 0:",
        "roof_whose_plane_cuts_the_cell",
    ),
    "no other face of the sheet meets the target": (
        "visibility/backs.py",
        "not _is_clean(geometry, division.sheets, face)",
        "False",
        "plate_through_the_front",
    ),
    "the segment crosses the sheet an odd number of times": (
        "visibility/backs.py",
        "return number % 2 == 1",
        "return True",
        "wall_below_a_canopy",
    ),
    "the segment is in general position with the sheet": (
        "visibility/backs.py",
        "            return -1",
        "            continue",
        "sheet_left_by_an_edge",
    ),
    "edges between patches clear the shaft": (
        "visibility/occluder.py",
        "if not flood.edge_odd[edge] or _clears(surface, shaft, flood, edge):",
        "if True:",
        "fine_wall_that_is_too_low",
    ),
    "patches are tried where walls are fine": (
        "visibility/certify.py",
        "range(0 if work.with_patches else 1, 2)",
        "range(1, 2)",
        "fine_wall_that_hides",
    ),
}


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    return copy_of_package(tmp_path_factory.mktemp("sources"))


def test_the_sources_answer_every_probe_soundly(sources):
    answers = ask(sources, PROBES)
    assert answers
    assert all(answers.values()), answers


@pytest.mark.parametrize("condition", MUTANTS)
def test_without_the_condition_a_probe_becomes_unsound(condition, sources):
    assert answer_without(MUTANTS[condition], sources, PROBES) is False
