"""Which faces and cells two maps have in common."""

from __future__ import annotations

import numpy as np
from visibility_reference import make_flagged, make_scene

from tilesnav_ref.update.matching import face_rows, match_rows

A, B, C, D = (0, 0, 0), (9, 0, 0), (0, 9, 0), (0, 0, 9)


def test_rows_are_paired_once_and_in_order() -> None:
    first = np.array([[1, 2], [3, 4], [1, 2], [5, 6], [1, 2]])
    second = np.array([[1, 2], [7, 8], [5, 6], [1, 2]])
    assert match_rows(first, second).tolist() == [0, -1, 3, 2, -1]
    assert match_rows(second, first).tolist() == [0, -1, 3, 2]


def test_nothing_goes_with_nothing() -> None:
    none = np.zeros((0, 2), np.int64)
    assert match_rows(none, np.array([[1, 2]])).tolist() == []
    assert match_rows(np.array([[1, 2]]), none).tolist() == [-1]


def test_random_rows_against_counting() -> None:
    rng = np.random.default_rng(1)
    first, second = rng.integers(0, 3, (60, 2)), rng.integers(0, 3, (40, 2))
    found = match_rows(first, second)
    paired = found >= 0
    assert np.array_equal(first[paired], second[found[paired]])
    assert len(set(found[paired].tolist())) == paired.sum()
    for row in np.unique(first, axis=0):
        counts = [(table == row).all(axis=1) for table in (first, second)]
        assert paired[counts[0]].sum() == min(counts[0].sum(), counts[1].sum())


def test_a_face_is_its_corners_in_any_order() -> None:
    one, two = make_scene([[A, B, C], [A, C, D]]), make_scene([[D, A, C], [B, A, C]])
    assert match_rows(face_rows(one), face_rows(two)).tolist() == [1, 0]


def test_one_corner_more_to_the_side_is_another_face() -> None:
    one, two = make_scene([[A, B, C]]), make_scene([[A, (9, 0, 1), C]])
    assert match_rows(face_rows(one), face_rows(two)).tolist() == [-1]


def test_a_one_sided_face_has_a_sense_of_rotation() -> None:
    one = make_flagged([[A, B, C]], one_sided=[0])
    same, turned = (make_flagged([face], one_sided=[0]) for face in ([C, A, B], [B, A, C]))
    assert match_rows(face_rows(one), face_rows(same)).tolist() == [0]
    assert match_rows(face_rows(one), face_rows(turned)).tolist() == [-1]


def test_a_face_whose_flag_changes_is_another_face() -> None:
    plain = make_flagged([[A, B, C]])
    for changed in (make_flagged([[A, B, C]], porous=[0]), make_flagged([[A, B, C]], one_sided=[0])):
        assert match_rows(face_rows(plain), face_rows(changed)).tolist() == [-1]
        assert match_rows(face_rows(changed), face_rows(plain)).tolist() == [-1]
