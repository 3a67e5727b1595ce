"""Routes: the shortest way through the portals, by brute force; every piece in its cell."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from route_boxes import boxes
from test_tileset_small_map import small_map

from tilesnav_ref.cells import planes
from tilesnav_ref.stream.errors import RouteError, TilesetError
from tilesnav_ref.stream.gates import Gates, gates_of, reach_from_gate, reach_from_point
from tilesnav_ref.stream.places import Places, distance_from_cell, places_of
from tilesnav_ref.stream.reader import NavTileset, open_tileset
from tilesnav_ref.stream.route import Route, route_through
from tilesnav_ref.stream.tighten import tighten
from tilesnav_ref.tileset.model import TilesetSettings
from tilesnav_ref.tileset.write import write_tileset

blocks = st.tuples(st.sampled_from(((3, 3, 1), (2, 2, 2), (4, 2, 1))), st.sets(st.integers(0, 8), max_size=3))


def least_by_hand(gates: Gates, start: np.ndarray, source: int, end: np.ndarray, target: int) -> float:
    """Length of the shortest way through middles, over all ways that pass no gate twice."""
    best = np.inf
    open_ways = [(start, source, 0.0, frozenset[int]())]
    while open_ways:
        here, cell, length, passed = open_ways.pop()
        if cell == target:
            best = min(best, length + float(np.linalg.norm(end - here)))
        for gate in range(gates.count):
            if gate not in passed and cell in gates.cells[gate]:
                middle = gates.polygon(gate).mean(axis=0)
                beyond = int(gates.cells[gate].sum()) - cell
                step = float(np.linalg.norm(middle - here))
                open_ways.append((middle, beyond, length + step, passed | {gate}))
    return best


def check(route: Route, gates: Gates, places: Places) -> None:
    """Every point lies in the cell that the route names there, and cells in a row are neighbours."""
    passages = route.passages
    assert passages[0].begin == 0.0
    assert passages[-1].end == pytest.approx(route.length)
    neighbours = {tuple(pair) for pair in gates.cells.tolist()}
    for one, two in pairwise(passages):
        assert one.end == two.begin
        assert (min(one.cell, two.cell), max(one.cell, two.cell)) in neighbours
    for passage in passages:
        assert passage.begin < passage.end
        inside = np.array(
            [places.heights(p)[passage.cell] for p in route.at(np.linspace(passage.begin, passage.end, 7))]
        )
        assert inside.max() <= 1e-9


@given(blocks, st.data())
def test_dijkstra_finds_the_shortest_of_all_ways(
    block: tuple[tuple[int, int, int], set[int]], data: st.DataObject
) -> None:
    shape, gone = block
    gates, places = boxes(shape, {g for g in gone if g < np.prod(shape) - 2})
    count = gates.cell_count
    source, target = (data.draw(st.integers(0, count - 1)) for _ in range(2))
    start, end = (inside(places, cell, data) for cell in (source, target))
    expected = least_by_hand(gates, start, source, end, target)
    if source == target:
        return
    reach = reach_from_point(gates, start, source)
    last = gates.of_cell(target)
    found = min(
        (reach.lengths[g] + float(np.linalg.norm(gates.middles[g] - end)) for g in last), default=np.inf
    )
    assert found == pytest.approx(expected)
    if np.isinf(expected):
        with pytest.raises(RouteError, match=r"no way from way point 1 .* to way point 2"):
            route_through(gates, places, (start, end))
        return
    route = route_through(gates, places, (start, end))
    check(route, gates, places)
    assert np.linalg.norm(end - start) - 1e-9 <= route.length <= expected + 1e-9
    assert np.array_equal(route.points[[0, -1]], (start, end))


def inside(places: Places, cell: int, data: st.DataObject) -> np.ndarray:
    """A point of a unit box."""
    low = places.planes[cell, :3, 3]
    return low + np.array([data.draw(st.sampled_from((0.125, 0.5, 0.875))) for _ in range(3)])


def test_a_way_bends_around_what_is_missing_and_is_pulled_tight() -> None:
    gates, places = boxes((3, 3, 1), {4})
    route = route_through(gates, places, ((0.5, 1.5, 0.5), (2.5, 1.5, 0.5)))
    check(route, gates, places)
    assert len(route.passages) == 5
    # Around the two corners of the missing box (2.414), a little off them; through the middles it is 3.414.
    assert 2.414 < route.length < 2.6


def test_a_way_through_an_open_block_is_straight() -> None:
    gates, places = boxes((6, 1, 1))
    route = route_through(gates, places, ((0.1, 0.2, 0.2), (5.9, 0.8, 0.7)))
    assert route.length == pytest.approx(np.linalg.norm((5.8, 0.6, 0.5)), abs=1e-3)


def test_several_way_points_make_one_way() -> None:
    gates, places = boxes((4, 1, 1))
    points = ((0.5, 0.5, 0.5), (0.75, 0.5, 0.5), (3.5, 0.5, 0.5), (3.5, 0.5, 0.5), (1.5, 0.5, 0.5))
    route = route_through(gates, places, points)
    check(route, gates, places)
    assert [passage.cell for passage in route.passages] == [0, 1, 2, 3, 2, 1]
    assert route.length == pytest.approx(5.0, abs=1e-3)
    assert route.passages[3].end - route.passages[3].begin == pytest.approx(1.0, abs=1e-6)


def test_a_way_point_outside_is_named_with_the_nearest_cell() -> None:
    gates, places = boxes((2, 1, 1))
    with pytest.raises(
        RouteError, match=r"way point 2: found 5, 5, 0.5, which lies in no cell.* cell 1, 5 m away"
    ):
        route_through(gates, places, ((0.5, 0.5, 0.5), (5.0, 5.0, 0.5)))


@pytest.mark.parametrize("points", [(), ((0.5, 0.5, 0.5),)])
def test_fewer_than_two_way_points_are_no_route(points: tuple[tuple[float, ...], ...]) -> None:
    gates, places = boxes((2, 1, 1))
    with pytest.raises(RouteError, match=f"found {len(points)} way points"):
        route_through(gates, places, points)


def test_a_route_without_length_is_refused() -> None:
    gates, places = boxes((2, 1, 1))
    with pytest.raises(RouteError, match="all in one place"):
        route_through(gates, places, ((0.5, 0.5, 0.5), (0.5, 0.5, 0.5)))


@given(st.lists(st.floats(-3, 4), min_size=3, max_size=3))
def test_distance_from_a_box_is_that_of_the_clamped_point(values: list[float]) -> None:
    point = np.array(values)
    _, places = boxes((2, 1, 1))
    clamped = [np.linalg.norm(point - np.clip(point, (k, 0, 0), (k + 1, 1, 1))) for k in range(2)]
    for cell in range(2):
        assert distance_from_cell(places.planes[cell], point) == pytest.approx(clamped[cell], abs=2e-6)
    found = places.cell_at(point)
    if min(clamped) > 1e-5:
        assert found is None
        assert places.nearest(point)[1] == pytest.approx(min(clamped), abs=2e-6)
    elif found is not None:
        assert clamped[found] <= 2e-6


@given(st.integers(0, 2**31))
def test_pulling_tight_keeps_to_the_gates_and_never_lengthens(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 6))
    gates = []
    for k in range(count):
        low, high = np.sort(rng.uniform(-2, 2, (2, 2)), axis=0)
        corners = [
            (k + 1.0, y, z)
            for y, z in ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]))
        ]
        gates.append(np.array(corners[: 3 + seed % 2] if seed % 3 else corners[:2]))
    start, end = np.append(0.0, rng.uniform(-2, 2, 2)), np.append(count + 1.0, rng.uniform(-2, 2, 2))
    way = tighten(start, gates, end)
    middles = np.array([start, *(gate.mean(axis=0) for gate in gates), end])
    assert _length(way) <= _length(middles) + 1e-9
    for point, gate in zip(way[1:-1], gates, strict=True):
        assert np.all(point >= gate.min(axis=0) - 1e-9)
        assert np.all(point <= gate.max(axis=0) + 1e-9)
    # No point alone can be moved within its gate to make the way shorter than it would be by GAIN and a
    # little.
    for k, gate in enumerate(gates, start=1):
        shares = rng.dirichlet(np.ones(len(gate)), 200)
        tried = 0.95 * shares @ gate + 0.05 * gate.mean(axis=0)
        lengths = np.linalg.norm(tried - way[k - 1], axis=1) + np.linalg.norm(way[k + 1] - tried, axis=1)
        kept = np.linalg.norm(way[k] - way[k - 1]) + np.linalg.norm(way[k + 1] - way[k])
        assert lengths.min() >= kept - 0.02 * kept


def _length(way: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())


@pytest.fixture(params=[1, 3])
def tileset(request: pytest.FixtureRequest, tmp_path: Path) -> NavTileset:
    """Three cells in a row, in three sectors or one."""
    folder, one = tmp_path / "out", small_map()
    folder.mkdir()
    write_tileset(folder, one, planes(one.cells, one.scene.step), TilesetSettings(request.param))
    return open_tileset(folder)


def test_gates_of_a_tileset_are_its_portals(tileset: NavTileset) -> None:
    gates = gates_of(tileset)
    assert gates.cells.tolist() == [[0, 1], [1, 2]]
    for gate, (source, target) in enumerate(gates.cells.tolist()):
        assert np.array_equal(gates.polygon(gate), tileset.portal_polygon(source, target))
    middles = places_of(tileset).planes.shape
    assert middles == (3, 6, 4)
    reach = reach_from_gate(gates, 0)
    assert reach.way(1) == [0, 1]
    assert reach.lengths[1] == pytest.approx(np.linalg.norm(gates.middles[1] - gates.middles[0]))


def test_a_portal_without_an_area_is_refused(tileset: NavTileset) -> None:
    sector = tileset.sectors[0]
    offsets = sector.vertices.offsets.copy()
    offsets[1] = 2
    object.__setattr__(sector.vertices, "offsets", offsets)
    with pytest.raises(TilesetError, match=r"a polygon of 2 vertices; allowed: 3 or more"):
        gates_of(tileset)
