"""Stock routes: a level way over the roofs, and one near the ground, chosen by rule.

Notes
-----
Both go through portals that stand upright, along the level line of each at one height: the height z that
three quarters of the area of the roofs lie below, or 1.5 m over the lower border of portals near the
ground. They visit four stops in the largest part that these portals connect. Stops lie among houses:
there is a roof within 60 m in each quarter of the compass (all portals of the part count where this
leaves fewer than two). The first stop is the one farthest, along the portals, from the one nearest to the
middle, the second the one farthest from the first, and each next the one farthest from all before. They
are visited in this order. Ties go to the portal of the smallest number; so the same tileset has the same
routes.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from tilesnav_ref.stream.errors import RouteError
from tilesnav_ref.stream.gates import Gates, reach_from_gate
from tilesnav_ref.stream.reader import NavTileset
from tilesnav_ref.stream.route import Route, join, way_through

STOCK = ("roof", "ground")
STOPS = 4
RIDE = 1.5
"""m over the lower border of a portal; the height of a sensor on a ground vehicle."""
FLOOR_RISE = 2.0
"""m; a portal is near the ground when none within NEAR begins lower by more. Storeys are higher."""
NEAR = 25.0
"""m in plan; courts and wide houses are narrower than twice this."""
ROOF_SHARE = 0.75
"""Share of the area of roofs that lies below the route over the roofs."""
ROOF_LEAST = 2.5
"""m over the lowest face; what lies level below this is no roof."""
AROUND = 60.0
"""m; roofs of a street or a square are nearer, and those across a river or a park are not."""
BIN = 4.0
"""m; of roof points within a square of this size one counts."""
LEVEL = 0.5
"""Least upward part of the normal of a roof: up to 60 degrees."""


def stock_route(tileset: NavTileset, gates: Gates, name: str) -> Route:
    """Choose the route `roof` or `ground` of a tileset.

    Raises
    ------
    RouteError
        When there are fewer than two portals to pass at that height.
    """
    roofs = find_roofs(tileset)
    gate_low = np.minimum.reduceat(gates.vertices[:, 2], gates.offsets[:-1]) if gates.count else np.zeros(0)
    if name == "roof":
        kept, lines = level_lines(gates, np.full(gates.count, roof_height(roofs)))
    else:
        kept, lines = level_lines(gates, gate_low + RIDE)
        near = _near_ground(gates.middles[:, :2], gate_low, kept)
        kept, lines = kept[near], lines[near]
    narrow = gates.select(kept, lines)
    stops = _stops(narrow, _among(roofs, gates.middles[kept, :2])) if narrow.count else []
    if len(stops) < 2:
        raise RouteError(
            f"route {name}: found {len(stops)} stops at that height; allowed: two or more; give way points"
        )
    return _tour(narrow, stops)


@dataclass(frozen=True)
class Roofs:
    """Faces that are not steep, and higher than 2.5 m above the lowest point of all."""

    middles: NDArray[np.float64]
    """(F, 3) m, nav frame."""
    areas: NDArray[np.float64]
    """(F,) m2."""
    plan: NDArray[np.float64]
    """(K, 2) corners and middles of edges and faces as seen from above, one in each square of 4 m."""


def find_roofs(tileset: NavTileset) -> Roofs:
    """Find the roofs among the faces of level 0."""
    corners = tileset.finest.corners * np.float64(tileset.step)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    areas, middles = np.linalg.norm(normals, axis=1), corners.mean(axis=1)
    high = middles[:, 2] > corners[:, :, 2].min(initial=np.inf) + ROOF_LEAST
    chosen = high & (np.abs(normals[:, 2]) > LEVEL * areas)
    corners = corners[chosen]
    halves = (corners + np.roll(corners, -1, axis=1)) / 2
    points = np.concatenate((corners, halves, middles[chosen, None]), axis=1).reshape(-1, 3)[:, :2]
    _, one_each = np.unique(np.floor(points / BIN), axis=0, return_index=True)
    return Roofs(middles[chosen], areas[chosen], points[one_each])


def roof_height(roofs: Roofs) -> float:
    """Height z that three quarters of the area of the roofs lie below, m.

    Raises
    ------
    RouteError
        When there are no roofs.
    """
    if len(roofs.areas) == 0:
        raise RouteError("route roof: found no roof; allowed: way points, or the route ground")
    order = np.argsort(roofs.middles[:, 2], kind="stable")
    below = np.cumsum(roofs.areas[order])
    place = int(np.searchsorted(below, ROOF_SHARE * below[-1]))
    return float(roofs.middles[order[min(place, len(order) - 1)], 2])


def _among(roofs: Roofs, plan: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether places (G, 2) have a roof near by in each quarter of the compass."""
    if len(roofs.plan) == 0 or len(plan) == 0:
        return np.zeros(len(plan), np.bool_)
    near = cKDTree(roofs.plan).query_ball_point(plan, AROUND)
    quarters = [
        np.unique((roofs.plan[found] > place) @ np.array((1, 2)))
        for place, found in zip(plan, near, strict=True)
    ]
    return np.array([len(one) == 4 for one in quarters])


