"""What a case is about: faces, cells and portals, before anything is derived from them."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction

Point = tuple[int, int, int]
"""Grid coordinates in the nav frame."""
Plane = tuple[float, float, float, float]
"""nx, ny, nz, d with the outward unit normal; inside is n.x + d <= 0, in metres."""
Triangle = tuple[Point, Point, Point]


@dataclass(frozen=True)
class Shape:
    """One or more triangles whose union is a convex planar polygon, or triangles without area."""

    triangles: tuple[Triangle, ...]
    outline: tuple[Point, ...] = ()
    """Corners in order; empty when the triangles have no area."""


@dataclass(frozen=True)
class Object:
    """A primitive of a content."""

    content: int
    shapes: tuple[Shape, ...]
    closed: bool = False
    """The shapes are the facets of a closed convex solid, with outlines anticlockwise from outside."""
    porous: bool = False
    one_sided: bool = False

    @property
    def triangles(self) -> tuple[Triangle, ...]:
        """Triangles in order."""
        return tuple(triangle for shape in self.shapes for triangle in shape.triangles)


@dataclass(frozen=True)
class Cell:
    """A polyhedron of planes."""

    planes: tuple[Plane, ...]
    kind: int = 0


@dataclass(frozen=True)
class Portal:
    """A passage both ways between two cells."""

    cells: tuple[int, int]
    polygon: tuple[tuple[float, float, float], ...]
    """Vertices in order, metres, nav frame."""


@dataclass(frozen=True)
class Lod:
    """The scale of level codes."""

    reference: float = 5.0
    base: float = 2.0
    level_count: int = 16


IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
QUARTER_TURN = (0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 100.0, 200.0, 10.0, 1.0)
"""A quarter turn about z and a shift, column-major: exact, and no two axes can be confused unnoticed."""


@dataclass(frozen=True)
class World:
    """Everything that an encoder would have found out, except what follows from it."""

    objects: tuple[Object, ...]
    cells: tuple[Cell, ...]
    portals: tuple[Portal, ...] = ()
    exponent: int = -10
    clearance: float = 0.25
    transform: tuple[float, ...] = QUARTER_TURN
    lod: Lod = field(default_factory=Lod)
    sector_sizes: tuple[int, ...] = ()
    """Number of cells of each sector; empty means one sector."""
    max_range: float | None = None
    """Metres that segments must be shorter than."""

    @property
    def faces(self) -> tuple[Triangle, ...]:
        """Triangles of all objects in the order of their face numbers."""
        return tuple(triangle for item in self.objects for triangle in item.triangles)

    @property
    def face_object(self) -> tuple[int, ...]:
        """Object of every face."""
        return tuple(i for i, item in enumerate(self.objects) for _ in item.triangles)

    @property
    def step(self) -> Fraction:
        """Grid step in metres."""
        return Fraction(2) ** self.exponent

    @property
    def sectors(self) -> tuple[tuple[int, int], ...]:
        """First cell and number of cells of every sector."""
        sizes = self.sector_sizes or (len(self.cells),)
        return tuple((sum(sizes[:i]), size) for i, size in enumerate(sizes))


def grid(value: float, exponent: int = -10) -> int:
    """Grid coordinate of a length in metres that must lie on the grid."""
    steps = Fraction(value) / Fraction(2) ** exponent
    if steps.denominator != 1:
        raise ValueError(f"{value} m is not a multiple of 2^{exponent} m")
    return int(steps)


def quad(*corners: tuple[float, float, float], exponent: int = -10) -> Shape:
    """Two triangles over a convex planar quadrilateral; corners in metres, in order."""
    points = [(grid(x, exponent), grid(y, exponent), grid(z, exponent)) for x, y, z in corners]
    a, b, c, d = points
    return Shape(((a, b, c), (a, c, d)), (a, b, c, d))


def box_shapes(lower: tuple[float, float, float], upper: tuple[float, float, float]) -> tuple[Shape, ...]:
    """The six facets of a box, anticlockwise from outside, in the order -x +x -y +y -z +z."""
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    return (
        quad((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)),
        quad((x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1)),
        quad((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)),
        quad((x0, y1, z0), (x0, y1, z1), (x1, y1, z1), (x1, y1, z0)),
        quad((x0, y0, z0), (x0, y1, z0), (x1, y1, z0), (x1, y0, z0)),
        quad((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)),
    )


def box_cell(lower: tuple[float, float, float], upper: tuple[float, float, float], kind: int = 0) -> Cell:
    """Cell of six axis planes."""
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    return Cell(
        (
            (-1.0, 0.0, 0.0, x0),
            (1.0, 0.0, 0.0, -x1),
            (0.0, -1.0, 0.0, y0),
            (0.0, 1.0, 0.0, -y1),
            (0.0, 0.0, -1.0, z0),
            (0.0, 0.0, 1.0, -z1),
        ),
        kind,
    )
