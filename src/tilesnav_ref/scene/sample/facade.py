"""Walls with windows, doors and passages."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from tilesnav_ref.scene.sample.canvas import Canvas, Point, Terrain
from tilesnav_ref.scene.sample.settings import UNIT

RECESS = 2 * UNIT
"""Depth of a window or door in the wall, 1/8 m."""
FRAME = UNIT
"""Width and further depth of a window frame, 1/16 m."""


@dataclass(frozen=True)
class Opening:
    """An opening between two columns lines and over some rows of a wall."""

    start: int
    """Grid steps along the wall."""
    end: int
    first_row: int
    last_row: int
    depth: int = RECESS
    """Grid steps; 0 draws neither reveal nor pane."""
    pane: bool = True
    """Whether it ends in a pane; else it is open there, and another wall has to have the same opening."""
    framed: bool = False


@dataclass(frozen=True)
class Wall:
    """A vertical rectangle on the ground, with openings.

    Notes
    -----
    It runs from `origin` along `direction`, with the building on its left. Cells between column and row
    lines are drawn one by one, so that openings have the corners of their neighbours.
    """

    origin: tuple[int, int]
    direction: tuple[int, int]
    """Unit vector along x or y."""
    length: int
    rows: tuple[int, ...]
    """Heights of the row lines above the ground row's foot; grid coordinates, ascending."""
    openings: tuple[Opening, ...] = ()
    setback: int = 0
    """Steps by which both ends are drawn shorter: inner walls use the columns of the outer wall that they
    belong to."""
    facing_in: bool = False
    """Inner walls are seen from the other side, and their openings are drawn by the outer wall."""
    inset: int = 0
    """Steps by which the wall lies to the left of its line."""


@dataclass(frozen=True)
class _Pen:
    """Draws in the plane of a wall."""

    canvas: Canvas
    terrain: Terrain
    wall: Wall

    def to(self, u: int, depth: int, z: int | None) -> Point:
        """The point u along the wall, depth into it and at height z, None for the ground."""
        (x, y), (dx, dy) = self.wall.origin, self.wall.direction
        depth += self.wall.inset
        x, y = x + dx * u - dy * depth, y + dy * u + dx * depth
        return (x, y, self.terrain.height(x) if z is None else z)

    def quad(self, *corners: tuple[int, int, int | None]) -> None:
        """Draw corners given as (u, depth, z)."""
        points = [self.to(*corner) for corner in corners]
        self.canvas.polygon(*(points[::-1] if self.wall.facing_in else points))


def draw_wall(canvas: Canvas, terrain: Terrain, wall: Wall) -> None:
    """Draw a wall and the reveals and panes of its openings."""
    ends = {wall.setback, wall.length - wall.setback}
    columns = tuple(sorted(ends | {u for o in wall.openings for u in (o.start, o.end)}))
    pen = _Pen(canvas, terrain, wall)
    levels: tuple[int | None, ...] = (None, *wall.rows)
    for start, end in pairwise(columns):
        for row in range(len(wall.rows)):
            if any(o.start <= start < o.end and o.first_row <= row <= o.last_row for o in wall.openings):
                continue
            low, high = levels[row], levels[row + 1]
            pen.quad((start, 0, low), (end, 0, low), (end, 0, high), (start, 0, high))
    if not wall.facing_in:
        for opening in (o for o in wall.openings if o.depth):
            low, high = levels[opening.first_row], levels[opening.last_row + 1]
            _draw_opening(pen, opening, low, high)


def _draw_opening(pen: _Pen, opening: Opening, low: int | None, high: int | None) -> None:
    a, b, depth = opening.start, opening.end, opening.depth
    _reveal(pen, (a, b), (low, high), (0, depth))
    if not opening.pane:
        return
    if opening.framed and low is not None and high is not None:
        c, d, inner_low, inner_high = a + FRAME, b - FRAME, low + FRAME, high - FRAME
        outer = ((a, low), (b, low), (b, high), (a, high))
        inner = ((c, inner_low), (d, inner_low), (d, inner_high), (c, inner_high))
        for i in range(4):
            (u0, z0), (u1, z1), (u2, z2), (u3, z3) = outer[i], outer[i - 3], inner[i - 3], inner[i]
            pen.quad((u0, depth, z0), (u1, depth, z1), (u2, depth, z2), (u3, depth, z3))
        a, b, low, high = c, d, inner_low, inner_high
        _reveal(pen, (a, b), (low, high), (depth, depth + FRAME))
        depth += FRAME
    pen.quad((a, depth, low), (b, depth, low), (b, depth, high), (a, depth, high))


def _reveal(
    pen: _Pen, columns: tuple[int, int], levels: tuple[int | None, int | None], depths: tuple[int, int]
) -> None:
    """The sides of an opening, and its sill where it does not stand on the ground."""
    (a, b), (low, high), (front, back) = columns, levels, depths
    pen.quad((a, front, low), (a, back, low), (a, back, high), (a, front, high))
    pen.quad((b, back, low), (b, front, low), (b, front, high), (b, back, high))
    pen.quad((a, back, high), (b, back, high), (b, front, high), (a, front, high))
    if low is not None:
        pen.quad((a, front, low), (b, front, low), (b, back, low), (a, back, low))
