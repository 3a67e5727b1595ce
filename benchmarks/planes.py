"""Planar features of a made-up town: recall, precision, time and memory, beside peers.

    python benchmarks/planes.py [--points N] [--blocks X,Y] [--methods NAME,NAME] [--seeds N]

Every method runs in a process of its own on the same file of points, so that its memory can be told. Peers
are Open3D (pip install open3d-cpu), CGAL (pip install cgal; GPL) and scikit-learn; the table says which are
absent.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.clouds.synthetic import SyntheticSettings, synthetic_town
from tilesnav_ref.planar import PlaneSettings, detect_planes
from tilesnav_ref.planar.agreement import agreement

NOISE = 0.02
LIMIT = 600.0
"""Seconds after which a method is stopped."""
Labels = NDArray[np.int32]


def own(points: NDArray[np.float64], seed: int) -> Labels:
    """This encoder, nothing set."""
    return detect_planes(points, PlaneSettings(seed=seed)).labels


def open3d_patches(points: NDArray[np.float64], _seed: int) -> Labels:
    """Open3D's patches (Araujo and Oliveira 2020), set as in its tutorial; its boxes give labels."""
    import open3d  # noqa: PLC0415 - a peer that may be absent

    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    cloud.estimate_normals(open3d.geometry.KDTreeSearchParamKNN(16))
    boxes = cloud.detect_planar_patches(
        normal_variance_threshold_deg=60,
        coplanarity_deg=75,
        outlier_ratio=0.75,
        min_plane_edge_length=0.5,
        min_num_points=30,
        search_param=open3d.geometry.KDTreeSearchParamKNN(30),
    )
    labels = np.full(len(points), -1, np.int32)
    for number, box in enumerate(boxes):
        half = np.asarray(box.extent) / 2.0 + np.array((0.0, 0.0, 4.0 * NOISE))
        local = np.abs((points - box.center) @ np.asarray(box.R))
        labels[(local <= half).all(axis=1)] = number
    return labels


def cgal_ransac(points: NDArray[np.float64], _seed: int) -> Labels:
    """CGAL's efficient RANSAC (Schnabel, Wahl and Klein 2007); it takes no seed."""
    from CGAL.CGAL_Kernel import Point_3  # noqa: PLC0415 - a peer that may be absent
    from CGAL.CGAL_Point_set_3 import Point_set_3  # noqa: PLC0415
    from CGAL.CGAL_Point_set_processing_3 import jet_estimate_normals  # noqa: PLC0415
    from CGAL.CGAL_Shape_detection import efficient_RANSAC  # noqa: PLC0415

    cloud = Point_set_3()
    for x, y, z in points.tolist():
        cloud.insert(Point_3(x, y, z))
    cloud.add_normal_map()
    jet_estimate_normals(cloud, 16)
    found = cloud.add_int_map("shape")
    efficient_RANSAC(cloud, found, 30, 4.0 * NOISE, 0.6, 0.8, 0.01, True)
    labels = np.full(len(points), -1, np.int32)
    for index in cloud.indices():  # in an order of its own: the search sorts the points
        labels[index] = found.get(index)
    return labels


def scikit_ransac(points: NDArray[np.float64], seed: int) -> Labels:
    """scikit-learn's RANSAC, plane after plane, on what is left; z of x and y, so upright planes are lost."""
    from sklearn.linear_model import RANSACRegressor  # noqa: PLC0415 - a peer that may be absent

    labels = np.full(len(points), -1, np.int32)
    begin = time.perf_counter()
    for number in range(2000):
        left = np.flatnonzero(labels < 0)
        if len(left) < 1000 or time.perf_counter() - begin > LIMIT / 6:
            break
        fit = RANSACRegressor(residual_threshold=4.0 * NOISE, random_state=seed + number)
        fit.fit(points[left, :2], points[left, 2])
        labels[left[fit.inlier_mask_]] = number
    return labels


METHODS: dict[str, tuple[str | None, Callable[[NDArray[np.float64], int], Labels]]] = {
    "tilesnav": (None, own),
    "open3d": ("open3d", open3d_patches),
    "cgal": ("CGAL", cgal_ransac),
    "scikit-learn": ("sklearn", scikit_ransac),
}


def measure(name: str, file: Path, seed: int) -> dict[str, Any]:
    """Run a method here and return its figures."""
    data = np.load(file)
    points, truth = data["points"], data["labels"]
    if name == "tilesnav":  # compiles, once; a cache keeps it for later processes
        own(synthetic_town(SyntheticSettings(points=150_000, blocks=(1, 1))).points, 0)
    before = resource.getrusage(resource.RUSAGE_SELF)
    begin = time.perf_counter()
    labels = METHODS[name][1](points, seed)
    seconds = time.perf_counter() - begin
    after = resource.getrusage(resource.RUSAGE_SELF)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    used = np.unique(labels[labels >= 0])  # boxes may hold no point
    numbered = np.where(labels >= 0, np.searchsorted(used, labels), -1).astype(np.int32)
    score = agreement(numbered, truth)
    figures = {"seconds": seconds, "cpu": spent, "memory": after.ru_maxrss * 1024, "seed": seed}
    return {"method": name, **figures, "planes": len(used), **vars(score)}


def row(found: dict[str, Any]) -> str:
    """A line of the table."""
    shares = " | ".join(f"{found[key]:.4f}" for key in ("recall", "precision", "right"))
    times = f"{found['seconds']:.1f} | {found['cpu']:.1f} | {found['memory'] / 2**30:.2f}"
    return f"| {found['method']} (seed {found['seed']}) | {found['planes']} | {shares} | {times} |"


def main() -> None:
    """Make the town, run the methods and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=4_400_000)
    parser.add_argument("--blocks", default="6,5", help="blocks of four houses along x and y (6,5)")
    parser.add_argument("--methods", default=",".join(METHODS))
    parser.add_argument("--seeds", type=int, default=1, help="seeds of this encoder's samples (1)")
    parser.add_argument("--one", nargs=3, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one:
        print(json.dumps(measure(given.one[0], Path(given.one[1]), int(given.one[2]))))
        return
    across, along = (int(part) for part in given.blocks.split(","))
    town = synthetic_town(SyntheticSettings(points=given.points, blocks=(across, along), noise=NOISE))
    print(f"{len(town.points):,} points, {len(town.offsets):,} planes, noise {NOISE} m, 5 % outliers\n")
    print("| method | planes | recall | precision | points right | seconds | CPU seconds | GiB |")
    print("|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "town.npz"
        np.savez(file, points=town.points, labels=town.labels)
        for name in given.methods.split(","):
            for seed in range(given.seeds if name == "tilesnav" else 1):
                print(_apart(name, file, seed), flush=True)


def _apart(name: str, file: Path, seed: int) -> str:
    """Run a method in another process; return its line."""
    module = METHODS[name][0]
    if module is not None and importlib.util.find_spec(module) is None:
        return f"| {name} | absent | | | | | | |"
    command = [sys.executable, __file__, "--one", name, str(file), str(seed)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, check=False)
    except subprocess.TimeoutExpired:
        return f"| {name} | stopped after {math.ceil(LIMIT)} s | | | | | | |"
    if done.returncode:
        return f"| {name} | {(done.stderr.strip().splitlines() or ['failed'])[-1][:80]} | | | | | | |"
    return row(json.loads(done.stdout.strip().splitlines()[-1]))


if __name__ == "__main__":
    main()
