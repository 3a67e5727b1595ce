"""Signs of determinants of integers, exact: float64 with a bound first, integers for the rest."""

from __future__ import annotations

from itertools import starmap

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int64]
FloatArray = NDArray[np.float64]
SignArray = NDArray[np.int8]

BLUR = 2.0**-49
"""Bound of the relative error of a determinant computed in float64. Each of the six products of three entries
is rounded at most eight times, by 2^-53 at most each time: once for each entry, twice in multiplying, and at
most three times in adding. So the error is below 8.1 * 2^-53 times the sum of the magnitudes of the products;
this is 16 * 2^-53, which covers the rounding of that sum as well. The entries are integers below 2^63, so
nothing overflows or underflows."""

FITS = 2.0**61
"""Where the error is below this and the computed value is not beyond the error, the exact value is below
2^62, so that arithmetic modulo 2^64, that of int64, gives it exactly."""


def turn(ax: IntArray, ay: IntArray, bx: IntArray, by: IntArray) -> SignArray:
    """Sign of ``ax by - ay bx``, exact for ``|a| < 2^31`` and ``|b| < 2^56``.

    Notes
    -----
    The sum of the magnitudes of the products is below 2^88 and its rounding below 2^39, so that what float64
    leaves open always fits 64 bits. Products and difference are rounded five times at most.
    """
    left = ax.astype(np.float64) * by.astype(np.float64)
    right = ay.astype(np.float64) * bx.astype(np.float64)
    value = left - right
    sign = np.sign(value).astype(np.int8)
    unsure = np.abs(value) <= BLUR * (np.abs(left) + np.abs(right))
    if unsure.any():
        exact = ax * by - ay * bx
        sign = np.where(unsure, np.sign(exact), sign).astype(np.int8)
    return sign


def determinant(a: IntArray, b: IntArray, c: IntArray) -> SignArray:
    """Sign of the determinant of the rows a, b, c, exact for integers below 2^62 in magnitude.

    Parameters
    ----------
    a, b, c : ndarray of int64, shape (..., 3)
        They are broadcast against each other.

    Returns
    -------
    ndarray of int8, shape (...)
    """
    value, error = filtered(a.astype(np.float64), b.astype(np.float64), c.astype(np.float64))
    sign = np.sign(value).astype(np.int8)
    unsure = np.abs(value) <= error
    if unsure.any():
        rows = [np.broadcast_to(part, (*unsure.shape, 3))[unsure] for part in (a, b, c)]
        sign[unsure] = _settled(rows, error[unsure])
    return sign


def filtered(a: FloatArray, b: FloatArray, c: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Determinants of rows of rounded integers, and bounds of their errors."""
    value: FloatArray = np.zeros(())
    size: FloatArray = np.zeros(())
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        left, right = b[..., j] * c[..., k], b[..., k] * c[..., j]
        value = value + a[..., i] * (left - right)
        size = size + np.abs(a[..., i]) * (np.abs(left) + np.abs(right))
    return value, size * BLUR


def _settled(rows: list[IntArray], error: FloatArray) -> SignArray:
    """Signs of determinants whose magnitude is at most twice ``error``."""
    a, b, c = rows
    modulo = np.zeros(len(a), dtype=np.int64)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        modulo += a[:, i] * (b[:, j] * c[:, k] - b[:, k] * c[:, j])
    sign = np.sign(modulo).astype(np.int8)
    large = np.flatnonzero(error >= FITS)
    whole = starmap(_whole, zip(*(part[large].tolist() for part in rows), strict=True))
    sign[large] = [(value > 0) - (value < 0) for value in whole]
    return sign


def _whole(a: list[int], b: list[int], c: list[int]) -> int:
    """One determinant in integers of any size."""
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
