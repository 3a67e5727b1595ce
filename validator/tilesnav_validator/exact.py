"""Deciding in exact arithmetic whether a ray is a witness that a face is visible from a cell.

A face T is visible from the open interior C of a cell when there are c in C and t in the relative interior
of T such that the half-open segment [c, t) meets no other face that is not porous, c lies before the front
of T if that is one-sided, and the segment is shorter than the range if there is one; degenerate faces neither
are visible nor block.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import lcm

import numpy as np
from numpy.typing import NDArray

from tilesnav_validator.subject import Faces

Vector = tuple[int, int, int]
Rational = tuple[Fraction, Fraction, Fraction]
Triangle = tuple[Vector, Vector, Vector]


@dataclass(frozen=True)
class Witness:
    """A point of the cell that sees a point of the face.

    Attributes
    ----------
    c, t : tuple of three Fraction
        Nav frame, metres.
    """

    cell: int
    face: int
    c: Rational
    t: Rational


def _minus(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _dot(a: Vector, b: Vector) -> int:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@dataclass(frozen=True)
class Ray:
    """A ray in integers; ``scale`` of them are a grid step.

    Attributes
    ----------
    origin, direction : tuple of three int
    """

    origin: Vector
    direction: Vector
    scale: int

    def triangle(self, grid: NDArray[np.int64]) -> Triangle:
        """Corners of a face relative to the origin of the ray, from grid steps, shape (3, 3)."""
        a, b, c = (
            tuple(int(x) * self.scale - o for x, o in zip(row, self.origin, strict=True)) for row in grid
        )
        return a, b, c  # type: ignore[return-value]


def make_ray(c: NDArray[np.float64], direction: NDArray[np.float64], step: float) -> Ray:
    """Return the ray from ``c`` (metres) along ``direction`` without rounding."""
    in_steps = [Fraction(float(x)) / Fraction(step) for x in c]
    along = [Fraction(float(x)) for x in direction]
    scale = lcm(*(x.denominator for x in in_steps))
    stretch = lcm(*(x.denominator for x in along))
    origin = tuple(int(x * scale) for x in in_steps)
    return Ray(origin, tuple(int(x * stretch) for x in along), scale)  # type: ignore[arg-type]


def pierces(ray: Ray, triangle: Triangle) -> Fraction | None:
    """Parameter at which a ray crosses the relative interior of a triangle, None where it does not or runs
    along it."""
    weights = _weights(ray.direction, triangle)
    if all(w > 0 for w in weights) or all(w < 0 for w in weights):
        normal = _normal(triangle)
        at = Fraction(_dot(triangle[0], normal), _dot(ray.direction, normal))
        return at if at > 0 else None
    return None


def meets(ray: Ray, triangle: Triangle, end: Fraction) -> bool:
    """Whether the points of a ray with parameters in [0, end) meet a closed triangle that is not
    degenerate."""
    normal = _normal(triangle)
    slope, height = _dot(ray.direction, normal), _dot(triangle[0], normal)
    if slope == 0:
        return height == 0 and _meets_in_plane(ray.direction, triangle, normal, end)
    at = Fraction(height, slope)
    if not 0 <= at < end:
        return False
    weights = _weights(ray.direction, triangle)
    return all(w >= 0 for w in weights) or all(w <= 0 for w in weights)


def _normal(triangle: Triangle) -> Vector:
    return _cross(_minus(triangle[1], triangle[0]), _minus(triangle[2], triangle[0]))


def _is_before(triangle: Triangle) -> bool:
    """Whether 0 lies where the corners of a triangle are seen to run counter-clockwise."""
    return _dot(triangle[0], _normal(triangle)) < 0


def _weights(direction: Vector, triangle: Triangle) -> tuple[int, int, int]:
    """On which side of each edge the line through 0 passes."""
    a, b, c = triangle
    return _dot(direction, _cross(b, c)), _dot(direction, _cross(c, a)), _dot(direction, _cross(a, b))


def _meets_in_plane(direction: Vector, triangle: Triangle, normal: Vector, end: Fraction) -> bool:
    """The case that the ray lies in the plane of the triangle: clip the segment by its three edges."""
    low, high, high_is_open = Fraction(0), end, True
    for index in range(3):
        corner = triangle[index]
        inward = _cross(normal, _minus(triangle[(index + 1) % 3], corner))
        slope, height = _dot(direction, inward), _dot(corner, inward)  # inside: slope * s >= height
        if slope == 0:
            if height > 0:
                return False
        elif slope > 0:
            low = max(low, Fraction(height, slope))
        elif Fraction(height, slope) < high:
            high, high_is_open = Fraction(height, slope), False
    return low < high or (low == high and not high_is_open)


def inside(c: NDArray[np.float64], planes: NDArray[np.float64]) -> bool:
    """Whether a point is strictly inside of all planes, shape (6, 4), without rounding."""
    point = [Fraction(float(x)) for x in c]
    for plane in planes:
        terms = [Fraction(float(n)) * x for n, x in zip(plane[:3], point, strict=True)]
        if sum(terms, Fraction(float(plane[3]))) >= 0:
            return False
    return True


def _near(faces: Faces, c: NDArray[np.float64], end: NDArray[np.float64], margin: float) -> NDArray[np.int64]:
    """Faces that may meet the segment from c to end: a filter in float64 that leaves out only what surely
    does not.

    Notes
    -----
    ``margin`` is half a grid step, 2^18 times the rounding of positions below 2^13 m. Sides of edges are
    triple products of lengths up to ``reach``, off by less than 2^-44 of ``reach`` cubed.
    """
    points = faces.points
    low, high = np.minimum(c, end) - margin, np.maximum(c, end) + margin
    boxes = ((points.min(axis=1) <= high) & (points.max(axis=1) >= low)).all(axis=1)
    near = np.flatnonzero(boxes & faces.blocking)
    corners = points[near] - c
    direction = end - c
    sides = np.stack(
        [np.cross(corners[:, (i + 1) % 3], corners[:, (i + 2) % 3]) @ direction for i in range(3)], axis=1
    )
    reach = np.abs(corners).max(axis=(1, 2), initial=0.0) + np.abs(direction).max()
    blur = (reach**3 * 2.0**-40)[:, None]
    apart = (sides > blur).any(axis=1) & (sides < -blur).any(axis=1)
    return np.asarray(near[~apart], dtype=np.int64)


@dataclass(frozen=True)
class Candidate:
    """A ray that a float32 ray caster says hits an unlisted face first.

    Attributes
    ----------
    c, direction : ndarray of float64, shape (3,)
        Nav frame; metres for ``c``. Taken as exact.
    """

    cell: int
    face: int
    c: NDArray[np.float64]
    direction: NDArray[np.float64]


def decide(
    candidate: Candidate,
    planes: NDArray[np.float64],
    faces: Faces,
    step: float,
    max_range: float | None = None,
) -> Witness | None:
    """Return the witness that a candidate is, or None.

    Parameters
    ----------
    candidate : Candidate
    planes : ndarray of float64, shape (6, 4)
        Planes of its cell.
    faces : Faces
    step : float
        Grid step in metres.
    max_range : float, optional
        Metres that the segment must be shorter than.
    """
    if not faces.sound[candidate.face] or not inside(candidate.c, planes):
        return None
    ray = make_ray(candidate.c, candidate.direction, step)
    target = ray.triangle(faces.grid[candidate.face])
    at = pierces(ray, target)
    if at is None or (faces.one_sided[candidate.face] and not _is_before(target)):
        return None
    metres = Fraction(step) / ray.scale
    if max_range is not None:
        length = _dot(ray.direction, ray.direction) * (at * metres) ** 2
        if length >= Fraction(max_range) ** 2:
            return None
    t = tuple((o + at * d) * metres for o, d in zip(ray.origin, ray.direction, strict=True))
    end = np.array([float(x) for x in t])
    for face in _near(faces, candidate.c, end, step / 2):
        if face != candidate.face and meets(ray, ray.triangle(faces.grid[face]), at):
            return None
    c = tuple(o * metres for o in ray.origin)
    return Witness(candidate.cell, candidate.face, c, t)  # type: ignore[arg-type]
