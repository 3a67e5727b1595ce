"""One table of speeds, each beside a peer in the same run.

Usage: python benchmarks/run.py [--rays N] [--repeat N]

Machines differ and are shared, so a speed alone says little; the ratio to the peer, measured a moment before
or after on the same mesh, says more. The best of the repeats counts. No test asserts a time.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from time import perf_counter

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
from numpy.typing import NDArray

from tilesnav_ref.cells.model import box_corners
from tilesnav_ref.cli import main as tilesnav
from tilesnav_ref.scene import SceneSettings, load_scene
from tilesnav_ref.stream.reader import NavTileset, open_tileset
from tilesnav_ref.visibility.geometry import build_geometry, fine_frame, to_fine
from tilesnav_ref.visibility.lines import cell_prisms
from tilesnav_ref.visibility.sampling import RayCaster
from tilesnav_ref.visibility.settings import VisibilitySettings
from tilesnav_ref.visibility.survey import Survey, run_survey

SEED = 1
SAMPLE = ("--detail", "median", "--size", "small")
RAYS_A_CELL = 20_000


@dataclass(frozen=True)
class Row:
    """One line of the table; rays a second."""

    name: str
    ours: float
    theirs: float


def best(repeat: int, work: Callable[[], object]) -> float:
    """Seconds of the fastest of several runs."""
    seconds = []
    for _ in range(repeat):
        begin = perf_counter()
        work()
        seconds.append(perf_counter() - begin)
    return min(seconds)


def corners_of(tileset: NavTileset) -> NDArray[np.float32]:
    """(F, 3, 3) corners of all faces, metres."""
    return np.concatenate([tileset.corners(content) for content in range(len(tileset.contents))])


def boxes_of(tileset: NavTileset) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(N, 3) lower and upper corners of the cells, which the encoder makes as boxes, metres."""
    planes = np.concatenate([sector.planes for sector in tileset.sectors])
    low = np.stack([planes[:, :, 3][planes[:, :, axis] == -1.0] for axis in range(3)], axis=1)
    high = -np.stack([planes[:, :, 3][planes[:, :, axis] == 1.0] for axis in range(3)], axis=1)
    return low, high


def plain_rays(tileset: NavTileset, rays: int, repeat: int) -> float:
    """Rays a second of Embree alone on one thread: random rays from random cells."""
    random = np.random.default_rng(SEED)
    low, high = boxes_of(tileset)
    chosen = random.integers(0, len(low), rays)
    origins = random.uniform(low[chosen], high[chosen]).astype(np.float32)
    directions = random.normal(size=(rays, 3)).astype(np.float32)
    scene = rtcore_scene.EmbreeScene()
    mesh = TriangleMesh(scene, corners_of(tileset))
    seconds = best(repeat, lambda: scene.run(origins, directions, query="INTERSECT"))
    del mesh  # Embree keeps no reference of its own
    return rays / seconds


def judged_rays(tileset: NavTileset, rays: int, repeat: int) -> float:
    """Rays a second of the validator's search, everything included, on one thread."""
    seconds = []
    for _ in range(repeat):
        command = [sys.executable, "-m", "tilesnav_validator", str(tileset.path), "--json"]
        command += ["--rays", str(rays), "--seed", str(SEED), "--threads", "1"]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        seconds.append(json.loads(done.stdout)["seconds"]["visibility"])
    return rays / float(min(seconds))


def sampled_rays(scene_file: Path, tileset: NavTileset, rays: int, repeat: int) -> float:
    """Rays a second of the encoder's sampling on one thread, with the exact test of every suggested face."""
    scene, _ = load_scene(scene_file, SceneSettings())
    cells = box_corners(*(np.rint(side / tileset.step).astype(np.int64) for side in boxes_of(tileset)))
    frame = fine_frame(scene.vertices.min(axis=0), scene.vertices.max(axis=0))
    geometry = build_geometry(scene, frame)
    caster = RayCaster(geometry, frame)
    chosen = np.random.default_rng(SEED).integers(0, len(cells), max(1, rays // RAYS_A_CELL))
    prisms = to_fine(cells[np.unique(chosen)], frame)
    settings = VisibilitySettings(rays=RAYS_A_CELL // 2, aimed_rounds=0, seed=SEED)
    nothing = tuple(np.zeros(0, np.int64) for _ in prisms)

    def work() -> None:
        seen = np.zeros((len(prisms), len(geometry.corners)), np.uint8)
        ids = np.arange(len(prisms))
        survey = Survey(geometry, caster, cell_prisms(prisms), ids, nothing, settings, seen)
        run_survey(survey, _one_after_the_other)

    work()  # kernels are compiled here
    return len(prisms) * RAYS_A_CELL / best(repeat, work)


def _one_after_the_other(work: Callable[[int], None], numbers: Iterable[int]) -> None:
    for number in numbers:
        work(number)


def measure(folder: Path, rays: int, repeat: int) -> list[Row]:
    """Encode the sample town and measure."""
    scene, out = folder / "town.ply", folder / "tileset"
    for command in (["sample", str(scene), *SAMPLE], ["encode", str(scene), str(out), "--quiet"]):
        if tilesnav(command) != 0:
            raise SystemExit(f"tilesnav {command[0]} failed")
    tileset = open_tileset(out)
    print(f"{tileset.face_count} faces, {tileset.cell_count} cells, {rays} rays, best of {repeat}\n")
    embree = plain_rays(tileset, rays, repeat)
    return [
        Row("validator's search, all in", judged_rays(tileset, rays, repeat), embree),
        Row("encoder's sampling with exact tests", sampled_rays(scene, tileset, rays, repeat), embree),
    ]


def machine() -> str:
    """Cores, Python and the libraries that matter."""
    libraries = ", ".join(f"{name} {version(name)}" for name in ("numpy", "numba", "embreex"))
    return f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}, {libraries}"


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Speeds beside a peer in the same run.")
    parser.add_argument("--rays", type=int, default=1_000_000)
    parser.add_argument("--repeat", type=int, default=3)
    given = parser.parse_args()
    print(machine())
    with tempfile.TemporaryDirectory() as name:
        rows = measure(Path(name), given.rays, given.repeat)
    print("| what, on one thread | ours, M rays/s | Embree alone, M rays/s | ratio |\n|---|---|---|---|")
    for row in rows:
        ours, theirs = row.ours / 1e6, row.theirs / 1e6
        print(f"| {row.name} | {ours:.2f} | {theirs:.2f} | {ours / theirs:.2f} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
