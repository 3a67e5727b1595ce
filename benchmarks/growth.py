"""How the time for a cell grows with the number of faces, and with the number of neighbouring cells.

Usage: python benchmarks/growth.py [--faces 10000,30000,70000,300000] [--cells 8,32,128] [--plot FILE.svg]

Sample towns of the same detail, each larger than the one before; the cells are those at its middle, below the
roofs. One thread; the best of the repeats counts. Beside each time stands that of 100,000 uniform Embree rays
a cell in the same run. No test asserts a time.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from time import process_time

from scenes import neighbouring_cells
from visibility import Sampler, numbers, timed

from tilesnav_ref.cells import CellSettings
from tilesnav_ref.scene import Scene
from tilesnav_ref.scene.sample import TownSettings, make_town
from tilesnav_ref.visibility import VisibilitySettings, compute_pvs
from tilesnav_ref.visibility.model import PvsTable

RAYS = 100_000
PITCH = 25
"""Metres; sides of towns are multiples of it."""
DENSITY = 1.95
"""Faces a square metre of a town of median detail, about."""


@dataclass(frozen=True)
class Point:
    """One measurement; means over the cells."""

    faces: int
    cells: int
    seconds: float
    sampling: float
    listed: float
    overestimate: float


def town(faces: int) -> Scene:
    """The town of median detail with about so many faces."""
    side = max(1, round((faces / DENSITY) ** 0.5 / PITCH))
    return make_town(TownSettings(detail="median", width=PITCH * side, depth=PITCH * side))


def measure(scene: Scene, count: int, arguments: argparse.Namespace) -> Point:
    """Time `count` neighbouring cells in the middle of a scene, one thread."""
    reach = arguments.reach
    region = CellSettings(
        region=(-reach, -reach, reach, reach),
        min_size=2.0,
        max_size=8.0,
        altitude_max=12.0,
        coverage_points=1000,
    )
    cells = neighbouring_cells(scene, region, count)
    settings = VisibilitySettings(threads=1, attempts=arguments.attempts)
    compute_pvs(scene, cells, VisibilitySettings(rays=10, aimed_rounds=0, attempts=1, leaf_segments=1))
    seconds, table = min(
        (_clocked(scene, cells, settings) for _ in range(arguments.repeat)), key=lambda pair: pair[0]
    )
    sampler = Sampler(scene, cells)
    sampling, _ = timed(arguments.repeat, lambda: sampler.uniform(RAYS))
    listed = len(table.pvs_faces)
    return Point(
        scene.face_count,
        cells.count,
        seconds / cells.count,
        sampling / cells.count,
        listed / cells.count,
        listed / max(1, int(table.pvs_proven.sum())),
    )


def _clocked(scene: Scene, cells, settings: VisibilitySettings) -> tuple[float, PvsTable]:  # type: ignore[no-untyped-def]
    begin = process_time()
    table = compute_pvs(scene, cells, settings)
    return process_time() - begin, table


def head() -> None:
    """Print the head of a table in Markdown."""
    print(f"| faces | cells | ms a cell | {RAYS:,} rays, ms a cell | ratio | faces listed | overestimate |")
    print("|---|---|---|---|---|---|---|", flush=True)


def show(p: Point) -> Point:
    """Print a row of the table as soon as it is there, and return it."""
    print(
        f"| {p.faces:,} | {p.cells} | {1e3 * p.seconds:,.0f} | {1e3 * p.sampling:,.0f} |"
        f" {p.seconds / p.sampling:.1f} | {p.listed:,.0f} | {p.overestimate:.3f} |",
        flush=True,
    )
    return p


def plot(by_faces: list[Point], by_cells: list[Point], path: Path) -> None:
    """Draw both growths."""
    from matplotlib import pyplot  # noqa: PLC0415 - an extra

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(9, 3.6))
    left.plot([p.faces for p in by_faces], [1e3 * p.seconds for p in by_faces], "o-", label="this encoder")
    left.plot(
        [p.faces for p in by_faces], [1e3 * p.sampling for p in by_faces], "s--", label=f"{RAYS:,} rays"
    )
    left.set(xscale="log", yscale="log", xlabel="faces of the town", ylabel="ms a cell, one thread")
    left.legend()
    right.plot([p.cells for p in by_cells], [1e3 * p.seconds for p in by_cells], "o-")
    right.set(xlabel="neighbouring cells", ylabel="ms a cell, one thread")
    right.set_xticks([p.cells for p in by_cells])
    right.set_ylim(0, 1.2e3 * max(p.seconds for p in by_cells))
    figure.tight_layout()
    figure.savefig(path, bbox_inches="tight", metadata={"Date": None})


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description="Growth of the time for a cell.")
    parser.add_argument("--faces", type=numbers(int), default=(10_000, 30_000, 70_000, 300_000))
    parser.add_argument("--cells", type=numbers(int), default=(8, 32, 128))
    parser.add_argument("--reach", type=float, default=30.0, help="half the side of the part with cells, m")
    parser.add_argument("--attempts", type=int, default=64)
    parser.add_argument("--repeat", type=int, default=2)
    parser.add_argument("--plot", type=Path, help="file to draw, .svg or .png; needs the extra 'bench'")
    arguments = parser.parse_args()
    head()
    by_faces = [show(measure(town(n), arguments.cells[1], arguments)) for n in arguments.faces]
    print()
    head()
    scene = town(arguments.faces[1])
    by_cells = [show(measure(scene, n, arguments)) for n in arguments.cells]
    if arguments.plot:
        plot(by_faces, by_cells, arguments.plot)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
