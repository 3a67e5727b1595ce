"""Cells of a part of a real old town: street canyons, courtyards, and houses without a bottom."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from tilesnav_ref.cells import KIND_GROUND, CellSettings, decompose, planes
from tilesnav_ref.scene.model import Scene

MUNICH = Path(__file__).resolve().parents[3] / "shared" / "data" / "munich_mesh" / "munich.ply"
REGION = (-20.0, -120.0, 80.0, -20.0)


def old_town() -> Scene:
    """The mesh on a grid of a millimetre."""
    mesh = trimesh.load(MUNICH, process=False)
    vertices = np.round(np.asarray(mesh.vertices) * 1024).astype(np.int64)
    corners = vertices[np.asarray(mesh.faces)]
    edges = corners[:, 1:] - corners[:, :1]
    faces = np.asarray(mesh.faces)[np.any(np.cross(edges[:, 0], edges[:, 1]) != 0, axis=1)].astype(np.int32)
    return Scene(vertices, faces, np.zeros(len(faces), np.int32), np.zeros(1, np.int32), ("munich",))


def reaches_into(triangle: np.ndarray, half_spaces: np.ndarray) -> bool:
    """Whether a triangle (m) has a point inside planes (6, 4) by more than a nanometre, by clipping."""
    polygon = list(triangle)
    for *normal, d in half_spaces:
        over = [np.dot(normal, point) + d + 1e-9 for point in polygon]
        kept = []
        for a, (point, height) in enumerate(zip(polygon, over, strict=True)):
            b = (a + 1) % len(polygon)
            if height < 0:
                kept.append(point)
            if height * over[b] < 0:
                kept.append(point + height / (height - over[b]) * (polygon[b] - point))
        polygon = kept
    return len(polygon) > 0


@pytest.mark.realdata
@pytest.mark.skipif(not MUNICH.exists(), reason=f"{MUNICH} is not there")
@pytest.mark.parametrize(("method", "most"), [("prisms", 500), ("boxes", 2000)])
def test_old_town_is_covered_by_clear_cells(method: str, most: int) -> None:
    scene = old_town()
    cells = decompose(scene, CellSettings(region=REGION, coverage_points=20_000, method=method))
    assert 100 < cells.count < most
    assert cells.coverage > 0.95
    assert np.any(cells.kinds == KIND_GROUND)
    assert (method == "prisms") == bool(np.any(np.ptp(planes(cells, scene.step)[..., :3], axis=2) < 1.0))
    moved = planes(cells, scene.step)
    moved[..., 3] -= cells.clearance * scene.step
    corners = scene.corners() * scene.step
    # a second broad phase, by bounds alone, so that a fault of the first one shows
    least, highest = corners.min(axis=1), corners.max(axis=1)
    reach = 5 * cells.clearance
    for low, high, six in zip(cells.lower - reach, cells.upper + reach, moved, strict=True):
        near = np.flatnonzero(np.all((least < high * scene.step) & (highest > low * scene.step), axis=1))
        assert not any(reaches_into(corners[face], six) for face in near)
