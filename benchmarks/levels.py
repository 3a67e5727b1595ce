"""Faces and errors of coarse levels, and the time they take, beside the sample town's own coarser settings.

Usage: python benchmarks/levels.py [SCENE] [--errors 0.25,0.6] [--threads N] [--plot levels.png]

Errors are proven bounds of the two-sided distance from the finest level. Those of the town's own settings,
which no program has simplified, are measured by the same kernels, building by building. `--plot` needs the
extra `bench`. No test asserts a time.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from time import perf_counter

import numpy as np
from numpy.typing import NDArray
from scenes import TOWN, load

from tilesnav_ref.levels import LevelSettings, coarse_levels
from tilesnav_ref.levels.deviation import bound_distance
from tilesnav_ref.scene import Scene
from tilesnav_ref.scene.sample import TownSettings, make_town

FINENESS = 2.0**-4
"""Metres below which errors of the town's own settings are not told apart."""
SHOWN = ("block 0 house",)
"""Objects in the figure."""
LIGHT = np.array((0.35, -0.5, 0.79))
EYE = np.array((0.42, -0.79, 0.45))
"""Directions to them; the second has the length 1 within a hundredth."""


def name_of_building(name: str) -> str:
    """Name of an object without the number of its piece."""
    return name.partition("/")[0]


def line(level: str, scene: Scene, errors: NDArray[np.float64], seconds: float | None) -> str:
    """A row of the table; buildings are what is not called ground."""
    buildings = sorted({name_of_building(name) for name in scene.object_names if "ground" not in name})
    of_buildings = sum(
        int(count)
        for count, name in zip(np.bincount(scene.face_object), scene.object_names, strict=True)
        if "ground" not in name
    )
    took = "" if seconds is None else f"{seconds:.1f}"
    mean = of_buildings / max(len(buildings), 1)
    figures = (f"{np.median(errors):.3f}", f"{errors.max():.3f}", took)
    return " | ".join((f"| {level}", f"{scene.face_count:,}", f"{mean:.0f}", *figures)) + " |"


def own_errors(fine: Scene, other: Scene) -> NDArray[np.float64]:
    """Bounds of the two-sided distance of every building and ground of two settings of the town, m."""
    found = []
    for name in sorted({name_of_building(one) for one in fine.object_names}):
        sides = []
        for scene in (fine, other):
            chosen = [k for k, one in enumerate(scene.object_names) if name_of_building(one) == name]
            sides.append(scene.corners()[np.isin(scene.face_object, chosen)].astype(np.float64))
        if all(len(side) for side in sides):
            floor = FINENESS / fine.step
            pair = [bound_distance(*sides, floor), bound_distance(*sides[::-1], floor)]
            found.append(max(pair) * fine.step)
    return np.array(found)


def plot(path: Path, levels: list[tuple[str, Scene]]) -> None:
    """A few houses in every level."""
    from matplotlib import pyplot as plt  # noqa: PLC0415 - an extra
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # noqa: PLC0415

    figure = plt.figure(figsize=(13, 4))
    for number, (title, scene) in enumerate(levels):
        chosen = [k for k, name in enumerate(scene.object_names) if name.startswith(SHOWN)]
        corners = scene.corners()[np.isin(scene.face_object, chosen)] * scene.step
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        # Faces are drawn one over the other by their middles, so what is seen from behind would show through.
        front = normals @ EYE > 0
        corners, normals, count = corners[front], normals[front], len(corners)
        shade = 0.62 + 0.33 * (normals @ LIGHT) / np.linalg.norm(normals, axis=1)
        axes = figure.add_subplot(1, len(levels), number + 1, projection="3d")
        colours = np.repeat(np.clip(shade, 0, 1)[:, None], 3, axis=1) * (1.0, 0.97, 0.9)
        axes.add_collection3d(
            Poly3DCollection(corners, facecolors=colours, edgecolors="#5a5048", linewidths=0.25)
        )
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(0, high[2]))
        axes.set_box_aspect((high - (low[0], low[1], 0)), zoom=1.15)
        axes.view_init(*np.degrees((np.arcsin(EYE[2]), np.arctan2(EYE[1], EYE[0]))))
        axes.set_axis_off()
        axes.set_title(f"{title}, {count:,} faces", y=0.93)
    figure.subplots_adjust(0, 0, 1, 0.95, 0, 0)
    figure.savefig(path, dpi=120)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="?", default=TOWN, help="mesh file; the sample town when left out")
    parser.add_argument("--errors", default="0.25,0.6", help="metres of median and coarse level")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--plot", type=Path)
    given = parser.parse_args()
    fine = load(given.scene, None)
    errors = tuple(float(part) for part in given.errors.split(","))
    coarse_levels(make_town(TownSettings(width=25, depth=25)), LevelSettings(3))  # compile
    started = perf_counter()
    levels = coarse_levels(fine, LevelSettings(len(errors) + 1, errors), threads=given.threads)
    seconds = perf_counter() - started
    print("| level | faces | faces a building | median error, m | greatest error, m | s, all levels |")
    print("|---|---|---|---|---|---|")
    print(line("fine", fine, np.zeros(1), None))
    for level in levels:
        print(line(f"level {level.level}", level.scene, level.errors, seconds))
    if given.scene == TOWN:
        for detail in ("median", "coarse"):
            other = make_town(TownSettings(detail=detail, width=100, depth=100))
            print(line(f"the town's own {detail}", other, own_errors(fine, other), None))
    if given.plot:
        names = ("fine", "median", "coarse")
        plot(given.plot, list(zip(names, (fine, *(level.scene for level in levels)), strict=False)))


if __name__ == "__main__":
    main()
