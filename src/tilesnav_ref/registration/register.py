"""Scans brought together into one frame."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tilesnav_ref.registration.adjust import adjust
from tilesnav_ref.registration.chain import grow
from tilesnav_ref.registration.motion import place, shift
from tilesnav_ref.registration.settings import RegistrationError, RegistrationSettings
from tilesnav_ref.registration.thin import Thinned, middles_of, thin

LEAST_HELD = 0.01
"""Where normals are 5 degrees wrong, as of noisy points a quarter of a metre apart, a bare corridor seems to
be held by as much as 0.008 along its way."""

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Registration:
    """Where scans lie, and how well they fit."""

    names: tuple[str, ...]
    map_from_scan: NDArray[np.float64]
    """(S, 4, 4) poses; the first is the one that it started with."""
    moved: NDArray[np.float64]
    """(S,) metres by which the middle of a scan has moved from where it started."""
    turned: NDArray[np.float64]
    """(S,) radians by which it has turned."""
    rms: NDArray[np.float64]
    """(S,) weighted root mean square distance of points of a scan from the planes of the others, metres."""
    matched: NDArray[np.float64]
    """(S,) share of the compared points that have a partner in another scan."""
    held: NDArray[np.float64]
    """(S,) mean square cosine between the normals of the planes and the direction that they fix least: 1/3
    where they face all ways alike, 0 where nothing holds the scan along a line (`LEAST_HELD`)."""
    rounds: int
    """Rounds of the adjustment."""


def register(
    scans: Iterable[tuple[str, NDArray[np.float64]]],
    starts: Sequence[NDArray[np.float64]] | None = None,
    settings: RegistrationSettings | None = None,
    progress: Progress | None = None,
) -> Registration:
    """Find the poses of scans in the frame of the first: a growing map, then an adjustment of all at once.

    Parameters
    ----------
    scans : iterable of (str, (N, 3) float64)
        Name and points in metres, each scan in its own frame; taken one by one, and thinned.
    starts : (S,) sequence of (4, 4) float64 or None
        Roughly where each scan lies; None: each lies where its coordinates say.
    settings : RegistrationSettings or None
    progress : callable or None
        Told the stage (grow, adjust), how much of it is done and how much there is.

    Raises
    ------
    RegistrationError
        Fewer than two scans, a start that is no rigid motion, or scans that do not overlap.

    Notes
    -----
    The same for the same scans on any machine of a kind; nothing is random. A scan that matches well at a
    wrong place, as in a row of equal houses, is not found out: starting poses have to be better than half
    a repetition.
    """
    settings, show = settings or RegistrationSettings(), progress or (lambda *_: None)
    names, thinned, origin = _thin_all(scans, settings)
    if len(names) < 2:
        raise RegistrationError("scans", f"{len(names)}", "2 or more")
    given = _starts(starts, len(names))
    # Coordinates of a country lie far from zero: near it, voxels fit their integers and turns their arms.
    base = np.round(place(given[0], origin))
    first = shift(-base) @ given @ shift(origin)
    grown = grow(names, thinned, first, settings, lambda done: show("grow", done, len(names)))
    result = adjust(thinned, grown, settings, lambda done: show("adjust", done, settings.rounds))
    moved = middles_of(thinned, result.poses) - middles_of(thinned, first)
    turned = Rotation.from_matrix(result.poses[:, :3, :3] @ first[:, :3, :3].transpose(0, 2, 1))
    return Registration(
        tuple(names),
        shift(base) @ result.poses @ shift(-origin),
        np.linalg.norm(moved, axis=1),
        turned.magnitude(),
        result.rms,
        result.matched,
        result.held,
        result.rounds,
    )


def _thin_all(
    scans: Iterable[tuple[str, NDArray[np.float64]]], settings: RegistrationSettings
) -> tuple[list[str], list[Thinned], NDArray[np.float64]]:
    """Names and thinned scans, all moved by the returned (3,) to near zero."""
    names: list[str] = []
    thinned: list[Thinned] = []
    origin = np.zeros(3)
    for name, points in scans:
        if not names:
            finite = points[np.isfinite(points).all(axis=1)]
            origin = np.round(finite.mean(axis=0)) if len(finite) else origin
        names.append(name)
        thinned.append(thin(name, points - origin, settings))
    return names, thinned, origin


def _starts(starts: Sequence[NDArray[np.float64]] | None, count: int) -> NDArray[np.float64]:
    if starts is None:
        return np.repeat(np.eye(4)[None], count, axis=0)
    if len(starts) != count:
        raise RegistrationError("starting poses", f"{len(starts)}", f"{count}, one a scan")
    poses = np.array(starts, np.float64)
    turns = poses[:, :3, :3]
    # 1e-5: six decimals of a quaternion in a text file, and some.
    rigid = np.abs(turns @ turns.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2)) < 1e-5
    rigid &= (np.linalg.det(turns) > 0) & np.isfinite(poses).all(axis=(1, 2))
    if not rigid.all():
        raise RegistrationError(f"starting pose {np.argmin(rigid) + 1}", "no rigid motion", "turn and shift")
    return poses
