"""Stock routes: level lines, what counts as roof and ground, and the same stops every time."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from route_boxes import boxes

from tilesnav_ref.stream.errors import RouteError
from tilesnav_ref.stream.gates import Gates
from tilesnav_ref.stream.stock import find_roofs, level_lines, roof_height, stock_route


def map_of(*squares: tuple[float, float, float, float]) -> SimpleNamespace:
    """A map of level squares: x, y, z and edge; step 1/4 m."""
    corners = []
    for x, y, z, edge in squares:
        a, b, c, d = (x, y, z), (x + edge, y, z), (x + edge, y + edge, z), (x, y + edge, z)
        corners += [(a, b, c), (a, c, d)]
    return SimpleNamespace(
        step=0.25, finest=SimpleNamespace(corners=(np.array(corners) * 4).astype(np.int32))
    )


def scaled(gates: Gates, factor: float) -> Gates:
    return Gates(gates.cells, gates.offsets, gates.vertices * factor, gates.cell_count)


GROUND = (-50.0, -50.0, 0.0, 150.0)


def test_level_lines_cut_upright_gates_at_their_heights() -> None:
    gates, _ = boxes((2, 1, 2))
    upright = np.flatnonzero(np.ptp(gates.middles[gates.cells[:, 0]], axis=0).max() >= 0)
    kept, lines = level_lines(gates, np.full(gates.count, 0.25))
    assert len(upright) > 0
    assert gates.cells[kept].tolist() == [[0, 2]]
    assert lines[0, :, [0, 2]].T.tolist() == [[1.0, 0.25], [1.0, 0.25]]
    assert sorted(lines[0, :, 1]) == [0.0, 1.0]
    none, empty = level_lines(gates, np.full(gates.count, 9.0))
    assert (len(none), empty.shape) == (0, (0, 2, 3))


def test_roofs_are_level_high_faces_weighted_by_area() -> None:
    town = map_of(GROUND, (0, 0, 2.0, 10), (0, 20, 6.0, 10), (20, 0, 8.0, 10), (20, 20, 40.0, 2))
    roofs = find_roofs(town)
    assert sorted(set(roofs.middles[:, 2])) == [6.0, 8.0, 40.0]
    assert roofs.areas.sum() == pytest.approx(204.0)
    assert roof_height(roofs) == 8.0
    upright = map_of(GROUND, (0, 0, 9.0, 4))
    upright.finest.corners[2:, :, :] = [[0, 0, 0], [0, 0, 40], [0, 40, 40]]
    assert len(find_roofs(upright).areas) == 0


def test_the_way_over_the_roofs_is_level_and_the_same_every_time() -> None:
    gates = scaled(boxes((4, 4, 3))[0], 4.0)
    town = map_of(GROUND, (0, 0, 5.0, 4), (12, 0, 5.0, 4), (0, 12, 5.0, 4), (12, 12, 5.0, 4))
    route = stock_route(town, gates, "roof")
    assert set(route.points[:, 2]) == {5.0}
    assert np.array_equal(route.points, stock_route(town, gates, "roof").points)
    # Three legs between four stops, the first of them across the whole block.
    assert route.length > 24.0
    plan = np.ptp(route.points[:, :2], axis=0)
    assert plan.min() >= 8.0


def test_the_way_near_the_ground_leaves_out_cells_on_roofs() -> None:
    # The cells of one column are gone up to 8 m: a house. The cell above it stands on its roof.
    gates = scaled(boxes((4, 4, 3), {15, 16})[0], 4.0)
    town = map_of(GROUND, (4, 4, 8.0, 4))
    route = stock_route(town, gates, "ground")
    assert set(route.points[:, 2]) == {1.5}
    assert not np.any(np.all((route.points[:, :2] > 4.0) & (route.points[:, :2] < 8.0), axis=1))


def test_the_way_stays_among_houses_where_there_are_any() -> None:
    gates = scaled(boxes((12, 2, 1))[0], 20.0)
    towers = [(x, y, 9.0, 2.0) for x in (60.0, 90.0, 118.0) for y in (-15.0, 55.0)]
    among = stock_route(map_of(GROUND, *towers), gates, "ground")
    everywhere = stock_route(map_of(GROUND), gates, "ground")
    assert everywhere.points[:, 0].max() > 220.0
    assert 60.0 <= among.points[:, 0].min() < among.points[:, 0].max() <= 120.0


@pytest.mark.parametrize(
    ("squares", "name", "message"),
    [
        ((GROUND,), "roof", "route roof: found no roof"),
        ((GROUND, (0, 0, 50.0, 4)), "roof", "route roof: found 0 stops"),
    ],
)
def test_what_has_no_such_way_says_so(
    squares: tuple[tuple[float, ...], ...], name: str, message: str
) -> None:
    gates = scaled(boxes((3, 1, 1))[0], 4.0)
    with pytest.raises(RouteError, match=message):
        stock_route(map_of(*squares), gates, name)


def test_one_gate_is_no_route() -> None:
    gates = scaled(boxes((2, 1, 1))[0], 4.0)
    with pytest.raises(RouteError, match="found 1 stops"):
        stock_route(map_of(GROUND), gates, "ground")
    with pytest.raises(RouteError, match="found 0 stops"):
        stock_route(map_of(GROUND), scaled(boxes((1, 1, 1))[0], 4.0), "ground")
