"""Cells by four methods for one scene, in one table: how many, how fast, and how much of the free space.

All methods share the domain, the smallest edge, the clearance, the choice of what is reachable, and the
points that measure the coverage. Times are those of a second run, so without compiling, and include the
coverage, which all methods measure alike.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scenes import TOWN, load

from tilesnav_ref.cells import CellSettings, decompose
from tilesnav_ref.cells.buckets import boxes_with_faces
from tilesnav_ref.cells.decomposition import faces_around
from tilesnav_ref.cells.domain import grid_sizes, make_domain, scene_ground
from tilesnav_ref.cells.heights import flood_space, measure_coverage
from tilesnav_ref.cells.mission import Mission
from tilesnav_ref.cells.portals import find_contacts, open_contacts
from tilesnav_ref.cells.prisms import prisms_of_boxes
from tilesnav_ref.cells.sectors import connected_within
from tilesnav_ref.cells.selection import start_cells
from tilesnav_ref.scene import Scene


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    method: str
    seconds: float
    cells: int
    coverage: float


def octree(scene: Scene, settings: CellSettings) -> tuple[int, float]:
    """Number and coverage of the free cubes of an octree over the domain: the peer.

    A cube of the largest edge is halved along all axes until it is free or its edge is the smallest. Cubes
    that reach over the upper end of the domain are kept if they are free, so that none is lost at the rim.
    """
    sizes = grid_sizes(settings, scene.step)
    ground = scene_ground(scene, settings)
    domain = make_domain(scene, settings, sizes, ground)
    edge = sizes.max_size
    covered = np.stack((domain[0], domain[0] + -(-(domain[1] - domain[0]) // edge) * edge))
    buckets = faces_around(scene, covered, sizes)
    lower = np.stack(
        np.meshgrid(*(np.arange(covered[0, k], covered[1, k], edge) for k in range(3)), indexing="ij"),
        axis=-1,
    ).reshape(-1, 3)
    found = []
    while len(lower) and edge >= sizes.min_size:
        cubes = np.stack((lower, lower + edge), axis=1)
        moved = np.stack((cubes[:, 0] - sizes.clearance, cubes[:, 1] + sizes.clearance), axis=1)
        occupied = boxes_with_faces(buckets, moved)
        found.append(cubes[~occupied])
        edge //= 2
        halves = np.array([[c & 1, c >> 1 & 1, c >> 2] for c in range(8)]) * edge
        lower = (lower[occupied][:, None] + halves).reshape(-1, 3)
        lower = lower[np.all(lower < domain[1], axis=1)]
    prisms = prisms_of_boxes(np.concatenate(found))
    context = (settings, sizes, scene.step)
    contacts = open_contacts(find_contacts(prisms), buckets if sizes.clearance == 0 else None)
    mission = Mission(settings, sizes, scene.step, ground)
    starts = start_cells(prisms, mission, (covered[None], domain), buckets, context)
    prisms = prisms[connected_within(contacts.pairs, starts, np.zeros((len(prisms), 2), np.int64))]
    flood = flood_space(buckets, (domain, domain), mission, context)
    return len(prisms), measure_coverage(prisms, (buckets, flood), domain, mission, context)[0]


def by_method(scene: Scene, settings: CellSettings) -> tuple[int, float]:
    """Number and coverage of the cells of the settings' method."""
    cells = decompose(scene, settings)
    return cells.count, cells.coverage


def measure(
    name: str, run: Callable[[Scene, CellSettings], tuple[int, float]], scene: Scene, settings: CellSettings
) -> Row:
    """One method, timed after it was compiled on few points."""
    run(scene, replace(settings, coverage_points=100))
    start = time.perf_counter()
    count, coverage = run(scene, settings)
    return Row(name, time.perf_counter() - start, count, coverage)


def print_table(rows: list[Row]) -> None:
    """The table in Markdown; the last column compares with the octree, which is the last row."""
    print("| method | seconds | cells | coverage | times fewer than the octree |")
    print("|---|---|---|---|---|")
    for row in rows:
        fewer = rows[-1].cells / row.cells
        print(f"| {row.method} | {row.seconds:.2f} | {row.cells:,} | {row.coverage:.2%} | {fewer:.1f} |")


def _numbers(text: str) -> tuple[float, ...]:
    return tuple(float(part) for part in text.split(","))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", nargs="?", default=TOWN, help="mesh file, or the sample town")
    parser.add_argument("--region", type=_numbers, metavar="X0,Y0,X1,Y1", help="part of the scene, m")
    parser.add_argument("--min-cell", type=float, default=CellSettings().min_size, metavar="M")
    parser.add_argument("--points", type=int, default=1_000_000, metavar="N", help="points of the coverage")
    parser.add_argument(
        "--prices", type=_numbers, default=(1.0, CellSettings().cell_price, 16.0), metavar="P,P,..."
    )
    given = parser.parse_args()
    scene = load(given.scene, None)
    settings = CellSettings(
        region=given.region, min_size=given.min_cell, voxel_size=given.min_cell, coverage_points=given.points
    )
    print(f"{scene.face_count:,} faces, smallest edge {settings.min_size:g} m\n")
    rows = [
        measure(f"prisms, price {price:g}", by_method, scene, replace(settings, cell_price=price))
        for price in given.prices
    ]
    for method in ("boxes", "voxel"):
        rows.append(measure(method, by_method, scene, replace(settings, method=method)))
    rows.append(measure("octree", octree, scene, settings))
    print_table(rows)


if __name__ == "__main__":
    main()
