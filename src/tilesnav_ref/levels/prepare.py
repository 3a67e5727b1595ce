"""Arrays that a contraction begins with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.levels.surface import NONE, Surface

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

BORDER_WEIGHT = 4.0
"""Weight of the plane at right angles to a face through its border, against a face as large as the square
over the border: borders are few, and what is behind an opening is seen through it."""
SPACING = 8.0
"""Distance of samples on a face in multiples of the least bound; more are taken on larger faces only."""
PARTS = (3, 6)
"""Least and greatest number of parts that the edges of a face are divided into for its samples."""


def prepare(points: Floats, faces: Ints, bound: float) -> Surface:
    """Make the surface that edges are contracted in.

    Parameters
    ----------
    points : (V, 3) float64
        Grid coordinates.
    faces : (F, 3) int64
        With area.
    bound : float
        Grid steps; the least bound that will be asked for.
    """
    # Costs are differences of large numbers; near the origin they lose least.
    points = points - np.rint(points.mean(axis=0))
    fine = points[faces]
    samples, owner = _samples(fine, bound)
    heads, following = _chains(faces.ravel(), len(points))
    sample_heads, sample_following = _chains(owner, len(faces))
    return Surface(
        points=points,
        faces=faces.copy(),
        alive=np.ones(len(faces), np.bool_),
        heads=heads,
        following=following,
        samples=samples,
        sample_fine=owner,
        sample_heads=sample_heads,
        sample_following=sample_following,
        fine=fine,
        quadrics=_quadrics(points, faces),
    )


def _chains(keys: Ints, count: int) -> tuple[Ints, Ints]:
    """Lists of the positions of every key: the first one, and the next one of each."""
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    heads = np.full(count, NONE, np.int64)
    following = np.full(len(keys), NONE, np.int64)
    first = np.ones(len(keys), bool)
    first[1:] = ordered[1:] != ordered[:-1]
    heads[ordered[first]] = order[first]
    following[order[:-1]] = np.where(first[1:], NONE, order[1:])
    return heads, following


def _samples(fine: Floats, bound: float) -> tuple[Floats, Ints]:
    """Points on a lattice of every face, and the face of each."""
    longest = np.linalg.norm(fine - np.roll(fine, 1, axis=1), axis=2).max(axis=1)
    parts = np.clip(np.ceil(longest / (SPACING * bound)), *PARTS).astype(np.int64)
    points, owners = [], []
    for n in np.unique(parts):
        weights = np.array([(n - i - j, i, j) for i in range(n + 1) for j in range(n + 1 - i)]) / n
        chosen = np.flatnonzero(parts == n)
        points.append(np.einsum("sk,fkd->fsd", weights, fine[chosen]).reshape(-1, 3))
        owners.append(np.repeat(chosen, len(weights)))
    return np.concatenate(points), np.concatenate(owners)


def _quadrics(points: Floats, faces: Ints) -> Floats:
    """(V, 10) of every vertex: planes of its faces weighted by area, and of its borders."""
    corners = points[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(cross, axis=1)
    normals = cross / twice[:, None]
    quadrics = np.zeros((len(points), 10))
    terms = _plane_terms(normals, corners[:, 0], twice / 2)
    for k in range(3):
        np.add.at(quadrics, faces[:, k], terms)
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    keys = np.minimum(start, end) * len(points) + np.maximum(start, end)
    _, inverse, uses = np.unique(keys, return_inverse=True, return_counts=True)
    border = np.flatnonzero(uses[inverse] == 1)
    along = points[end[border]] - points[start[border]]
    length = np.linalg.norm(along, axis=1)
    across = np.cross(along, normals[border // 3]) / length[:, None]
    terms = _plane_terms(across, points[start[border]], BORDER_WEIGHT * length**2)
    np.add.at(quadrics, start[border], terms)
    np.add.at(quadrics, end[border], terms)
    return quadrics


def _plane_terms(normals: Floats, points: Floats, weights: Floats) -> Floats:
    """(N, 10) products of the coefficients of planes through points."""
    planes = np.concatenate((normals, -(normals * points).sum(axis=1, keepdims=True)), axis=1)
    i, j = np.triu_indices(4)
    return np.asarray(planes[:, i] * planes[:, j] * weights[:, None])
