"""Exact geometry in rational numbers: corners of cells, and which faces are visible from a cell.

Every pair of cell and face is settled by an argument, never by sampling alone: a face is visible because
one segment with rational ends reaches it, and hidden because of one of these statements.

Convex occluder
    Let W be a convex planar polygon made of faces, C on the one side of its plane and T on the other. The
    point where the segment from c to t meets the plane is a convex combination of the points where the
    segments between the corners of C and those of T meet it. So when all of those lie in W, every segment
    meets W.
Parts
    What is hidden from both halves of a cell is hidden from the cell, and a face both of whose halves are
    hidden is hidden, when the occluders touch neither the cell nor the face: the segments that are left out
    are limits of segments that meet one of them (Annex C, Subdivision).
Far side of a closed convex solid
    A segment that ends inside a facet of a solid and comes from the inner side of that facet's plane runs
    through the interior of the solid just before its end, so it has met the boundary of the solid before.

Occluders and solids are not porous. Two more statements leave no segment that counts: all corners of the cell
lie weakly behind the plane of a one-sided face, or boxes around cell and face are the range or more apart.
"""

from __future__ import annotations

import random
from fractions import Fraction
from functools import cache
from itertools import combinations

from casebuilder.world import Cell, Object, Point, Shape, Triangle, World

Vector = tuple[Fraction, Fraction, Fraction]
NOTHING: Vector = (Fraction(0), Fraction(0), Fraction(0))


def _sub(a: Vector | Point, b: Vector | Point) -> Vector:
    return (Fraction(a[0]) - b[0], Fraction(a[1]) - b[1], Fraction(a[2]) - b[2])


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _dot(a: Vector, b: Vector) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def orient(a: Vector | Point, b: Vector | Point, c: Vector | Point, p: Vector | Point) -> Fraction:
    """Six times the signed volume of a, b, c, p; positive when a, b, c run anticlockwise as seen from p."""
    return _dot(_cross(_sub(b, a), _sub(c, a)), _sub(p, a))


@cache
def cell_corners(cell: Cell, exponent: int) -> tuple[Vector, ...]:
    """Corners of a cell in grid steps, in no special order."""
    scale = Fraction(2) ** -exponent
    planes = [tuple(Fraction(v) for v in plane) for plane in cell.planes]
    corners: list[Vector] = []
    for a, b, c in combinations(planes, 3):
        normals = [(p[0], p[1], p[2]) for p in (a, b, c)]
        volume = _dot(_cross(normals[0], normals[1]), normals[2])
        if volume == 0:
            continue
        terms = [
            _cross(normals[1], normals[2]),
            _cross(normals[2], normals[0]),
            _cross(normals[0], normals[1]),
        ]
        weighted = list(zip((a, b, c), terms, strict=True))
        x, y, z = (-sum((p[3] * t[k] for p, t in weighted), Fraction(0)) / volume for k in range(3))
        point = (x, y, z)
        # Planes that meet in one corner by design are only as close as float64 rounding leaves them.
        if all(_dot((p[0], p[1], p[2]), point) + p[3] <= Fraction(1, 1 << 40) for p in planes):
            scaled = (point[0] * scale, point[1] * scale, point[2] * scale)
            if scaled not in corners:
                corners.append(scaled)
    return tuple(corners)


def _sides(outline: tuple[Point, ...], points: tuple[Vector | Point, ...]) -> list[Fraction]:
    return [orient(outline[0], outline[1], outline[2], p) for p in points]


def _inside_polygon(outline: tuple[Point, ...], point: Vector) -> bool:
    normal = _cross(_sub(outline[1], outline[0]), _sub(outline[2], outline[0]))
    edges = zip(outline, outline[1:] + outline[:1], strict=True)
    return all(_dot(_cross(_sub(b, a), _sub(point, a)), normal) >= 0 for a, b in edges)


