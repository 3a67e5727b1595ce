"""Random changes of small scenes: what is taken over, against the definition and a run from the start."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from update_reference import WORK, proven_of, sets_of, update
from visibility_reference import make_flagged

from tilesnav_ref.scene.model import Scene
from tilesnav_ref.update.matching import face_rows, match_rows

Triangle = tuple[tuple[int, int, int], ...]
small = st.integers(0, 6)
corner = st.tuples(small, small, small)
triangle = st.tuples(corner, corner, corner).filter(
    lambda t: bool(np.any(np.cross(np.subtract(t[1], t[0]), np.subtract(t[2], t[0]))))
)
flags = st.tuples(st.booleans(), st.booleans())
faces = st.lists(st.tuples(triangle, flags), max_size=4)
# Before the soup, behind it, and one that is as long as the soup.
BOXES = [[[9, 2, 2], [12, 4, 4]], [[-5, 2, 2], [-2, 4, 4]], [[9, -9, 8], [12, 15, 9]]]
WALLS = {
    "none": [],
    "closed": [((8, -60, -60), (8, 60, -60), (8, 0, 90))],
    "half": [((8, -60, -60), (8, 3, -60), (8, 3, 90))],
}
Flagged = list[tuple[Triangle, tuple[bool, bool]]]


def scene_of(flagged: Flagged, wall: str, order: int) -> Scene:
    """Flagged faces and opaque walls, in an order that depends on a number."""
    rows = [*flagged, *((face, (False, False)) for face in WALLS[wall])]
    rows = [rows[i] for i in np.random.default_rng(order).permutation(len(rows))]
    porous, sided = ([i for i, (_, flag) in enumerate(rows) if flag[k]] for k in range(2))
    return make_flagged([face for face, _ in rows], porous, sided)


@given(faces, faces, faces, st.sampled_from(sorted(WALLS)), st.booleans())
@settings(max_examples=120, deadline=None)
def test_an_updated_map_misses_nothing(
    stay: Flagged, go: Flagged, come: Flagged, wall: str, limited: bool
) -> None:
    common = [*stay, (((0, 0, 0), (6, 0, 0), (0, 6, 0)), (False, False))]
    old, new = scene_of(common + go, wall, 1), scene_of(common + come, wall, 2)
    work = replace(WORK, max_range=9 * 2.0**-10) if limited else WORK
    found = update(old, new, BOXES, work)
    numbers = match_rows(face_rows(old), face_rows(new))
    before = proven_of(found.earlier)
    for cell in found.kept:
        # The same faces are visible in both scenes, so neither run can prove the contrary of the other.
        stayed = {int(numbers[face]) for face in before[cell]}
        assert stayed <= found.full[cell]
        assert found.sets[cell] == {int(numbers[face]) for face in sets_of(found.earlier)[cell]}


@given(faces, st.sampled_from(sorted(WALLS)), st.integers(0, 9))
@settings(max_examples=30, deadline=None)
def test_without_a_change_everything_is_kept(stay: Flagged, wall: str, order: int) -> None:
    common = [*stay, (((0, 0, 0), (6, 0, 0), (0, 6, 0)), (False, False))]
    found = update(scene_of(common, wall, 1), scene_of(common, wall, order), BOXES)
    assert found.kept == {0, 1, 2}


def test_random_changes_leave_some_cells_and_not_others() -> None:
    """The tests above would say nothing if all cells were kept, or none."""
    rng = np.random.default_rng(8)

    def random_faces(count: int) -> Any:
        corners = rng.integers(0, 7, (count, 3, 3))
        areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return [(tuple(map(tuple, face)), (False, False)) for face in corners[np.any(areas, axis=1)].tolist()]

    kept = []
    for wall in WALLS:
        common = random_faces(5)
        changed = [scene_of(common + random_faces(1), wall, 1) for _ in range(2)]
        kept.append(len(update(changed[0], changed[1], BOXES).kept))
    assert 0 < sum(kept) < 3 * len(WALLS)
