"""Each condition of the parity theorem, removed from a copy of the sources: a probe must become unsound."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import tilesnav_ref

PACKAGE = Path(tilesnav_ref.__file__).parent
PROBES = Path(__file__).parent / "visibility_probes.py"

MUTANTS = {
    "edges of the occluder clear the shaft": (
        "visibility/occluder.py",
        "if not flood.edge_odd[edge] or _clears(surface, shaft, flood, edge):",
        "if True:",
        "wall_with_a_gap",
    ),
    "one weak sign at all corners of the shaft": (
        "visibility/shaft.py",
        "            if least < 0 and most > 0:\n                return False\n    return True",
        "    return True",
        "wall_with_a_gap",
    ),
    "the occluder keeps off the target face": (
        "visibility/occluder.py",
        "elif face != obstacle.face and meets_relative_interior(surface.corners, face, obstacle.face):",
        "elif False:",
        "wall_that_pierces",
    ),
    "the occluder keeps off the target box": (
        "visibility/occluder.py",
        "if meets_box(surface.corners, face, obstacle.box):",
        "if False:",
        "box_behind_a_wall_it_touches",
    ),
    "the occluder keeps off the cell": (
        "visibility/occluder.py",
        "meets_prism(surface.corners, units.faces[k], obstacle.cell)",
        "False",
        "wall_between_two_cells",
    ),
    "the segment is in general position": (
        "visibility/occluder.py",
        "for i in range(crossed.counts[2]):",
        "for i in range(0):",
        "closed_solid_through_its_edge",
    ),
    "a ray only suggests": (
        "visibility/lines.py",
        "seen[face] == 0 and sees(geometry, point, target, face):",
        "seen[face] == 0:",
        "suggestion_behind_a_wall",
    ),
    "the occluder is opaque": (
        "visibility/occluder.py",
        "if surface.porous[units.faces[first]]:",
        "if False:",
        "opaque_wall_that_goes_on_porous",
    ),
    "a one-sided face is proven from its front": (
        "visibility/sight.py",
        "corner(corners, face, 2), c) > 0",
        "corner(corners, face, 2), c) != 9",
        "one_sided_face_from_behind",
    ),
    "what has a point of the cell before its front is not left out": (
        "visibility/limits.py",
        "behind = behind and orientation(p, q, r, (prism[i, 0], prism[i, 1], prism[i, 2])) <= 0",
        "behind = behind and orientation(p, q, r, (prism[i, 0], prism[i, 1], prism[i, 2])) <= 1",
        "one_sided_face_across_the_cell",
    ),
    "a segment that proves is within the range": (
        "visibility/sight.py",
        "if x * x + y * y + z * z > geometry.near * geometry.near:",
        "if x > geometry.near:",
        "face_just_out_of_range",
    ),
    "boxes that are left out are out of range": (
        "visibility/limits.py",
        "return total >= geometry.far * geometry.far",
        "return total > 0",
        "face_just_within_the_range",
    ),
}


def ask(folder: Path, probes: Path = PROBES) -> dict[str, bool]:
    """Answers of probes to the package in a folder, without compilation."""
    environment = {**os.environ, "PYTHONPATH": str(folder), "NUMBA_DISABLE_JIT": "1"}
    run = subprocess.run(
        [sys.executable, str(probes)],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    answers: dict[str, bool] = json.loads(run.stdout)
    return answers


def answer_without(condition: tuple[str, str, str, str], folder: Path, probes: Path = PROBES) -> bool:
    """Answer of the probe of a condition (file, text, changed text, probe) to sources without it."""
    name, text, changed, probe = condition
    path = folder / "tilesnav_ref" / name
    original = path.read_text()
    assert original.count(text) == 1, f"the text of the condition has moved: {text}"
    path.write_text(original.replace(text, changed))
    try:
        return ask(folder, probes)[probe]
    finally:
        path.write_text(original)


def copy_of_package(folder: Path) -> Path:
    """A folder with a copy of the package that can be changed."""
    shutil.copytree(PACKAGE, folder / "tilesnav_ref", ignore=shutil.ignore_patterns("__pycache__"))
    return folder


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    return copy_of_package(tmp_path_factory.mktemp("sources"))


def test_the_sources_answer_every_probe_soundly(sources):
    answers = ask(sources)
    assert answers
    assert all(answers.values()), answers


@pytest.mark.parametrize("condition", MUTANTS)
def test_without_the_condition_a_probe_becomes_unsound(condition, sources):
    assert answer_without(MUTANTS[condition], sources) is False