def blocked_by(
    outline: tuple[Point, ...], corners: tuple[Vector, ...], face: tuple[Vector | Point, ...]
) -> bool:
    """Whether a convex polygon hides a face from the interior of a convex hull of corners."""
    from_cell, from_face = _sides(outline, corners), _sides(outline, face)
    if max(from_cell) > 0:
        from_cell, from_face = [-s for s in from_cell], [-s for s in from_face]
    if max(from_cell) > 0 or min(from_cell) == 0 or min(from_face) < 0 or max(from_face) == 0:
        return False
    for c, below in zip(corners, from_cell, strict=True):
        for t, above in zip(face, from_face, strict=True):
            if above == below:
                continue
            share = -below / (above - below)
            delta = _sub(t, c)
            if not _inside_polygon(
                outline, (c[0] + share * delta[0], c[1] + share * delta[1], c[2] + share * delta[2])
            ):
                return False
    return True


def behind_solid(solid: Object, shape: Shape, corners: tuple[Vector, ...]) -> bool:
    """Whether a hull of corners lies outside a convex solid and behind the plane of one of its facets."""
    outside = any(min(_sides(other.outline, corners)) >= 0 for other in solid.shapes)
    return outside and max(_sides(shape.outline, corners)) <= 0


def segment_is_free(c: Vector, t: Vector, others: tuple[Triangle, ...]) -> bool:
    """Whether [c, t) meets none of the other faces; a segment in general position only, else False."""
    for v0, v1, v2 in others:
        if _cross(_sub(v1, v0), _sub(v2, v0)) == NOTHING:
            continue
        start, end = orient(v0, v1, v2, c), orient(v0, v1, v2, t)
        if end == 0 and start != 0:
            continue
        if start * end > 0:
            continue
        if start == 0:
            return False
        turns = [orient(c, t, a, b) for a, b in ((v0, v1), (v1, v2), (v2, v0))]
        if min(turns) >= 0 or max(turns) <= 0:
            return False
    return True


def _mix(rng: random.Random, points: tuple[Vector | Point, ...]) -> Vector:
    # The cube lets some samples come close to a corner, where a narrow view may begin.
    weights = [rng.randint(1, 32) ** 3 for _ in points]
    total = sum(weights)
    weighted = list(zip(weights, points, strict=True))
    x, y, z = (sum((Fraction(w * p[k]) for w, p in weighted), Fraction(0)) / total for k in range(3))
    return (x, y, z)


def _square(vector: Vector) -> Fraction:
    return _dot(vector, vector)


def _is_far(corners: tuple[Vector, ...], face: Triangle, reach: Fraction) -> bool:
    """Whether the boxes around a cell and a face are the range or more apart."""
    gaps = [
        max(min(p[k] for p in a) - max(q[k] for q in b) for a, b in ((corners, face), (face, corners)))
        for k in range(3)
    ]
    x, y, z = (max(Fraction(gap), Fraction(0)) for gap in gaps)
    return _square((x, y, z)) >= reach**2


def _is_hidden(
    objects: tuple[Object, ...], corners: tuple[Vector, ...], number: int, reach: Fraction | None
) -> bool:
    faces = [(item, shape, t) for item in objects for shape in item.shapes for t in shape.triangles]
    owner, shape, face = faces[number]
    if owner.closed and not owner.porous and behind_solid(owner, shape, corners):
        return True
    if owner.one_sided and max(_sides(face, corners)) <= 0:
        return True
    if reach is not None and _is_far(corners, face, reach):
        return True
    outlines = (
        other.outline
        for item in objects
        for other in item.shapes
        if other.outline and other is not shape and not item.porous
    )
    return any(blocked_by(outline, corners, face) for outline in outlines)


def _counts(c: Vector, t: Vector, face: tuple[Object, Triangle], reach: Fraction | None) -> bool:
    """Whether a segment begins on a side and has a length that count."""
    owner, (v0, v1, v2) = face
    if owner.one_sided and orient(v0, v1, v2, c) <= 0:
        return False
    return reach is None or _square(_sub(t, c)) < reach**2


