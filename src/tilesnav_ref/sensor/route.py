"""The way that a scanner goes, and where it is at any time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.sensor.errors import ScanError, require

LEAST_STEP = 1e-6
"""Metres; waypoints that are nearer than this to the one before give no direction that can be trusted."""


@dataclass(frozen=True)
class Route:
    """Waypoints that are passed at a constant speed, looking where it goes.

    Notes
    -----
    The position runs along straight lines. The heading is that of the line in plan; at a waypoint it turns,
    the shorter way round, evenly over `turn_length` of the way, or half of the shorter line beside the
    waypoint where that is less. On a vertical line it stays as it was.
    """

    waypoints: tuple[tuple[float, float, float], ...]
    """Metres, nav frame; one waypoint is a scanner that stands still and looks along x."""
    speed: float = 5.0
    """Metres a second."""
    turn_length: float = 2.0
    """Metres of the way over which the heading turns at a waypoint."""

    def __post_init__(self) -> None:
        """Check every member.

        Raises
        ------
        ScanError
            Naming the member.
        """
        require(len(self.waypoints) >= 1, "route", self.waypoints, "one waypoint or more")
        for k, point in enumerate(self.waypoints):
            right = len(point) == 3 and all(map(math.isfinite, point))
            require(right, f"route, waypoint {k + 1}", point, "three finite numbers")
        short = np.flatnonzero(self._lengths < LEAST_STEP)
        if len(short):
            raise ScanError(
                f"route, waypoint {short[0] + 2}", "the same place again", "a place apart from the one before"
            )
        require(0 < self.speed < math.inf, "speed", self.speed, "more than 0 metres a second")
        require(0 <= self.turn_length < math.inf, "turn_length", self.turn_length, "0 or more metres")

    @cached_property
    def _points(self) -> NDArray[np.float64]:
        return np.array(self.waypoints, np.float64)

    @cached_property
    def _lengths(self) -> NDArray[np.float64]:
        return np.asarray(np.linalg.norm(np.diff(self._points, axis=0), axis=1))

    @property
    def length(self) -> float:
        """Metres from the first waypoint to the last."""
        return float(self._lengths.sum())

    @property
    def duration(self) -> float:
        """Seconds from the first waypoint to the last."""
        return self.length / self.speed

    def positions(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) float64 places at times (N,) in seconds; metres, nav frame. It waits at the end."""
        along = times * self.speed
        reached = np.concatenate(([0.0], np.cumsum(self._lengths)))
        return np.stack([np.interp(along, reached, self._points[:, k]) for k in range(3)], axis=1)

    def headings(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N,) float64 radians from x towards y at times (N,) in seconds."""
        places, angles = self._turns
        return np.asarray(np.interp(times * self.speed, places, angles))

    @cached_property
    def _turns(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Metres along the way, and the heading there; straight between."""
        steps = np.diff(self._points, axis=0)
        if not len(steps):
            return np.zeros(1), np.zeros(1)
        level = np.linalg.norm(steps[:, :2], axis=1) >= LEAST_STEP
        heading = np.arctan2(steps[:, 1], steps[:, 0])
        first = heading[np.argmax(level)] if level.any() else 0.0
        for k in np.flatnonzero(~level):
            heading[k] = heading[k - 1] if k else first
        heading = np.unwrap(heading)
        middle = np.cumsum(self._lengths)[:-1]
        half = np.minimum(self.turn_length, np.minimum(self._lengths[:-1], self._lengths[1:])) / 2.0
        places = np.stack((middle - half, middle + half), axis=1).ravel()
        angles = np.stack((heading[:-1], heading[1:]), axis=1).ravel()
        return (places, angles) if len(places) else (np.zeros(1), heading)
