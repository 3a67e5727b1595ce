"""The scenes of the cases. Each is small enough to know by reasoning what is visible from where.

The ring: a wall stands on a ground; four cells run around it, west, south, north and east, so that the portal
graph has a cycle; a fifth lies above the east cell. A poster hangs just east of the wall, where the west cell
cannot see it. East of all stands a building, sunk one metre into the ground, whose far side and bottom no
cell sees and whose roof only the upper cell sees.
"""

from __future__ import annotations

from dataclasses import replace

from casebuilder.world import (
    IDENTITY,
    Cell,
    Lod,
    Object,
    Portal,
    Shape,
    World,
    box_cell,
    box_shapes,
    grid,
    quad,
)

WEST, SOUTH, NORTH, EAST, UPPER = range(5)

GROUND = Object(0, (quad((-8, -8, 0), (8, -8, 0), (8, 8, 0), (-8, 8, 0)),))
WALL = Object(0, (quad((0, -2, 0), (0, 2, 0), (0, 2, 4), (0, -2, 4)),))
POSTER = Object(0, (quad((0.125, -1, 0.5), (0.125, 1, 0.5), (0.125, 1, 2), (0.125, -1, 2)),))
BUILDING = Object(1, box_shapes((4, -1.5, -1), (6, 1.5, 3.5)), closed=True)
OBJECTS = (GROUND, WALL, POSTER, BUILDING)

RING_CELLS = (
    box_cell((-4, -4, 0.5), (-0.5, 4, 3)),
    box_cell((-0.5, -4, 0.5), (0.5, -2.5, 3)),
    box_cell((-0.5, 2.5, 0.5), (0.5, 4, 3)),
    box_cell((0.5, -4, 0.5), (3, 4, 3), kind=1),
    box_cell((0.5, -4, 3), (3, 4, 6)),
)


def x_portal(cells: tuple[int, int], x: float, y: tuple[float, float], z: tuple[float, float]) -> Portal:
    """Rectangle in a plane x = constant."""
    return Portal(cells, ((x, y[0], z[0]), (x, y[1], z[0]), (x, y[1], z[1]), (x, y[0], z[1])))


def z_portal(cells: tuple[int, int], z: float, x: tuple[float, float], y: tuple[float, float]) -> Portal:
    """Rectangle in a plane z = constant."""
    return Portal(cells, ((x[0], y[0], z), (x[1], y[0], z), (x[1], y[1], z), (x[0], y[1], z)))


RING_PORTALS = (
    x_portal((WEST, SOUTH), -0.5, (-4, -2.5), (0.5, 3)),
    x_portal((WEST, NORTH), -0.5, (2.5, 4), (0.5, 3)),
    x_portal((SOUTH, EAST), 0.5, (-4, -2.5), (0.5, 3)),
    x_portal((NORTH, EAST), 0.5, (2.5, 4), (0.5, 3)),
    z_portal((EAST, UPPER), 3, (0.5, 3), (-4, 4)),
)

RING = World(OBJECTS, RING_CELLS, RING_PORTALS)

SINGLE = World(
    (GROUND, WALL),
    (box_cell((1, -1, 0.5), (3, 1, 2)),),
    transform=IDENTITY,
)
"""One cell before a wall: the least tileset."""


def _triangle(*corners: tuple[float, float, float]) -> Shape:
    a, b, c = ((grid(x), grid(y), grid(z)) for x, y, z in corners)
    return Shape(((a, b, c),), (a, b, c))


SHEET = Object(0, (quad((-1, -1, 0.5), (-1, 1, 0.5), (-1, 1, 2), (-1, -1, 2)),))

HIDING = replace(SINGLE, objects=(GROUND, WALL, SHEET))
"""One cell before a wall that hides a sheet: the least tileset with something to prove."""

PIERCED = replace(
    HIDING,
    objects=(*HIDING.objects, Object(0, box_shapes((-1.25, -0.25, 1), (-0.75, 0.25, 1.5)), closed=True)),
)
"""The same with a post through the sheet, which the wall hides as well."""

LOOSE = replace(
    SINGLE,
    objects=(
        GROUND,
        WALL,
        Object(0, (quad((-1, -1, 0.5), (-2, 1, 0.5), (-2, 1, 2), (-1, -1, 2)),)),
        Object(0, (_triangle((-3, -0.25, 0.75), (-2.375, 1.875, 2), (-2.75, 0.5, 1.75)),)),
        Object(0, (_triangle((-2, 0.125, 0.75), (-1.375, -0.625, 3.625), (-2.75, 1, 1.125)),)),
        Object(0, (_triangle((-1.125, -1.5, 0.875), (-2.5, -0.375, 2.375), (-0.5, 1.25, 3.625)),)),
    ),
)
"""One cell before a wall that hides a slanted sheet and three loose triangles. No segment from the cell to
the first face of the sheet meets an edge of them. Each has an edge for which there is one reason alone: it
is beside all segments, or behind the plane of that face, or all segments pass its line on one side."""

CONTACT = replace(HIDING, clearance=0.0, cells=(box_cell((0, -1, 0.5), (3, 1, 2)),))
"""The same with a cell that touches the wall."""

