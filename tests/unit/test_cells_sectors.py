"""Sectors: no cell crosses a border, both sides meet exactly, and a sector alone has the same cells."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from mission_scenes import STEP, box_faces, hill, rectangle, scene_of, surface

from tilesnav_ref.cells import CellComplex, CellError, CellSettings, decompose
from tilesnav_ref.cells.sectors import connected_within, lattice_cuts, sector_places
from tilesnav_ref.scene.model import Scene

SIZE = 20.0
SETTINGS = CellSettings(
    min_size=1.0, max_size=8.0, clearance=0.25, altitude_max=16.0, sector_size=SIZE, coverage_points=2000
)


def town() -> Scene:
    """Houses across borders of sectors; the plan goes from -30 to 35 m and cuts the sectors at its rim."""
    houses = [box_faces((x, y, 0), (x + 9, y + 7, 6)) for x in (-25, -4, 17) for y in (-22, -3, 15)]
    return scene_of(rectangle((-30, 35), (-30, 35), (0, 0)), *houses)


def sectors_of(cells: CellComplex) -> np.ndarray:
    return cells.lower[:, :2] // round(SIZE / STEP)


@pytest.mark.parametrize("mission", ["aerial", "ground"])
def test_no_cell_crosses_a_border_and_portals_do(mission: str) -> None:
    change = {"mission": mission, "altitude_max": None} if mission == "ground" else {}
    cells = decompose(town(), dataclasses.replace(SETTINGS, **change))
    places = sectors_of(cells)
    assert np.array_equal(places, (cells.upper[:, :2] - 1) // round(SIZE / STEP))
    assert len(np.unique(places, axis=0)) == 16
    sources = np.repeat(np.arange(cells.count), np.diff(cells.portal_offsets))
    across = np.any(places[sources] != places[cells.portal_targets], axis=1)
    assert np.count_nonzero(across) > 50
    for portal in np.flatnonzero(across)[:40]:
        number = cells.portal_polygons[portal]
        polygon = cells.polygon_vertices[slice(*cells.polygon_offsets[number : number + 2])]
        axis = np.flatnonzero(np.ptp(polygon, axis=0) == 0)[0]
        assert polygon[0, axis] % round(SIZE / STEP) == 0


def test_cells_of_a_sector_follow_each_other() -> None:
    cells = decompose(town(), SETTINGS)
    places = sectors_of(cells)
    assert cells.sector_offsets[0] == 0
    assert cells.sector_offsets[-1] == cells.count
    seen = []
    for first, last in zip(cells.sector_offsets[:-1], cells.sector_offsets[1:], strict=True):
        assert first < last
        assert len(np.unique(places[first:last], axis=0)) == 1
        seen.append(tuple(places[first]))
    assert len(set(seen)) == len(seen) == 16


@pytest.mark.parametrize(
    ("sector", "change"),
    [
        ((0, 0), {}),
        ((-2, -2), {}),
        ((1, -1), {"clearance": 0.0}),
        ((0, -1), {"mission": "ground", "altitude_max": None}),
        ((-1, 0), {"method": "voxel", "voxel_size": 2.0}),
        ((0, 1), {"mission": "corridor", "corridor": ((-28.0, -10.0, 9.0), (30.0, 30.0, 12.0))}),
    ],
)
def test_sector_alone_has_the_cells_that_it_has_among_all(
    sector: tuple[int, int], change: dict[str, object]
) -> None:
    settings = dataclasses.replace(SETTINGS, **change)
    whole, alone = (
        decompose(town(), settings),
        decompose(town(), dataclasses.replace(settings, sector=sector)),
    )
    own = np.all(sectors_of(whole) == sector, axis=1)
    assert np.count_nonzero(own) > 3
    assert np.array_equal(whole.corners[own], alone.corners)
    assert np.array_equal(whole.kinds[own], alone.kinds)
    inner = own[np.repeat(np.arange(whole.count), np.diff(whole.portal_offsets))] & own[whole.portal_targets]
    assert alone.portal_count == np.count_nonzero(inner)


def test_sectors_on_a_hill_keep_the_ceiling_of_the_whole() -> None:
    scene = scene_of(surface(hill, 128.0))
    settings = dataclasses.replace(SETTINGS, sector_size=40.0, min_size=2.0)
    whole = decompose(scene, settings)
    alone = decompose(scene, dataclasses.replace(settings, sector=(1, 1)))
    own = np.all(whole.lower[:, :2] // round(40.0 / STEP) == (1, 1), axis=1)
    assert np.array_equal(whole.corners[own], alone.corners)


def test_covered_way_across_a_border_is_kept() -> None:
    # its open end is in sector (0, 0), most of it in (1, 0), under one roof
    tunnel = [
        rectangle((12, 36), (8, 12), (4, 4)),
        np.array([[(12.0, 8, 0), (36, 8, 0), (36, 8, 4)], [(12, 8, 0), (36, 8, 4), (12, 8, 4)]]),
        np.array([[(12.0, 12, 0), (36, 12, 0), (36, 12, 4)], [(12, 12, 0), (36, 12, 4), (12, 12, 4)]]),
        np.array([[(36.0, 8, 0), (36, 12, 0), (36, 12, 4)], [(36, 8, 0), (36, 12, 4), (36, 8, 4)]]),
    ]
    cells = decompose(scene_of(rectangle((0, 40), (0, 20), (0, 0)), *tunnel), SETTINGS)
    point = np.array((30.0, 10.0, 2.0)) / STEP
    assert np.any(np.all((cells.lower < point) & (point < cells.upper), axis=1))


def test_sector_beyond_the_scene_is_refused() -> None:
    with pytest.raises(CellError, match=r"sector 7,0 of 20 m holds no part .* -2 to 1 and -2 to 1"):
        decompose(town(), dataclasses.replace(SETTINGS, sector=(7, 0)))


def test_sector_without_free_space_is_refused() -> None:
    block = box_faces((20, 0, 0), (40, 20, 30))
    scene = scene_of(rectangle((0, 60), (0, 20), (0, 0)), block)
    with pytest.raises(CellError, match="no cell is in sector"):
        decompose(scene, dataclasses.replace(SETTINGS, sector=(1, 0)))


def test_lattice_is_that_of_the_nav_frame() -> None:
    assert lattice_cuts(-30, 35, 20).tolist() == [-30, -20, 0, 20, 35]
    assert lattice_cuts(0, 40, 20).tolist() == [0, 20, 40]
    assert sector_places(np.array([[-1, 0, 5], [19, 20, 5]]), 20).tolist() == [[-1, 0], [0, 1]]


def test_connection_is_sought_in_nine_sectors_only() -> None:
    chain = np.array([[0, 1], [1, 2], [2, 3]])
    places = np.array([[0, 0], [1, 0], [2, 0], [3, 0]])
    starts = np.array([True, False, False, False])
    assert connected_within(chain, starts, places).tolist() == [True, True, False, False]
    assert connected_within(chain, starts, np.zeros_like(places)).all()
