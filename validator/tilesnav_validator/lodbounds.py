"""Bounds of the largest L = cos(phi) / d between a cell and a face, from both sides.

With r = p - x for a point p of the cell and a point x of the face, and n the unit normal, L = n.r / |r|^2.

Below: any pair of points. The point of the face is the nearest to p; p moves by pairwise Frank-Wolfe steps
with an exact line search. Above: for a unit vector u let s be the least u.r over the vertices of cell and
face. The set {r : n.r >= L |r|^2} is the ball of centre n / 2L and radius 1 / 2L; it reaches at most (u.n +
1) / 2L in the direction u. So when s > 0, no pair has an L greater than (1 + u.n) / 2s. At the optimum the
two bounds meet.

References
----------
Lacoste-Julien and Jaggi, On the global linear convergence of Frank-Wolfe optimization variants, 2015.
Ericson, Real-Time Collision Detection, 2005, section 5.1.5 (nearest point of a triangle).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

ROUNDING = 1e-9
"""Relative allowance on bounds: float64 sums of lengths below 2^14 m that differ by more than 2^-10 m keep
about 1e-9."""

SAFE_SUPPORT = 2.0**-32
"""Metres taken off every support, far above the rounding of differences below 2^14 m, far below the smallest
step."""


@dataclass(frozen=True)
class Pairs:
    """k pairs of a cell and one side of a face.

    Attributes
    ----------
    vertices : ndarray of float64, shape (k, v, 3)
        Vertices of the cells; some may be repeated.
    triangles : ndarray of float64, shape (k, 3, 3)
    normals : ndarray of float64, shape (k, 3)
        Unit normals, pointing to the side.
    """

    vertices: FloatArray
    triangles: FloatArray
    normals: FloatArray

    def at(self, index: IntArray) -> Pairs:
        """Some of the pairs."""
        return replace(
            self, vertices=self.vertices[index], triangles=self.triangles[index], normals=self.normals[index]
        )


def unit_normals(triangles: FloatArray) -> FloatArray:
    """Unit normals of triangles that are not degenerate, shape (k, 3)."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def nearest(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """Nearest points of triangles, shape (k, 3)."""
    edges = np.roll(triangles, -1, axis=1) - triangles
    offset = points[:, None] - triangles
    square = np.einsum("kei,kei->ke", edges, edges)
    along = np.einsum("kei,kei->ke", offset, edges) / np.where(square > 0, square, 1)
    on_edge = triangles + np.clip(along, 0, 1)[..., None] * edges
    away = points[:, None] - on_edge
    best = np.einsum("kei,kei->ke", away, away).argmin(axis=1)
    result = on_edge[np.arange(len(points)), best]
    normal = np.cross(edges[:, 0], edges[:, 1])
    inward = np.cross(normal[:, None], edges)
    inside = (np.einsum("kei,kei->ke", offset, inward) > 0).all(axis=1)
    norm2 = np.einsum("ki,ki->k", normal, normal)
    height = np.einsum("ki,ki->k", offset[:, 0], normal) / np.where(norm2 > 0, norm2, 1)
    return np.asarray(np.where(inside[:, None], points - height[:, None] * normal, result))


def _l(normals: FloatArray, r: FloatArray) -> FloatArray:
    """n.r / |r|^2, infinite for r = 0."""
    square = np.einsum("ki,ki->k", r, r)
    return np.where(square > 0, np.einsum("ki,ki->k", normals, r) / np.where(square > 0, square, 1), np.inf)


def rough(pairs: Pairs) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Cheap bounds, for most pairs enough.

    Returns
    -------
    low, high : ndarray of float64, shape (k,)
        Bounds of the largest L; both 0 where the cell is wholly on the other side.
    height : ndarray of float64, shape (k,)
        Greatest height of the cell above the plane of the face, metres.
    """
    base = pairs.triangles[:, :1]
    heights = np.einsum("kvi,ki->kv", pairs.vertices - base, pairs.normals)
    top, bottom = heights.max(axis=1), heights.min(axis=1)
    gap = np.maximum(
        pairs.vertices.min(axis=1) - pairs.triangles.max(axis=1),
        pairs.triangles.min(axis=1) - pairs.vertices.max(axis=1),
    )
    square = np.maximum((np.maximum(gap, 0) ** 2).sum(axis=1), np.maximum(bottom, 0) ** 2)
    some = square > 0
    square = np.where(some, square, 1)
    high = np.where(some, np.minimum(1 / np.sqrt(square), top / square), np.inf)
    r = pairs.vertices - pairs.triangles.mean(axis=1, keepdims=True)
    low = (heights / np.maximum((r**2).sum(axis=2), 1e-300)).max(axis=1)
    faces = top > 0
    return np.where(faces, np.maximum(low, 0), 0.0), np.where(faces, high * (1 + ROUNDING), 0.0), top


