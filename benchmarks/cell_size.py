"""What the largest size of a cell costs and saves: cells, time, sets, and bytes a metre of path.

Usage: python benchmarks/cell_size.py [SCENE] [--region X0,Y0,X1,Y1] [--sizes 4,8,16,32] ...

A vehicle goes from the one corner of the region to the opposite one on the shortest way through the portals.
It holds the set of the cell that it is in, so that each portal costs the faces that enter, with their
corners, and the numbers of those that leave. Bytes are those of zlib on grid coordinates and numbers as
differences, without loss; a better codec makes all of them smaller, and their ratios stand. No test asserts a
time.
"""

from __future__ import annotations

import argparse
import zlib
from dataclasses import dataclass
from itertools import pairwise
from time import process_time

import numpy as np
from numpy.typing import NDArray
from scenes import TOWN, load
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra
from visibility import numbers

from tilesnav_ref.cells import CellSettings, decompose
from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.scene import Scene
from tilesnav_ref.visibility import VisibilitySettings, compute_pvs
from tilesnav_ref.visibility.model import PvsTable


@dataclass(frozen=True)
class Row:
    """One size; means over the cells, the route's figures over the route."""

    size: float
    cells: int
    coverage: float
    seconds: float
    listed: float
    overestimate: float
    hops: int
    metres: float
    first: int
    bytes_a_metre: float


def packed(values: NDArray[np.int64]) -> int:
    """Bytes of some rows of integers as differences, by zlib."""
    if len(values) == 0:
        return 0
    rows = values.reshape(len(values), -1)
    return len(zlib.compress(np.diff(rows, axis=0, prepend=0).astype("<i4").T.tobytes(), 9))


def bytes_of(scene: Scene, faces: NDArray[np.int64]) -> int:
    """Bytes of the numbers and the geometry of some faces, ascending."""
    if len(faces) == 0:
        return 0
    used, corners = np.unique(scene.faces[faces], return_inverse=True)
    return packed(faces) + packed(scene.vertices[used]) + packed(corners.reshape(-1, 3).astype(np.int64))


def route_of(cells: CellComplex) -> NDArray[np.int64]:
    """Cells on the shortest way, from centre to centre, between two opposite corners of the largest part."""
    middles = cells.corners.mean(axis=1)
    sources = np.repeat(np.arange(cells.count), np.diff(cells.portal_offsets))
    lengths = np.linalg.norm(middles[sources] - middles[cells.portal_targets], axis=1)
    graph = csr_array((lengths, cells.portal_targets, cells.portal_offsets), shape=(cells.count, cells.count))
    _, part = connected_components(graph, directed=False)
    inside = np.flatnonzero(part == np.argmax(np.bincount(part)))
    along = middles[inside, :2] @ np.ones(2)
    start, end = int(inside[np.argmin(along)]), int(inside[np.argmax(along)])
    _, before = dijkstra(graph, indices=start, return_predecessors=True)
    way = [end]
    while way[-1] != start:
        way.append(int(before[way[-1]]))
    return np.array(way[::-1])


def ride(scene: Scene, cells: CellComplex, pvs: PvsTable) -> tuple[int, float, int, float]:
    """Hops and metres of the route, bytes of its first set, bytes a metre of what follows."""
    way = route_of(cells)
    middles = cells.corners[way].mean(axis=1) * scene.step
    metres = float(np.linalg.norm(np.diff(middles, axis=0), axis=1).sum())
    sets = [pvs.faces_of(int(cell)).astype(np.int64) for cell in way]
    total = 0
    for one, other in pairwise(sets):
        total += bytes_of(scene, np.setdiff1d(other, one)) + packed(np.setdiff1d(one, other))
    return len(way) - 1, metres, bytes_of(scene, sets[0]), total / metres


def measure(scene: Scene, size: float, arguments: argparse.Namespace) -> Row:
    """Cells, sets and the route for one largest size."""
    settings = CellSettings(
        region=arguments.region,
        min_size=min(arguments.min_cell, size),
        max_size=size,
        altitude_max=arguments.altitude_max,
    )
    begin = process_time()
    cells = decompose(scene, settings)
    pvs = compute_pvs(scene, cells, VisibilitySettings(attempts=arguments.attempts))
    seconds = process_time() - begin
    listed, proven = len(pvs.pvs_faces), int(pvs.proven_counts.sum())
    return Row(
        size, cells.count, cells.coverage, seconds, listed / cells.count, listed / proven,
        *ride(scene, cells, pvs),
    )  # fmt: skip


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description="The trade of the size of cells.")
    parser.add_argument("scene", nargs="?", default=TOWN, help=f"mesh file, or {TOWN!r} (the default)")
    parser.add_argument("--region", type=numbers(float), default=(-60.0, -60.0, 60.0, 60.0), help="m")
    parser.add_argument("--sizes", type=numbers(float), default=(4.0, 8.0, 16.0, 32.0), help="m")
    parser.add_argument("--min-cell", type=float, default=2.0, help="m")
    parser.add_argument("--altitude-max", type=float, default=20.0, help="m")
    parser.add_argument("--attempts", type=int, default=64)
    arguments = parser.parse_args()
    scene = load(arguments.scene, None)
    print("| largest cell, m | cells | coverage | processor, s | faces a set | overestimate ", end="")
    print("| hops | m | first set, bytes | bytes a metre |\n|---|---|---|---|---|---|---|---|---|---|")
    for size in arguments.sizes:
        r = measure(scene, size, arguments)
        print(
            f"| {r.size:g} | {r.cells:,} | {100 * r.coverage:.1f}% | {r.seconds:,.0f} | {r.listed:,.0f} |"
            f" {r.overestimate:.3f} | {r.hops} | {r.metres:.0f} | {r.first:,} | {r.bytes_a_metre:,.0f} |",
            flush=True,
        )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
