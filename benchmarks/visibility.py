"""Sets of cells by proof and by sampling: time, what is missed, what is too much.

Usage: python benchmarks/visibility.py [SCENE] [--region X0,Y0,X1,Y1] [--cells N] [--plot FILE.svg] ...

One run, one scene, the same cells, one thread. What is missed is counted against the faces that exact
segments prove visible, so it is a lower bound of what a method misses. The best of the repeats counts. No
test asserts a time.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
from numpy.typing import NDArray
from scenes import TOWN, load, neighbouring_cells

from tilesnav_ref.cells import CellSettings
from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.scene import Scene
from tilesnav_ref.visibility import VisibilitySettings, compute_pvs
from tilesnav_ref.visibility.model import PvsTable

SEED = 1
CHUNK = 1 << 18
"""Rays in one call."""

Found = list[NDArray[np.bool_]]
"""For each cell (F,): the faces that a method finds."""


@dataclass(frozen=True)
class Row:
    """One line of the table; numbers are means over the cells."""

    method: str
    seconds: float
    found: float
    missed: float
    wrong: float
    guarantee: str


class Sampler:
    """From-point sampling as it is usually done: float32, the first hit counts as visible."""

    def __init__(self, scene: Scene, cells: CellComplex) -> None:
        self.corners = np.ascontiguousarray(scene.corners() * scene.step, np.float32)
        self.cells = cells.corners * scene.step
        self._embree = rtcore_scene.EmbreeScene()
        self._mesh = TriangleMesh(self._embree, self.corners)

    def uniform(self, rays: int) -> Found:
        """Uniform positions and directions, `rays` for each cell."""
        return [self._uniform(cell, rays) for cell in range(len(self.cells))]

    def _uniform(self, cell: int, rays: int) -> NDArray[np.bool_]:
        random = np.random.default_rng([SEED, cell])
        found = np.zeros(len(self.corners), np.bool_)
        for begin in range(0, rays, CHUNK):
            number = min(CHUNK, rays - begin)
            directions = random.normal(size=(number, 3))
            hits = self._embree.run(self._points(random, cell, number), directions.astype(np.float32))
            found[hits[hits >= 0]] = True
        return found

    def centres(self, positions: int) -> Found:
        """Rays from some positions in the cell to the middle of every face."""
        return [self._centres(cell, positions) for cell in range(len(self.cells))]

    def _centres(self, cell: int, positions: int) -> NDArray[np.bool_]:
        random = np.random.default_rng([SEED, cell])
        found = np.zeros(len(self.corners), np.bool_)
        middles = self.corners.mean(axis=1)
        for point in self._points(random, cell, positions):
            origins = np.repeat(point[None], len(middles), axis=0)
            hits = self._embree.run(origins, middles - point)
            found |= hits == np.arange(len(middles))
        return found

    def _points(self, random: np.random.Generator, cell: int, number: int) -> NDArray[np.float32]:
        """Points between the corners of a cell, uniform in a box."""
        share = random.random((number, 3))
        weights = [np.where((i >> np.arange(3)) & 1, share, 1.0 - share).prod(axis=1) for i in range(8)]
        return np.asarray(np.stack(weights, axis=1) @ self.cells[cell], np.float32)


def timed(repeat: int, work: Callable[[], object]) -> tuple[float, object]:
    """Seconds of the fastest of several runs, and what the last one returned."""
    seconds, result = [], None
    for _ in range(repeat):
        begin = perf_counter()
        result = work()
        seconds.append(perf_counter() - begin)
    return min(seconds), result


def judge(method: str, seconds: float, found: Found, table: PvsTable) -> Row:
    """Compare with what is proven: visible faces that are missed, and hidden faces that are listed."""
    missed, wrong = [], []
    for cell, faces in enumerate(found):
        part = slice(*table.pvs_offsets[cell : cell + 2])
        listed = np.zeros(len(faces), np.bool_)
        listed[table.pvs_faces[part]] = True
        proven = table.pvs_faces[part][table.pvs_proven[part]]
        missed.append(np.count_nonzero(~faces[proven]))
        wrong.append(np.count_nonzero(faces & ~listed))
    count = len(found)
    return Row(
        method,
        seconds / count,
        float(np.mean([f.sum() for f in found])),
        float(np.mean(missed)),
        float(np.mean(wrong)),
        "none",
    )


def ours(scene: Scene, cells: CellComplex, repeat: int) -> tuple[Row, PvsTable]:
    """Our engine on one thread."""
    settings = VisibilitySettings(threads=1, seed=SEED)
    seconds, table = timed(repeat, lambda: compute_pvs(scene, cells, settings))
    assert isinstance(table, PvsTable)
    name = f"this encoder (overestimate at most {len(table.pvs_faces) / table.pvs_proven.sum():.3f})"
    return Row(name, seconds / cells.count, len(table.pvs_faces) / cells.count, 0, 0, "by proof"), table


def measure(scene: Scene, cells: CellComplex, arguments: argparse.Namespace) -> tuple[list[Row], PvsTable]:
    """All rows; kernels are compiled before the clock starts."""
    compute_pvs(scene, cells, VisibilitySettings(rays=10, aimed_rounds=0, attempts=1, leaf_segments=1))
    own, table = ours(scene, cells, arguments.repeat)
    sampler = Sampler(scene, cells)
    rows = [own]
    for rays in arguments.rays:
        seconds, found = timed(arguments.repeat, lambda n=rays: sampler.uniform(n))  # type: ignore[misc]
        rows.append(judge(f"{rays:,} uniform rays a cell", seconds, found, table))  # type: ignore[arg-type]
    for positions in arguments.positions:
        seconds, found = timed(arguments.repeat, lambda n=positions: sampler.centres(n))  # type: ignore[misc]
        name = f"rays to the middles of all faces from {positions} positions"
        rows.append(judge(name, seconds, found, table))  # type: ignore[arg-type]
    return rows, table


def show(rows: list[Row], table: PvsTable) -> None:
    """Print the table as Markdown."""
    proven = table.pvs_proven.sum() / (len(table.pvs_offsets) - 1)
    print("| method | ms a cell | faces | visible, missed | recall | hidden, listed | guarantee |")
    print("|---|---|---|---|---|---|---|")
    for row in rows:
        print(
            f"| {row.method} | {1e3 * row.seconds:,.0f} | {row.found:,.0f} | {row.missed:,.1f} |"
            f" {1 - row.missed / proven:.1%} | {row.wrong:,.2f} | {row.guarantee} |"
        )


def plot(rows: list[Row], path: Path) -> None:
    """Draw missed faces over time."""
    from matplotlib import pyplot  # noqa: PLC0415 - an extra

    figure, axes = pyplot.subplots(figsize=(7, 4))
    sampled = [row for row in rows[1:] if "uniform" in row.method]
    axes.plot([1e3 * r.seconds for r in sampled], [r.missed for r in sampled], "o-", label="uniform rays")
    centred = [row for row in rows[1:] if "uniform" not in row.method]
    axes.plot([1e3 * r.seconds for r in centred], [r.missed for r in centred], "s-", label="rays to middles")
    axes.plot([1e3 * rows[0].seconds], [0], "k*", markersize=12, label="this encoder")
    axes.set(xscale="log", xlabel="ms a cell, one thread", ylabel="visible faces missed, mean of a cell")
    axes.set_ylim(bottom=-0.02 * max(row.missed for row in rows))
    axes.legend()
    figure.savefig(path, bbox_inches="tight", metadata={"Date": None})


def numbers(kind: type) -> Callable[[str], tuple[float, ...]]:
    """Parser of numbers that are separated by commas."""
    return lambda text: tuple(kind(float(part)) for part in text.split(","))


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Sets by proof and by sampling.")
    parser.add_argument("scene", nargs="?", default=TOWN, help=f"mesh file, or {TOWN!r} (the default)")
    parser.add_argument("--region", type=numbers(float), help="X0,Y0,X1,Y1, m")
    parser.add_argument("--min-cell", type=float, default=4.0, help="m")
    parser.add_argument("--altitude-max", type=float, default=40.0, help="m")
    parser.add_argument("--cells", type=int, default=64, help="neighbouring cells")
    parser.add_argument("--rays", type=numbers(int), default=(10**4, 10**5, 10**6, 10**7))
    parser.add_argument("--positions", type=numbers(int), default=(1, 16, 256))
    parser.add_argument("--repeat", type=int, default=2)
    parser.add_argument("--plot", type=Path, help="file to draw, .svg or .png; needs the extra 'bench'")
    arguments = parser.parse_args()
    scene = load(arguments.scene, arguments.region)
    settings = CellSettings(
        region=arguments.region, min_size=arguments.min_cell, altitude_max=arguments.altitude_max
    )
    cells = neighbouring_cells(scene, settings, arguments.cells)
    print(f"{arguments.scene}: {scene.face_count:,} faces, {cells.count} cells, best of {arguments.repeat}\n")
    rows, table = measure(scene, cells, arguments)
    show(rows, table)
    if arguments.plot:
        plot(rows, arguments.plot)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
