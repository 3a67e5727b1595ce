"""Visibility by definition, in exact rational numbers; slow, and independent of the kernels."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from tilesnav_ref.scene.model import Scene

Point = tuple[Fraction, Fraction, Fraction]


def point(values: Any) -> Point:
    """Three numbers as fractions, exactly."""
    x, y, z = (Fraction(v) if isinstance(v, Fraction) else Fraction(float(v)) for v in values)
    return (x, y, z)


def minus(a: Point, b: Point) -> Point:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def dot(a: Point, b: Point) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Point, b: Point) -> Point:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def in_triangle(p: Point, triangle: Sequence[Point]) -> bool:
    """Whether a point of the triangle's plane lies in the closed triangle."""
    normal = cross(minus(triangle[1], triangle[0]), minus(triangle[2], triangle[0]))
    return all(
        dot(normal, cross(minus(triangle[(k + 1) % 3], triangle[k]), minus(p, triangle[k]))) >= 0
        for k in range(3)
    )


def half_open_meets(c: Point, t: Point, triangle: Sequence[Point]) -> bool:
    """Whether [c, t) meets the closed triangle."""
    normal = cross(minus(triangle[1], triangle[0]), minus(triangle[2], triangle[0]))
    at_c = dot(normal, minus(c, triangle[0]))
    at_t = dot(normal, minus(t, triangle[0]))
    if at_c == at_t:
        return at_c == 0 and _coplanar_meets(c, t, triangle, normal)
    s = at_c / (at_c - at_t)
    if not 0 <= s < 1:
        return False
    x, y, z = (a + s * (b - a) for a, b in zip(c, t, strict=True))
    return in_triangle((x, y, z), triangle)


def _coplanar_meets(c: Point, t: Point, triangle: Sequence[Point], normal: Point) -> bool:
    """Clip the parameter interval [0, 1) by the three edges."""
    low, high, open_high = Fraction(0), Fraction(1), True
    for k in range(3):
        edge = minus(triangle[(k + 1) % 3], triangle[k])
        at_c = dot(normal, cross(edge, minus(c, triangle[k])))
        slope = dot(normal, cross(edge, minus(t, triangle[k]))) - at_c
        if slope == 0:
            if at_c < 0:
                return False
        elif slope > 0:
            low = max(low, -at_c / slope)
        elif -at_c / slope < high:
            high, open_high = -at_c / slope, False
    return low < high or (low == high and not open_high)


def sees(scene: Scene, c: Point, t: Point, target: int) -> bool:
    """Whether [c, t) meets no face but the target."""
    triangles = [[point(v) for v in triangle] for triangle in scene.corners()]
    return all(i == target or not half_open_meets(c, t, triangle) for i, triangle in enumerate(triangles))


def visible_by(scene: Scene, c: Point, t: Point, target: int, max_range: Fraction | None = None) -> bool:
    """Whether a segment makes a face visible: free of what is opaque, before the front, within the range."""
    triangles = [[point(v) for v in triangle] for triangle in scene.corners()]
    v0, v1, v2 = triangles[target]
    if scene.one_sided[target] and dot(cross(minus(v1, v0), minus(v2, v0)), minus(c, v0)) <= 0:
        return False
    if max_range is not None and dot(minus(c, t), minus(c, t)) >= max_range**2:
        return False
    others = (triangle for i, triangle in enumerate(triangles) if i != target and not scene.porous[i])
    return not any(half_open_meets(c, t, triangle) for triangle in others)


def make_flagged(triangles: Any, porous: Any = (), one_sided: Any = ()) -> Scene:
    """A scene in which every face is an object, from (F, 3, 3) integer corners and numbers of faces."""
    plain = make_scene(triangles)
    count = len(plain.faces)
    numbers = np.arange(count, dtype=np.int32)
    flags = [np.isin(numbers, list(chosen)) for chosen in (porous, one_sided)]
    names = tuple(str(i) for i in numbers)
    return Scene(
        plain.vertices, plain.faces, numbers, np.zeros(count, np.int32), names,
        object_porous=flags[0], object_one_sided=flags[1],
    )  # fmt: skip


def make_scene(triangles: Any) -> Scene:
    """A scene of one object from (F, 3, 3) integer corners; equal corners are shared."""
    corners = np.asarray(triangles, np.int64).reshape(-1, 3)
    vertices, inverse = np.unique(corners, axis=0, return_inverse=True)
    faces = inverse.reshape(-1, 3).astype(np.int32)
    return Scene(vertices, faces, np.zeros(len(faces), np.int32), np.zeros(1, np.int32), ("soup",))
