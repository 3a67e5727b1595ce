"""From a simulated scan of the sample town to a mesh: faces, open edges, distances both ways.

    python benchmarks/planes_to_mesh.py [--points 3000000]

Prints JSON. Eight routes through and over the coarse town, every fourth turn of a VLP-16 with 2 cm of noise;
the given number of its returns, drawn at random.
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

from tilesnav_ref.planar.detect import detect_planes
from tilesnav_ref.planar.mesh import PlanarMesh, mesh_planes
from tilesnav_ref.scene import Scene
from tilesnav_ref.scene.sample import TownSettings, make_town
from tilesnav_ref.sensor import NO_FACE, Route, ScannerSettings, join, simulate_scans

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "unit"))
reference = importlib.import_module("planar_fixture")

SPEED = 2.0
"""Metres a second."""
EVERY = 4
NEAR = 100_000
"""Returns whose distance from the mesh is measured."""


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


def scan(town: Scene, count: int) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Points and the face of each."""
    points, faces = [], []
    for number, (route, roll) in enumerate(routes()):
        settings = ScannerSettings(range_noise=0.02, every=EVERY, seed=number, roll=roll)
        returns = join(simulate_scans(town, route, settings))
        hits = returns.faces != NO_FACE
        points.append(returns.points[hits])
        faces.append(returns.faces[hits])
    every, owner = np.concatenate(points), np.concatenate(faces)
    chosen = np.sort(np.random.default_rng(0).choice(len(every), min(count, len(every)), replace=False))
    return every[chosen], owner[chosen]


def open_share(mesh: PlanarMesh) -> tuple[float, float]:
    """Share of edges with one face, by number and by length."""
    edges = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, counts = np.unique(edges, axis=0, return_counts=True)
    lengths = np.linalg.norm(mesh.vertices[unique[:, 0]] - mesh.vertices[unique[:, 1]], axis=1)
    return float((counts == 1).mean()), float(lengths[counts == 1].sum() / lengths.sum())


def measure(count: int) -> dict[str, Any]:
    """Everything that is printed."""
    town = make_town(TownSettings(detail="coarse"))
    truth = town.corners() * town.step
    points, owner = scan(town, count)
    features = detect_planes(points)
    started = time.process_time()
    mesh = mesh_planes(points, features)
    seconds = time.process_time() - started
    corners = mesh.vertices[mesh.faces]
    on_mesh, _ = reference.sample_triangles(corners, 20.0, 0.0, 1)
    drawn = np.random.default_rng(1).choice(len(points), NEAR)
    triangles = truth[owner[drawn]]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    beside = np.einsum("nk,nk->n", points[drawn] - triangles[:, 0], normals)
    on_truth = points[drawn] - normals * beside[:, None]
    by_number, by_length = open_share(mesh)
    shares = (0.5, 0.95, 0.99, 1.0)
    return {
        "points": len(points),
        "planes": len(features),
        "faces": len(mesh.faces),
        "faces_of_truth": town.face_count,
        "faces_seen": len(np.unique(owner)),
        "open_by_number": round(by_number, 4),
        "open_by_length": round(by_length, 4),
        "mesh_to_truth": np.quantile(reference.distances_to_triangles(on_mesh, truth), shares)
        .round(4)
        .tolist(),
        "truth_to_mesh": np.quantile(reference.distances_to_triangles(on_truth, corners), shares)
        .round(4)
        .tolist(),
        "mesh_cpu_seconds": round(seconds, 2),
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=3_000_000)
    print(json.dumps(measure(parser.parse_args().points), indent=1))
