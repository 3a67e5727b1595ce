"""From L to level codes.

Notes
-----
code = clamp(floor(log(reference / L) / log(base)), 0, level_count - 1). floor(...) >= k is the same as
L <= reference / base**k, so the code counts thresholds; with a reference and a base that are powers of two
the thresholds are exact, and a value on a threshold gets the larger code.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.kernels import kernel
from tilesnav_ref.lod.model import LodSettings


def check_settings(settings: LodSettings) -> None:
    """Refuse a scale that the file format does not allow.

    Raises
    ------
    ValueError
        reference <= 0, base <= 1, level_count outside 1 to 256, or a number that is not finite.
    """
    if not 0.0 < settings.reference < math.inf:
        raise ValueError(f"lod reference is {settings.reference}; allowed: greater than 0 and finite, 1/m")
    if not 1.0 < settings.base < math.inf:
        raise ValueError(f"lod base is {settings.base}; allowed: greater than 1 and finite")
    if not 1 <= settings.level_count <= 256:
        raise ValueError(f"lod level_count is {settings.level_count}; allowed: 1 to 256")


def thresholds(settings: LodSettings) -> NDArray[np.float64]:
    """Largest L of the codes 1, 2, ... level_count - 1; (level_count - 1,) float64, 1/m, descending."""
    check_settings(settings)
    steps = np.arange(1, settings.level_count, dtype=np.float64)
    with np.errstate(over="ignore", under="ignore"):
        return np.asarray(settings.reference / np.power(settings.base, steps))


@kernel
def count_thresholds(level: float, limits: NDArray[np.float64]) -> int:
    """Number of leading limits (descending) that a value does not exceed."""
    code = 0
    while code < len(limits) and level <= limits[code]:
        code += 1
    return code


def level_codes(levels: NDArray[np.float64], settings: LodSettings) -> NDArray[np.uint8]:
    """Codes of values of L.

    Parameters
    ----------
    levels
        (N,) float64, 1/m, 0 to infinity.
    settings
        Scale of the codes.

    Returns
    -------
    ndarray
        (N,) uint8.

    Raises
    ------
    ValueError
        A value is negative or not a number.
    """
    values = np.asarray(levels, dtype=np.float64)
    if not np.all(values >= 0.0):
        raise ValueError(f"L is {values[~(values >= 0.0)][0]}; allowed: 0 or greater, infinity included")
    ascending = thresholds(settings)[::-1]
    return (len(ascending) - np.searchsorted(ascending, values, side="left")).astype(np.uint8)