FUSED = World(
    (
        GROUND,
        Object(0, (quad((0, -2, 1.125), (0, 2, 1.125), (0, 2, 3), (0, -2, 3)),)),
        Object(0, (quad((-1, -2, 0.5), (-1, 2, 0.5), (-1, 2, 2), (-1, -2, 2)),)),
        Object(0, (quad((-3, -0.5, 1), (-3, 0.5, 1), (-3, 0.5, 2), (-3, -0.5, 2)),)),
        Object(0, (_triangle((4, -0.5, 1.5), (4, 0.5, 0.5), (4, 0.5, 2.5)),)),
    ),
    (box_cell((1, -1, 0.5), (3, 1, 2.5)), box_cell((-2.5, -1, 1), (-2, 1, 2))),
)
"""Two walls, the high one in front of the low one, that hide something only together: a sheet from the first
cell, whose upper half the high wall screens and whose lower half the low one; and a triangle from the second
cell, the upper half of which is behind the high wall and the lower half behind the low one."""

TWO_SECTORS = replace(RING, sector_sizes=(3, 2))

SLANT = (0.6, 0.0, 0.8)
"""Normal of a plane that no axis is parallel to; its length is 1 within rounding."""


def _slanted_cells() -> tuple[Cell, ...]:
    planes = list(box_cell((0.5, -4, 3), (3, 4, 8)).planes)
    below = [*planes[:5], (SLANT[0], SLANT[1], SLANT[2], -4.3)]
    above = [*planes[:4], (-SLANT[0], -SLANT[1], -SLANT[2], 4.3), planes[5]]
    return (*RING_CELLS[:UPPER], Cell(tuple(below)), Cell(tuple(above)))


SLANTED = World(
    OBJECTS,
    _slanted_cells(),
    (*RING_PORTALS, Portal((4, 5), ((0.5, -4, 5), (3, -4, 3.125), (3, 4, 3.125), (0.5, 4, 5)))),
)
"""The upper cell cut in two by a slanted plane; the portal between its parts is not parallel to an axis."""

TOUCHING = replace(
    RING,
    objects=(GROUND, WALL, BUILDING),
    clearance=0.0,
    cells=(box_cell((-4, -4, 0.5), (0, 4, 3)), box_cell((0, -4, 0.5), (3, 4, 3))),
    portals=(),
)
"""Two cells that touch the wall from either side with no clearance, and no portal: the wall divides them."""

SPARE_BOX = ((-7.0, -7.0, 0.5), (-5.0, 7.0, 3.0))
"""Free space west of the ring, for a cell without portals."""


def with_spare(cell: Cell, world: World = RING) -> World:
    """World with one more cell behind the others."""
    return replace(world, cells=(*world.cells, cell))


def spare_box(
    lower: tuple[float, float, float] = SPARE_BOX[0], upper: tuple[float, float, float] = SPARE_BOX[1]
) -> World:
    """Ring with a box cell more."""
    return with_spare(box_cell(lower, upper))


def with_degenerate_face() -> World:
    """Ring whose poster begins with a triangle without area."""
    return with_segment(0.125, (-1, 0.5), (1, 2))


def with_segment(x: float, start: tuple[float, float], end: tuple[float, float]) -> World:
    """Ring whose poster begins with a triangle without area, between two points (y, z) at an x, metres."""
    middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
    a, b, c = ((grid(x), grid(y), grid(z)) for y, z in (start, middle, end))
    poster = replace(POSTER, shapes=(Shape(((a, b, c),)), *POSTER.shapes))
    return replace(RING, objects=(GROUND, WALL, poster, BUILDING))


def prism_with_tip(depth: float) -> Cell:
    """Triangular prism whose sixth plane cuts one corner off, at a distance from that corner in metres.

    The corner is a right angle of three planes, so the facet is an equilateral triangle of area
    3 sqrt(3) / 2 times the square of the distance.
    """
    s = 3**-0.5
    low = (-7.0, -7.0, 0.5)
    return Cell(
        (
            (-1.0, 0.0, 0.0, low[0]),
            (0.0, -1.0, 0.0, low[1]),
            (0.0, 0.0, -1.0, low[2]),
            (0.0, 0.0, 1.0, -3.0),
            (0.6, 0.8, 0.0, -(0.6 * -5.0 + 0.8 * -7.0)),
            (-s, -s, -s, s * sum(low) + depth),
        )
    )


def small_window(width: float, height: float) -> World:
    """Two cells behind each other that share a rectangle of a size in metres, and a portal there."""
    lower = box_cell((-7, -7, 0.5), (-6, 1, 2))
    upper = box_cell((-6, 1 - width, 2 - height), (-5, 7, 3))
    cells = (*RING_CELLS, lower, upper)
    portal = x_portal((5, 6), -6, (1 - width, 1), (2 - height, 2))
    return replace(RING, cells=cells, portals=(*RING_PORTALS, portal))


COARSE_LOD = Lod(5.0, 2.0, 1)
FINE_LOD = Lod(5.0, 1.06, 256)
