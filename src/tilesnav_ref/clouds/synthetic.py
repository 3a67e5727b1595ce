"""Point clouds of a made-up town with the plane of every point known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.clouds.houses import Patches, Rectangle, add_house, uncovered

STREET = 10.0
"""Width of the streets around a block, m."""
LOT = 25.0
"""Edge of a lot; a block has 2 x 2 lots, m."""
KERB = 0.15
"""Height of a block above the streets, m."""


@dataclass(frozen=True)
class SyntheticSettings:
    """Size of the town and of its errors; lengths in metres.

    Parameters
    ----------
    points : int
        Points on surfaces and outliers together.
    blocks : tuple[int, int]
        Blocks of four houses along x and y.
    noise : float
        Standard deviation of every coordinate, m.
    outliers : float
        Share of the points that lie anywhere in the bounding box.
    yaw : float
        Turn of the town about z, radians: planes should not lie along the axes by chance.
    seed : int
    """

    points: int = 4_400_000
    blocks: tuple[int, int] = (6, 5)
    noise: float = 0.02
    outliers: float = 0.05
    yaw: float = 0.3
    seed: int = 0


@dataclass(frozen=True)
class SyntheticCloud:
    """Points in random order and the plane that each was taken from.

    Attributes
    ----------
    points : (N, 3) float64
        Metres, z up.
    labels : (N,) int32
        True plane, -1 for an outlier. Coplanar patches that do not touch are different planes.
    normals, offsets : (P, 3), (P,) float64
        True planes: ``normals[p] @ x + offsets[p] = 0``; normals look outwards.
    """

    points: NDArray[np.float64]
    labels: NDArray[np.int32]
    normals: NDArray[np.float64]
    offsets: NDArray[np.float64]


def synthetic_town(settings: SyntheticSettings) -> SyntheticCloud:
    """Sample a town of houses with flat, gabled and hipped roofs, dormers, parapets and annexes.

    Surfaces are sampled uniformly at random, outer sides only: no point lies under a house, a dormer or an
    annex. The same settings give the same cloud.
    """
    random = np.random.default_rng(settings.seed)
    patches = _town(settings.blocks, random)
    corners, plane = patches.triangles()
    turn = _about_z(settings.yaw)
    corners = corners @ turn.T
    bad = round(settings.points * settings.outliers)
    points, labels = sample_triangles(corners, plane, settings.points - bad, random)
    points += random.normal(0.0, settings.noise, points.shape)
    low, high = points.min(axis=0), points.max(axis=0)
    everywhere = random.uniform(low, high, (bad, 3))
    order = random.permutation(settings.points)
    points = np.concatenate((points, everywhere))[order]
    labels = np.concatenate((labels, np.full(bad, -1, np.int32)))[order]
    normals, offsets = _planes(corners, plane)
    return SyntheticCloud(points, labels, normals, offsets)


def sample_triangles(
    corners: NDArray[np.float64], plane: NDArray[np.int32], count: int, random: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Sample triangles uniformly by area.

    Parameters
    ----------
    corners : (T, 3, 3) float64
    plane : (T,) int32
        Label of each triangle.
    count : int
    random : numpy.random.Generator

    Returns
    -------
    (count, 3) float64 points and (count,) int32 labels, ordered by triangle.
    """
    sides = corners[:, 1:] - corners[:, :1]
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    ends = np.cumsum(areas)
    triangle = np.searchsorted(ends, np.sort(random.uniform(0.0, ends[-1], count)))
    share = random.uniform(size=(count, 2))
    outside = share.sum(axis=1) > 1.0
    share[outside] = 1.0 - share[outside]
    points = corners[triangle, 0] + (share[:, :, None] * sides[triangle]).sum(axis=1)
    return points, plane[triangle]


def _town(blocks: tuple[int, int], random: np.random.Generator) -> Patches:
    """Streets, blocks and houses, in metres; the middle of the town is the origin.

    Kerbs have no points: a side of 15 cm is too low for a plane of its own.
    """
    patches = Patches()
    edge = 2.0 * LOT
    width, depth = (n * (edge + STREET) + STREET for n in blocks)
    starts = [
        (-width / 2 + STREET + i * (edge + STREET), -depth / 2 + STREET + j * (edge + STREET))
        for i in range(blocks[0])
        for j in range(blocks[1])
    ]
    squares = [Rectangle(x, y, x + edge, y + edge) for x, y in starts]
    ground = patches.new_plane()
    for part in uncovered(Rectangle(-width / 2, -depth / 2, width / 2, depth / 2), squares):
        patches.flat(ground, part, 0.0)
    for square in squares:
        footprints = []
        for number in range(4):
            x = square.x0 + LOT * (number % 2)
            y = square.y0 + LOT * (number // 2)
            footprints += add_house(patches, Rectangle(x, y, x + LOT, y + LOT), KERB, random)
        block = patches.new_plane()
        for part in uncovered(square, footprints):
            patches.flat(block, part, KERB)
    return patches


def _about_z(angle: float) -> NDArray[np.float64]:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))


def _planes(
    corners: NDArray[np.float64], plane: NDArray[np.int32]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Plane of the first triangle of each label."""
    labels, first = np.unique(plane, return_index=True)
    first = first[labels >= 0]
    a, b, c = corners[first].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals, -np.einsum("pi,pi->p", normals, a)
