"""The reader of the reference implementation opens every valid conformance case and reads all of it."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest
from suite import Case, cases

from tilesnav_ref.stream.reader import open_tileset

VALID = [case for case in cases() if case.status == 0]


@pytest.mark.parametrize("case", VALID, ids=lambda case: case.name)
def test_every_state_of_a_valid_case_has_its_digest(case: Case) -> None:
    tileset = open_tileset(case.folder / case.facts["tileset"])
    assert len(tileset.object_offsets) == tileset.object_count + 1
    faces = sum(len(tileset.corners(content.content_id)) for content in tileset.contents)
    assert faces == tileset.face_count
    for cell in range(tileset.cell_count):
        state = tileset.state(cell)
        text = b"".join(
            np.array([len(part)], "<u4").tobytes() + np.asarray(part, "<u4").tobytes()
            for part in (state.faces, state.objects)
        )
        digest = hashlib.sha256(text + np.asarray(state.codes, "u1").tobytes()).digest()
        assert digest == tileset.digest(cell)
