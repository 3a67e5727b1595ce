"""Scans aligned one after the other to a growing map.

References
----------
A. Segal, D. Haehnel, S. Thrun: Generalized-ICP, Robotics: Science and Systems (2009).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.registration.motion import inverse, place
from tilesnav_ref.registration.settings import RegistrationError, RegistrationSettings
from tilesnav_ref.registration.thin import GICP_NEIGHBOURS, Thinned, gicp, middles_of

ITERATIONS = 60
"""Of GICP for an alignment; it ends before where a step is smaller than the next two."""
LEAST_TURN, LEAST_SHIFT = 1e-4, 1e-4
"""Radians and metres."""


def grow(
    names: list[str],
    scans: list[Thinned],
    starts: NDArray[np.float64],
    settings: RegistrationSettings,
    done: Callable[[int], None],
) -> NDArray[np.float64]:
    """Align each scan to the nearest of the scans before it.

    Parameters
    ----------
    names : list of str
        For errors.
    scans : list of Thinned
    starts : (S, 4, 4) float64
        Roughly where each scan lies. What moved a scan moves the start of the next one as well.
    settings : RegistrationSettings
    done : callable
        Told how many scans are aligned.

    Returns
    -------
    (S, 4, 4) float64 poses; the first as it was.

    Raises
    ------
    RegistrationError
        When too few points of a scan have a partner in the map.
    """
    poses = np.array(starts, np.float64)
    for k in range(1, len(scans)):
        start = poses[k - 1] @ inverse(starts[k - 1]) @ starts[k]
        poses[k], share = _align(scans, poses[:k], k, start, settings)
        if share < settings.least_overlap:
            raise RegistrationError(
                names[k],
                f"partners for {share:.0%} of its points within {settings.fine_reach:g} m",
                f"{settings.least_overlap:.0%} or more; better starting poses, a longer reach, or an order in"
                " which each scan overlaps one before it",
            )
        done(k + 1)
    return poses


def _align(
    scans: list[Thinned],
    poses: NDArray[np.float64],
    number: int,
    start: NDArray[np.float64],
    settings: RegistrationSettings,
) -> tuple[NDArray[np.float64], float]:
    """Pose of a scan and the share of its points that have a partner."""
    library, scan = gicp(), scans[number]
    away = middles_of(scans[:number], poses) - place(start, scan.points.mean(axis=0))
    near = np.argsort(np.linalg.norm(away, axis=1), kind="stable")[: settings.map_scans]
    points = np.concatenate([place(poses[k], scans[k].points) for k in sorted(near)])
    target, tree = library.preprocess_points(points, settings.voxel, GICP_NEIGHBOURS, 1)
    pose, share = start, 0.0
    for reach in (settings.reach, settings.fine_reach):
        found = library.align(
            target,
            scan.cloud,
            tree,
            pose,
            max_correspondence_distance=reach,
            num_threads=1,
            max_iterations=ITERATIONS,
            rotation_epsilon=LEAST_TURN,
            translation_epsilon=LEAST_SHIFT,
        )
        pose, share = np.array(found.T_target_source), found.num_inliers / scan.cloud.size()
    return pose, share