def level_lines(gates: Gates, heights: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Cut gates by a height each.

    Parameters
    ----------
    heights : (G,) float64
        z, m.

    Returns
    -------
    (K,) int64, (K, 2, 3) float64
        The gates that are cut, ascending, and the two ends of their level lines.
    """
    counts = np.diff(gates.offsets)
    owner = np.repeat(np.arange(gates.count), counts)
    follower = np.arange(len(owner)) + 1
    follower[gates.offsets[1:] - 1] = gates.offsets[:-1]
    here, there = gates.vertices, gates.vertices[follower]
    above, next_above = here[:, 2] >= heights[owner], there[:, 2] >= heights[owner]
    # The border of a convex polygon comes from below once and goes below once, or never does.
    cut = np.flatnonzero(above != next_above)
    share = (heights[owner[cut]] - here[cut, 2]) / (there[cut, 2] - here[cut, 2])
    points = here[cut] + share[:, None] * (there[cut] - here[cut])
    points[:, 2] = heights[owner[cut]]
    lines = points.reshape(-1, 2, 3)
    long = np.any(lines[:, 0] != lines[:, 1], axis=1)
    return owner[cut].reshape(-1, 2)[long, 0], lines[long]


def _near_ground(
    plan: NDArray[np.float64], low: NDArray[np.float64], asked: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Whether gates asked for begin near the lowest around them; `plan` (G, 2) and `low` (G,) are of all."""
    if len(asked) == 0:
        return np.zeros(0, np.bool_)
    around = cKDTree(plan).query_ball_point(plan[asked], NEAR)
    return np.array([low[g] <= low[many].min() + FLOOR_RISE for g, many in zip(asked, around, strict=True)])


def _tour(gates: Gates, stops: list[int]) -> Route:
    pieces = []
    for source, target in pairwise(stops):
        passed = reach_from_gate(gates, source).way(target)
        # The way begins in the middle of the first gate and ends in that of the last.
        cells = [_shared(gates, a, b) for a, b in pairwise(passed)]
        ends = gates.middles[source], gates.middles[target]
        pieces.append(way_through(gates, ends, (cells[0], cells[-1]), passed[1:-1]))
    return join(pieces)


def _stops(gates: Gates, among: NDArray[np.bool_]) -> list[int]:
    """Gates to visit, in order."""
    _, part = connected_components(gates.graph, directed=False)
    members = np.flatnonzero(part == np.argmax(np.bincount(part)))
    if np.count_nonzero(among[members]) > 1:
        members = members[among[members]]
    middle = gates.middles[members].mean(axis=0)
    centre = int(members[np.argmin(np.linalg.norm(gates.middles[members] - middle, axis=1))])
    stops: list[int] = []
    least = reach_from_gate(gates, centre).lengths[members]
    while len(stops) < min(STOPS, len(members)):
        stops.append(int(members[np.argmax(least)]))
        lengths = reach_from_gate(gates, stops[-1]).lengths[members]
        least = lengths if len(stops) == 1 else np.minimum(least, lengths)
    return stops


def _shared(gates: Gates, first: int, second: int) -> int:
    return int(np.intersect1d(gates.cells[first], gates.cells[second])[0])
