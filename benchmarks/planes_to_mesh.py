"""From a simulated scan of the sample town to a mesh: faces, open edges, distances both ways.

    python benchmarks/planes_to_mesh.py [--detail coarse] [--noise 0.02] [--points 3000000]
    python benchmarks/planes_to_mesh.py --scene town.ply --cloud scan.ply

Prints JSON. Without a cloud: eight routes through and over the town of 50 m, every fourth turn of a VLP-16;
the given number of its returns, drawn at random. A cloud is a PLY that `tilesnav scan` wrote for that scene.
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tilesnav_ref.clouds.ply import TYPES
from tilesnav_ref.planar.detect import detect_planes
from tilesnav_ref.planar.mesh import PlanarMesh, mesh_planes
from tilesnav_ref.scene import Scene, SceneSettings, load_scene
from tilesnav_ref.scene.sample import TownSettings, make_town
from tilesnav_ref.sensor import NO_FACE, Route, ScannerSettings, join, simulate_scans

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "unit"))
reference = importlib.import_module("planar_fixture")

SPEED = 2.0
"""Metres a second."""
EVERY = 4
NEAR = 100_000
"""Returns whose distance from the mesh is measured."""
DENSITY = 20.0
"""Samples a square metre, of the mesh and of the truth."""
SEEN = 0.25
"""Metres: a sample of the truth was seen when a return of its own face is as near."""
BOUND = 0.03
"""Metres from the mesh within which a part of the truth is represented, as of the target."""
Cloud = tuple[NDArray[np.float64], NDArray[np.int32]]
"""Returns (N, 3), metres, and the face of each (N,)."""


def routes() -> list[tuple[Route, float]]:
    """Routes and the roll of the mount on each, degrees."""

    def loop(height: float, half: float) -> tuple[tuple[float, float, float], ...]:
        corners = ((-half, -half), (half, -half), (half, half), (-half, half))
        return (*((x, y, height) for x, y in corners), (-half, -half, height + 0.01))

    def streets(height: float) -> tuple[tuple[float, float, float], ...]:
        plan = ((-25, -24), (-25, 0), (25, 0), (25, 24), (0, 24), (0, -24), (24, -24.5))
        return tuple((float(x), float(y), height) for x, y in plan)

    along = ((-20, -20), (20, -12), (-20, -4), (20, 4), (-20, 12), (20, 20))
    across = ((-20, -20), (-12, 20), (-4, -20), (4, 20), (12, -20), (20, 20))
    ways = [
        (loop(2.0, 24.5), 0.0),
        (streets(2.0), 0.0),
        (streets(2.0), 90.0),
        (loop(12.0, 27.0), 0.0),
        (loop(26.0, 24.0), 90.0),
        (streets(28.0), 90.0),
        *((tuple((float(x), float(y), 28.0) for x, y in plan), 90.0) for plan in (along, across)),
    ]
    return [(Route(way, speed=SPEED), roll) for way, roll in ways]


def scan(town: Scene, noise: float) -> Cloud:
    """Scan a town along the routes."""
    points, faces = [], []
    for number, (route, roll) in enumerate(routes()):
        settings = ScannerSettings(range_noise=noise, every=EVERY, seed=number, roll=roll)
        returns = join(simulate_scans(town, route, settings))
        hits = returns.faces != NO_FACE
        points.append(returns.points[hits])
        faces.append(returns.faces[hits])
    return np.concatenate(points), np.concatenate(faces)


def read_scan(path: Path) -> Cloud:
    """Returns of a PLY file that `tilesnav scan` wrote."""
    with path.open("rb") as file:
        words = [line.decode().split() for line in iter(file.readline, b"end_header\n")]
        record = [(row[2], "<" + TYPES[row[1]]) for row in words if row[0] == "property"]
        returns = np.fromfile(file, np.dtype(record))
    returns = returns[returns["face"] != NO_FACE]
    return np.stack([returns[axis] for axis in "xyz"], axis=1), returns["face"]


def thinned(cloud: Cloud, count: int) -> Cloud:
    """Some of the returns, drawn at random."""
    chosen = np.random.default_rng(0).choice(len(cloud[0]), min(count, len(cloud[0])), replace=False)
    chosen.sort()
    return cloud[0][chosen], cloud[1][chosen]


def open_share(mesh: PlanarMesh) -> tuple[float, float]:
    """Share of edges with one face, by number and by length."""
    edges = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, counts = np.unique(edges, axis=0, return_counts=True)
    lengths = np.linalg.norm(mesh.vertices[unique[:, 0]] - mesh.vertices[unique[:, 1]], axis=1)
    return float((counts == 1).mean()), float(lengths[counts == 1].sum() / lengths.sum())


def represented(
    cloud: Cloud, truth: NDArray[np.float64], corners: NDArray[np.float64]
) -> tuple[float, float]:
    """Share of the area of the truth that was seen, and the part of it that is near to the mesh."""
    samples, face = reference.sample_triangles(truth, DENSITY, 0.0, 2)
    # A fourth axis keeps the faces apart: only returns of the same face count.
    spread = 10.0 * SEEN
    tree = cKDTree(np.column_stack((cloud[0], cloud[1] * spread)))
    away, _ = tree.query(np.column_stack((samples, face * spread)), distance_upper_bound=SEEN)
    seen = np.isfinite(away)
    near = reference.distances_to_triangles(samples[seen], corners) <= BOUND
    return round(float(seen.mean()), 4), round(float(near.mean()), 4)


def onto_faces(cloud: Cloud, truth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Some returns moved onto the planes of their faces: parts of the truth that were seen."""
    drawn = np.random.default_rng(1).choice(len(cloud[0]), NEAR)
    points, triangles = cloud[0][drawn], truth[cloud[1][drawn]]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    beside = np.einsum("nk,nk->n", points - triangles[:, 0], normals)
    return np.asarray(points - normals * beside[:, None])


