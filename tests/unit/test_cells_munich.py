"""Cells of a part of a real old town: street canyons, courtyards, and houses without a bottom."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from tilesnav_ref.cells import KIND_GROUND, CellSettings, decompose
from tilesnav_ref.cells.overlap import meets_box
from tilesnav_ref.scene.model import Scene

MUNICH = Path(__file__).resolve().parents[3] / "shared" / "data" / "munich_mesh" / "munich.ply"
REGION = (-20.0, -120.0, 80.0, -20.0)


@pytest.mark.realdata
@pytest.mark.skipif(not MUNICH.exists(), reason=f"{MUNICH} is not there")
def test_old_town_is_covered_by_clear_cells() -> None:
    mesh = trimesh.load(MUNICH, process=False)
    vertices = np.round(np.asarray(mesh.vertices) * 1024).astype(np.int64)
    corners = vertices[np.asarray(mesh.faces)]
    edges = corners[:, 1:] - corners[:, :1]
    faces = np.asarray(mesh.faces)[np.any(np.cross(edges[:, 0], edges[:, 1]) != 0, axis=1)].astype(np.int32)
    scene = Scene(vertices, faces, np.zeros(len(faces), np.int32), np.zeros(1, np.int32), ("munich",))
    cells = decompose(scene, CellSettings(region=REGION, coverage_points=20_000))
    assert 100 < cells.count < 2000
    assert cells.coverage > 0.95
    assert np.any(cells.kinds == KIND_GROUND)
    low, high = cells.lower - cells.clearance, cells.upper + cells.clearance
    corners, room = scene.corners(), np.empty(3, np.int64)
    # a second broad phase, by bounds alone, so that a fault of the first one shows
    least, most = corners.min(axis=1), corners.max(axis=1)
    for a, b in zip(low, high, strict=True):
        near = np.flatnonzero(np.all((least < b) & (most > a), axis=1))
        assert not any(meets_box(corners[face], a, b, room) for face in near)