def halves_of_cell(
    corners: tuple[Vector, ...], axis: int
) -> tuple[tuple[Vector, ...], tuple[Vector, ...]] | None:
    """Corners of the parts of a box or a prism above and below the middles of its four edges along an axis;
    None where its corners are no such edges."""
    edges: dict[tuple[Fraction, ...], list[Vector]] = {}
    for corner in sorted(corners, key=lambda c: c[axis]):
        edges.setdefault((*corner[:axis], *corner[axis + 1 :]), []).append(corner)
    pairs = list(edges.values())
    if len(pairs) != 4 or any(len(pair) != 2 for pair in pairs):
        return None
    middles = [((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2) for a, b in pairs]
    above = tuple(corner for m, (_, b) in zip(middles, pairs, strict=True) for corner in (m, b))
    return above, tuple(corner for m, (a, _) in zip(middles, pairs, strict=True) for corner in (a, m))


def halves_of_face(face: Triangle, edge: int) -> tuple[tuple[Vector, ...], tuple[Vector, ...]]:
    """Triangles on either side of the middle of an edge, first that which keeps the start of the edge."""
    start, end = edge, (edge + 1) % 3
    exact = [_sub(corner, (0, 0, 0)) for corner in face]
    middle = tuple((a + b) / 2 for a, b in zip(exact[start], exact[end], strict=True))
    first, second = list(exact), list(exact)
    first[end] = second[start] = (middle[0], middle[1], middle[2])
    return tuple(first), tuple(second)


def _is_hidden_in_halves(objects: tuple[Object, ...], corners: tuple[Vector, ...], number: int) -> bool:
    parts = [(item, shape.outline, t) for item in objects for shape in item.shapes for t in shape.triangles]
    _, mine, face = parts[number]
    others = {outline for item, outline, _ in parts if outline and outline != mine and not item.porous}

    def blocked(some: tuple[Vector, ...], part: tuple[Vector | Point, ...]) -> bool:
        return any(blocked_by(outline, some, part) for outline in others)

    cells = [halves for axis in range(3) if (halves := halves_of_cell(corners, axis))]
    faces = [halves_of_face(face, edge) for edge in range(3)]
    return any(all(blocked(half, face) for half in halves) for halves in cells) or any(
        all(blocked(corners, half) for half in halves) for halves in faces
    )


@cache
def visible_faces(
    objects: tuple[Object, ...], cell: Cell, exponent: int, max_range: float | None = None
) -> tuple[int, ...]:
    """Numbers of exactly the faces that are visible from the interior of a cell, ascending.

    Raises
    ------
    ValueError
        When a face is neither reached by a segment nor hidden by one of the statements.
    """
    corners = cell_corners(cell, exponent)
    reach = None if max_range is None else Fraction(max_range) / Fraction(2) ** exponent
    faces = tuple((item, t) for item in objects for t in item.triangles)
    blocking = tuple((number, t) for number, (item, t) in enumerate(faces) if not item.porous)
    visible = []
    for number, (_, (v0, v1, v2)) in enumerate(faces):
        if _cross(_sub(v1, v0), _sub(v2, v0)) == NOTHING or _is_hidden(objects, corners, number, reach):
            continue
        others = tuple(t for other, t in blocking if other != number)
        rng = random.Random(number)
        tries = ((_mix(rng, corners), _mix(rng, (v0, v1, v2))) for _ in range(400))
        if not any(_counts(c, t, faces[number], reach) and segment_is_free(c, t, others) for c, t in tries):
            if _is_hidden_in_halves(objects, corners, number):
                continue
            raise ValueError(f"face {number} is neither seen nor proven hidden from {cell}")
        visible.append(number)
    return tuple(visible)


def world_pvs(world: World) -> list[list[int]]:
    """Visible faces of every cell."""
    return [
        list(visible_faces(world.objects, cell, world.exponent, world.max_range)) for cell in world.cells
    ]