def measure(town: Scene, cloud: Cloud) -> dict[str, Any]:
    """Everything that is printed."""
    truth = np.asarray(town.corners() * town.step, np.float64)
    started = time.process_time()
    features = detect_planes(cloud[0])
    found = time.process_time()
    mesh = mesh_planes(cloud[0], features)
    seconds = time.process_time() - found
    corners = mesh.vertices[mesh.faces]
    on_mesh, _ = reference.sample_triangles(corners, DENSITY, 0.0, 1)
    seen_faces = len(np.unique(cloud[1]))
    by_number, by_length = open_share(mesh)
    seen, near = represented(cloud, truth, corners)
    shares = (0.5, 0.95, 0.99, 1.0)
    to_truth = reference.distances_to_triangles(on_mesh, truth)
    to_mesh = reference.distances_to_triangles(onto_faces(cloud, truth), corners)
    return {
        "points": len(cloud[0]),
        "planes": len(features),
        "faces": len(mesh.faces),
        "faces_of_truth": town.face_count,
        "faces_seen": seen_faces,
        "open_by_number": round(by_number, 4),
        "open_by_length": round(by_length, 4),
        "mesh_to_truth": np.quantile(to_truth, shares).round(4).tolist(),
        "returns_to_mesh": np.quantile(to_mesh, shares).round(4).tolist(),
        "area_seen": seen,
        f"seen_area_within_{BOUND * 100:g}_cm": near,
        "planes_cpu_seconds": round(found - started, 2),
        "mesh_cpu_seconds": round(seconds, 2),
    }


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=3_000_000)
    parser.add_argument("--detail", default="coarse", help="of the town that is scanned")
    parser.add_argument("--noise", type=float, default=0.02, help="of its ranges, metres")
    parser.add_argument("--scene", type=Path, help="scene of a scan that is there")
    parser.add_argument("--cloud", type=Path, help="that scan, PLY")
    given = parser.parse_args()
    if (given.scene is None) != (given.cloud is None):
        parser.error("--scene and --cloud go together")
    if given.cloud is not None:
        town, _ = load_scene(given.scene, SceneSettings())
        cloud = read_scan(given.cloud)
    else:
        town = make_town(TownSettings(detail=given.detail))
        cloud = scan(town, given.noise)
    print(json.dumps(measure(town, thinned(cloud, given.points)), indent=1))


if __name__ == "__main__":
    main()
