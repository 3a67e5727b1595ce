"""Simulated scans brought together from disturbed poses: errors against the truth, and the time it takes.

Usage: python benchmarks/registration.py [--metres 0.5] [--degrees 2] [--every 10] [--seed 1]

A round of four streets of the sample town at its fine setting, a scan a second. Errors are those of poses
against the true ones, in the frame of the first scan. No test asserts a time.
"""

from __future__ import annotations

import argparse
from time import perf_counter, process_time

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tilesnav_ref.registration import RegistrationSettings, register
from tilesnav_ref.scene.sample import TRAINING_SITE, make_town
from tilesnav_ref.sensor import Route, Scan, ScannerSettings, simulate_scans

ROUTE = Route(((-25, -49, 1.8), (-25, 0, 1.8), (25, 0, 1.8), (25, -49, 1.8), (-25, -49, 1.8)))

HEAD = """| poses | median, mm | greatest, mm | median, deg | greatest, deg | CPU s |
|---|---|---|---|---|---|"""


def disturbed(scans: list[Scan], metres: float, degrees: float, seed: int) -> list[NDArray[np.float64]]:
    """True poses, but for the first with random motions: standard deviations in all three directions."""
    random = np.random.default_rng(seed)
    poses = [scans[0].nav_from_scanner]
    for scan in scans[1:]:
        motion = np.eye(4)
        turn = random.normal(size=3) * np.radians(degrees) / np.sqrt(3.0)
        motion[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
        motion[:3, 3] = random.normal(size=3) * metres / np.sqrt(3.0)
        poses.append(scan.nav_from_scanner @ motion)
    return poses


def errors(scans: list[Scan], poses: list[NDArray[np.float64]] | NDArray[np.float64]) -> str:
    """Millimetres and degrees, median and greatest."""
    away = [np.linalg.inv(scan.nav_from_scanner) @ pose for scan, pose in zip(scans, poses, strict=True)]
    lengths = np.linalg.norm([motion[:3, 3] for motion in away], axis=1) * 1000.0
    turns = np.degrees(Rotation.from_matrix(np.array([m[:3, :3] for m in away])).magnitude())
    places = f"{np.median(lengths):.1f} | {lengths.max():.1f}"
    return f"{places} | {np.median(turns):.3f} | {turns.max():.3f}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Registration of simulated scans.")
    for name, default in (("metres", 0.5), ("degrees", 2.0)):
        parser.add_argument(f"--{name}", type=float, default=default)
    for name, count in (("every", 10), ("seed", 1)):
        parser.add_argument(f"--{name}", type=int, default=count)
    given = parser.parse_args()
    begin = perf_counter()
    scans = list(simulate_scans(make_town(TRAINING_SITE), ROUTE, ScannerSettings(every=given.every, seed=5)))
    points = sum(len(scan.returns) for scan in scans)
    print(f"{len(scans)} scans, {points:,} points, made with the town in {perf_counter() - begin:.1f} s\n")
    print(HEAD)
    starts = disturbed(scans, given.metres, given.degrees, given.seed)
    print(f"| at the start | {errors(scans, starts)} | |")
    clouds = [(str(scan.number), scan.points_in_scanner()) for scan in scans]
    for name, rounds in (("growing map (small_gicp)", 0), ("and the adjustment", 12)):
        begin = process_time()
        found = register(clouds, starts, RegistrationSettings(rounds=rounds))
        print(f"| {name} | {errors(scans, found.map_from_scan)} | {process_time() - begin:.1f} |", flush=True)


if __name__ == "__main__":
    main()
