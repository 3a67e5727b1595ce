"""Bytes over time: totals, means and windows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

WINDOW = 1.0
"""s; bandwidth is what came within this, ending at the time asked for."""


@dataclass(frozen=True)
class Series:
    """What a vehicle receives along a route, and what it holds then."""

    times: NDArray[np.float64]
    """(S,) s since the start, not descending; the first is 0."""
    sizes: NDArray[np.int64]
    """(S,) bytes received at each time."""
    held: NDArray[np.int64]
    """(S,) faces held from then on."""
    duration: float
    """s; not less than the last time."""

    @property
    def first(self) -> int:
        """Bytes of the start: all that comes at its first time."""
        return int(self.sizes[self.times <= self.times[0]].sum())

    @property
    def total(self) -> int:
        """Bytes of the whole way, the start included."""
        return int(self.sizes.sum())

    @property
    def mean(self) -> float:
        """Bytes a second on the way, without the start."""
        return (self.total - self.first) / self.duration

    @property
    def peak(self) -> float:
        """Bytes a second of the fullest window, without the start."""
        return float(self.rates(self.times).max())

    @property
    def mean_held(self) -> float:
        """Faces held, averaged over time."""
        spans = np.diff(np.append(self.times, self.duration))
        return float((self.held * spans).sum() / self.duration)

    def rates(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """(K,) bytes a second, without the start, within the window that ends at each of some times (K,)."""
        sizes = np.where(self.times <= self.times[0], 0, self.sizes)
        sums = np.concatenate(([0], np.cumsum(sizes)))
        until = np.searchsorted(self.times, times, side="right")
        before = np.searchsorted(self.times, times - WINDOW, side="right")
        return np.asarray((sums[until] - sums[before]) / WINDOW)

    def received(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """(K,) bytes received until each of some times (K,), the start included."""
        sums = np.concatenate(([0], np.cumsum(self.sizes)))
        return np.asarray(sums[np.searchsorted(self.times, times, side="right")])

    def summary(self, length: float) -> dict[str, Any]:
        """Figures of a route of some length, m, as JSON values; kB are 1000 bytes."""
        return {
            "first_kB": self.first / 1e3,
            "total_kB": self.total / 1e3,
            "mean_kB_s": self.mean / 1e3,
            "peak_kB_s": self.peak / 1e3,
            "bytes_per_metre": (self.total - self.first) / length,
            "mean_faces_held": self.mean_held,
        }
