"""Scans of a scene along a route, with the truth about each point.

Notes
-----
What it leaves out: the width of a beam (so no two returns of one ray), intensity, rain, and glass.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tilesnav_ref.scene import Scene
from tilesnav_ref.sensor.model import NO_FACE, Returns, Scan
from tilesnav_ref.sensor.rays import SceneRays
from tilesnav_ref.sensor.route import Route
from tilesnav_ref.sensor.settings import ScannerSettings


def simulate_scans(scene: Scene, route: Route, settings: ScannerSettings | None = None) -> Iterator[Scan]:
    """Scan a scene along a route, one turn after the other.

    Parameters
    ----------
    scene : Scene
    route : Route
        Of the middle of the scanner, metres, nav frame.
    settings : ScannerSettings or None
        None for the defaults.

    Yields
    ------
    Scan
        A turn that began before the end of the route, in order of time; at least one. One that returned
        nothing has no points.

    Notes
    -----
    All beams of a firing leave at once, and the scanner moves while it turns. The same for a seed on any
    number of threads: the random numbers of a scan follow from the seed and its number.
    """
    settings = settings or ScannerSettings()
    caster = SceneRays(scene)
    turn = settings.directions()
    for number in range(0, scan_count(route, settings), settings.every):
        yield _scan(scene, caster, route, (settings, turn), number)


def scan_count(route: Route, settings: ScannerSettings) -> int:
    """Turns that begin on a route, those left out counted."""
    # Without the margin a route of just n turns would sometimes have one more, by rounding.
    return max(1, math.ceil(route.duration * settings.rotation_rate - 1e-6))


def _scan(
    scene: Scene,
    caster: SceneRays,
    route: Route,
    scanner: tuple[ScannerSettings, NDArray[np.float64]],
    number: int,
) -> Scan:
    settings, turn = scanner
    begin = number / settings.rotation_rate
    times = begin + np.arange(settings.firings) / (settings.firings * settings.rotation_rate)
    places = route.positions(times)
    rotations = nav_from_scanner(route.headings(times), settings)
    directions = np.einsum("fij,fbj->fbi", rotations, turn).reshape(-1, 3)
    origins = np.repeat(places, settings.beams, axis=0)
    faces, ranges = caster.first_hits(origins, directions, settings.max_range)
    kept, measured, stray = _measure(ranges, settings, number)
    faces = np.where(stray, NO_FACE, faces[kept]).astype(np.int32)
    returns = Returns(
        points=origins[kept] + measured[:, None] * directions[kept],
        raw=(measured[:, None] * turn.reshape(-1, 3)[kept]).astype(np.float32),
        times=times[kept // settings.beams],
        scans=np.full(len(kept), number, np.int32),
        beams=(kept % settings.beams).astype(np.uint8),
        faces=faces,
        objects=np.where(stray, NO_FACE, scene.face_object[faces]).astype(np.int32),
        true_ranges=ranges[kept],
        places=origins[kept],
    )
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotations[0], places[0]
    return Scan(number, begin, pose, returns)


def _measure(
    ranges: NDArray[np.float64], settings: ScannerSettings, number: int
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.bool_]]:
    """(K,) rays that return, (K,) ranges with noise, (K,) whether they are outliers.

    All rays draw their random numbers, so those of a ray do not depend on what others meet.
    """
    random = np.random.default_rng((settings.seed, number))
    lost = random.random(len(ranges)) < settings.dropouts
    noise = random.normal(0.0, settings.range_noise, len(ranges))
    astray = random.random(len(ranges)) < settings.outliers
    anywhere = random.uniform(settings.min_range, settings.max_range, len(ranges))
    met = np.isfinite(ranges)
    measured = np.where(astray, anywhere, np.where(met, ranges, 0.0) + noise)
    in_reach = (measured >= settings.min_range) & (measured <= settings.max_range)
    kept = np.flatnonzero(met & ~lost & in_reach)
    return kept, measured[kept], astray[kept]


def nav_from_scanner(headings: NDArray[np.float64], settings: ScannerSettings) -> NDArray[np.float64]:
    """(N, 3, 3) float64 rotations of the scanner on its mount for headings (N,) in radians."""
    mount = Rotation.from_euler("YX", (settings.pitch, settings.roll), degrees=True)
    return np.asarray((Rotation.from_euler("z", headings[:, None]) * mount).as_matrix())
