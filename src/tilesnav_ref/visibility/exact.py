"""Exact signs of determinants of integer-valued float64 coordinates.

All coordinates here are integers of magnitude below 2**29 held in float64, so differences are exact and
below 2**30. A float64 evaluation with a forward error bound decides nearly always; integers decide the rest.

References
----------
J. R. Shewchuk, Adaptive precision floating-point arithmetic and fast robust geometric predicates,
Discrete & Computational Geometry 18 (1997): the form of the static filter.
"""

from __future__ import annotations

import numpy as np

from tilesnav_ref.kernels import inner_kernel, kernel

Vector = tuple[float, float, float]

COORDINATE_BITS = 29
"""Magnitudes are below 2**COORDINATE_BITS."""

# The rounding error of the determinant below is at most (7 + 56 eps) eps times its permanent (Shewchuk,
# o3derrboundA, which even allows for rounded differences); 8 eps is above that.
DETERMINANT_ERROR = 8.0 * 2.0**-53

_LIMB_BITS = 31
_LIMB_MASK = (1 << _LIMB_BITS) - 1


@kernel
def exact_determinant_sign(u: Vector, v: Vector, w: Vector) -> int:
    """Sign of u . (v x w) in two limbs of int64.

    Notes
    -----
    |v x w| < 2**61 fits int64; it is cut into a high limb below 2**30 and a low limb below 2**31, so that
    each sum of three products with |u| < 2**30 stays below 2**63.
    """
    u0, u1, u2 = np.int64(u[0]), np.int64(u[1]), np.int64(u[2])
    v0, v1, v2 = np.int64(v[0]), np.int64(v[1]), np.int64(v[2])
    w0, w1, w2 = np.int64(w[0]), np.int64(w[1]), np.int64(w[2])
    c0 = v1 * w2 - v2 * w1
    c1 = v2 * w0 - v0 * w2
    c2 = v0 * w1 - v1 * w0
    high = u0 * (c0 >> _LIMB_BITS) + u1 * (c1 >> _LIMB_BITS) + u2 * (c2 >> _LIMB_BITS)
    low = u0 * (c0 & _LIMB_MASK) + u1 * (c1 & _LIMB_MASK) + u2 * (c2 & _LIMB_MASK)
    high += low >> _LIMB_BITS
    low &= _LIMB_MASK
    if high > 0:
        return 1
    if high < 0:
        return -1
    return 1 if low > 0 else 0


@inner_kernel
def determinant_sign(u: Vector, v: Vector, w: Vector) -> int:
    """Sign of u . (v x w), exact."""
    a, b = v[1] * w[2], v[2] * w[1]
    c, d = v[2] * w[0], v[0] * w[2]
    e, f = v[0] * w[1], v[1] * w[0]
    value = u[0] * (a - b) + u[1] * (c - d) + u[2] * (e - f)
    permanent = abs(u[0]) * (abs(a) + abs(b)) + abs(u[1]) * (abs(c) + abs(d)) + abs(u[2]) * (abs(e) + abs(f))
    bound = DETERMINANT_ERROR * permanent
    if value > bound:
        return 1
    if value < -bound:
        return -1
    if permanent == 0.0:
        return 0
    return int(exact_determinant_sign(u, v, w))


@inner_kernel
def difference(a: Vector, b: Vector) -> Vector:
    """a - b, exact."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@inner_kernel
def orientation(p: Vector, q: Vector, r: Vector, s: Vector) -> int:
    """Sign of (q - p) . ((r - p) x (s - p)): the side of the plane p, q, r on which s lies, exact.

    Examples
    --------
    >>> orientation((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    1
    """
    return int(determinant_sign(difference(q, p), difference(r, p), difference(s, p)))