def _step(r: FloatArray, edge: FloatArray, normals: FloatArray, longest: FloatArray) -> FloatArray:
    """Where between 0 and ``longest`` n.(r + t e) / |r + t e|^2 is greatest, for an edge along which it
    rises."""
    a, b = np.einsum("ki,ki->k", normals, r), np.einsum("ki,ki->k", normals, edge)
    rr, re, ee = (np.einsum("ki,ki->k", x, y) for x, y in ((r, r), (r, edge), (edge, edge)))
    slope = b * rr - 2 * a * re
    root = 4 * (a * ee) ** 2 + 4 * b * ee * slope
    divisor = 2 * a * ee + np.sqrt(np.maximum(root, 0))
    t = np.where((root >= 0) & (divisor > 0), 2 * slope / np.where(divisor > 0, divisor, 1), longest)
    return np.clip(np.where(slope > 0, t, 0.0), 0.0, longest)


@dataclass(frozen=True)
class _State:
    """Points of the cells as weights of their vertices, with the bounds so far."""

    weights: FloatArray
    low: FloatArray
    high: FloatArray


def _improve(pairs: Pairs, state: _State) -> _State:
    """One step: nearest point of the face, both bounds, and a move of weight between two vertices of the
    cell."""
    p = np.einsum("kv,kvi->ki", state.weights, pairs.vertices)
    r = p - nearest(p, pairs.triangles)
    value = _l(pairs.normals, r)
    finite = np.where(np.isfinite(value), value, 0.0)
    u = 2 * finite[:, None] * r - pairs.normals
    u /= np.maximum(np.linalg.norm(u, axis=1, keepdims=True), 1e-300)
    along = np.einsum("kvi,ki->kv", pairs.vertices - pairs.triangles[:, :1], u)
    far = np.einsum("kti,ki->kt", pairs.triangles - pairs.triangles[:, :1], u).max(axis=1)
    support = along.min(axis=1) - far - SAFE_SUPPORT
    bound = (1 + np.einsum("ki,ki->k", u, pairs.normals)) / (2 * np.where(support > 0, support, 1))
    high = np.where(support > 0, np.minimum(state.high, np.maximum(bound, 0) * (1 + ROUNDING)), state.high)
    rows = np.arange(len(p))
    toward = along.argmin(axis=1)
    from_ = np.where(state.weights > 0, along, -np.inf).argmax(axis=1)
    edge = pairs.vertices[rows, toward] - pairs.vertices[rows, from_]
    t = _step(r, edge, pairs.normals, state.weights[rows, from_])
    weights = state.weights.copy()
    weights[rows, from_] -= t
    weights[rows, toward] += t
    return _State(weights, np.maximum(state.low, value), high)


def refine(pairs: Pairs, threshold: FloatArray, steps: int) -> tuple[FloatArray, FloatArray]:
    """Tighten the bounds until they tell on which side of a threshold the largest L is.

    Parameters
    ----------
    pairs : Pairs
        Cells must be above the faces somewhere.
    threshold : ndarray of float64, shape (k,)
    steps : int
        Most steps; what is undecided then keeps bounds on both sides.

    Returns
    -------
    low, high : ndarray of float64, shape (k,)
    """
    low, high, _ = rough(pairs)
    heights = np.einsum("kvi,ki->kv", pairs.vertices - pairs.triangles[:, :1], pairs.normals)
    r = pairs.vertices - pairs.triangles.mean(axis=1, keepdims=True)
    start = (heights / np.maximum((r**2).sum(axis=2), 1e-300)).argmax(axis=1)
    state = _State(np.eye(pairs.vertices.shape[1])[start], low.copy(), high.copy())
    open_ = np.arange(len(low))
    for _ in range(steps):
        state = _improve(pairs, state)
        low[open_], high[open_] = state.low, state.high
        keep = np.flatnonzero((state.low <= threshold[open_]) & (state.high > threshold[open_]))
        if len(keep) < len(open_):
            open_, pairs = open_[keep], pairs.at(keep)
            state = _State(state.weights[keep], state.low[keep], state.high[keep])
        if not len(open_):
            break
    return low, high
