"""Free-standing walls in front of a cell: fusion, slots, gaps, junctions, doubled walls, a ridge."""

from __future__ import annotations

from fractions import Fraction

from tilesnav_ref.scene.analytic.case import STEPS, AnalyticScene, Answer, Drawing, Point

CELL: tuple[Point, Point] = ((-1, -1, -1), (1, 1, 1))
SIDE = (-20.0, 20.0)
GRID_STEP = 1 / STEPS


def _target(drawing: Drawing, name: str, y: float, x: tuple[float, float]) -> None:
    """A triangle at the height of the cell."""
    drawing.triangle(name, (x[0], y, -1), (x[1], y, -1), ((x[0] + x[1]) / 2, y, 1))


def one_wall() -> AnalyticScene:
    """One wall hides what is behind it, not what stands above its upper edge."""
    d = Drawing("one_wall", *CELL)
    d.wall_y("wall", 10, SIDE)
    _target(d, "behind", 12, (-1, 1))
    d.triangle("above", (-1, 12, 29), (1, 12, 29), (0, 12, 31))
    why = (
        "Segments to `behind` stay within x, z = -1 to 1 and cross y = 10 there, on the wall. The segment "
        "from the middle of the cell to (0, 12, 30) crosses y = 10 at z = 25, above the wall, which ends at "
        "20."
    )
    return d.finish(Answer("wall above", "behind", why))


def two_walls() -> AnalyticScene:
    """Two walls with a common edge hide together what neither hides alone."""
    d = Drawing("two_walls", *CELL)
    d.wall_y("left", 10, (-20, 0))
    d.wall_y("right", 10, (0, 20))
    _target(d, "behind", 12, (-1, 1))
    why = (
        "Segments to `behind` cross y = 10 within x = -1 to 1, and the walls together cover x = -20 to 20; "
        "each covers one side of x = 0 only."
    )
    return d.finish(Answer("left right", "behind", why))


def two_walls_apart() -> AnalyticScene:
    """Two walls without a common point hide together: no segment is steep enough to pass between them."""
    d = Drawing("two_walls_apart", *CELL)
    d.wall_y("near", 10, (-20, 0))
    d.wall_y("far", 11, (-0.25, 20))
    _target(d, "behind", 30, (-1, 1))
    why = (
        "To pass, a segment needs x > 0 at y = 10 and x < -0.25 at y = 11, a change of more than 0.25 in 1. "
        "Segments to `behind` change x by less than 2 over more than 29. `far` has points with x > 0 on "
        "both its triangles, seen past the edge of `near` from the right part of the cell."
    )
    return d.finish(Answer("near far", "behind", why))


def slot() -> AnalyticScene:
    """A slot of 1/16 m shows what is in line with it and the cell, and nothing else."""
    d = Drawing("slot", *CELL)
    width = 1 / 16
    d.wall_y("left", 10, (-20, 0))
    d.wall_y("right", 10, (width, 20))
    _target(d, "in_line", 20, (-1, 1))
    _target(d, "aside", 20, (2, 3))
    why = (
        "The segment from the middle of the cell through the middle of the slot ends in `in_line`. A "
        "segment through the slot reaches y = 20 at x of at most 1/16 + (1/16 + 1) 10/9 < 1.25, so none "
        "reaches `aside`."
    )
    opening = (Fraction(STEPS, 32), Fraction(10 * STEPS), Fraction(0))
    return d.finish(Answer("left right in_line", "aside", why, opening))


def corner_gap() -> AnalyticScene:
    """A gap of a single grid step beside a corner still shows what is behind."""
    d = Drawing("corner_gap", *CELL)
    d.wall_y("front", 10, (-20, 0))
    d.wall_x("side", GRID_STEP, (10, 30))
    _target(d, "in_line", 20, (-2, -0.5))
    _target(d, "aside", 20, (-4, -2))
    why = (
        "Left of `side`, targets are reached through x = 0 to one step at y = 10 only: farther left is "
        "`front`, and a segment that passes farther right has to cross `side`, which goes on to y = 30. "
        "From x = 0.75, y = 0 the gap shows x = -0.75 at y = 20. From anywhere in the cell it shows at most "
        "x > -1.12, so `aside` is hidden."
    )
    opening = (Fraction(1, 2), Fraction(10 * STEPS), Fraction(0))
    return d.finish(Answer("front in_line", "aside", why, opening))


def corner_closed() -> AnalyticScene:
    """The same corner with a gap of width zero shows nothing, though the walls share no whole edge."""
    d = Drawing("corner_closed", *CELL)
    d.wall_y("front", 10, (-20, 0))
    d.wall_x("side", 0, (10, 30), (-15, 15))
    _target(d, "in_line", 20, (-2, -0.5))
    why = (
        "At y = 10 a segment to x < 0 at y = 20 has x <= 0 and meets `front`, or x > 0 and later crosses x "
        "= 0 between y = 10 and 20, where `side` is. Heights stay within -1 to 1. Faces are closed, so the "
        "common line blocks."
    )
    return d.finish(Answer("front", "in_line", why))


def t_junction() -> AnalyticScene:
    """A vertex of the upper walls lies inside the upper edge of the lower wall; nothing is seen through the
    line."""
    d = Drawing("t_junction", *CELL)
    d.wall_y("lower", 10, SIDE, (-20, 0))
    d.wall_y("upper_left", 10, (-20, 0), (0, 20))
    d.wall_y("upper_right", 10, (0, 20), (0, 20))
    _target(d, "behind", 12, (-1, 1))
    why = "The walls cover the square from -20 to 20 at y = 10, where every segment to `behind` crosses it."
    return d.finish(Answer("lower upper_left upper_right", "behind", why))


def doubled() -> AnalyticScene:
    """Two equal faces in one place: each is visible where the other is, and they hide as one does."""
    d = Drawing("doubled", *CELL)
    d.wall_y("first", 10, SIDE)
    d.wall_y("second", 10, SIDE)
    _target(d, "behind", 12, (-1, 1))
    why = (
        "A half-open segment that ends on the wall meets neither copy before its end, so both are visible. "
        "Segments to `behind` cross both."
    )
    return d.finish(Answer("first second", "behind", why))


def ridge() -> AnalyticScene:
    """A ridge of sloped terrain hides its far slope and the land behind."""
    d = Drawing("ridge", (-1, -1, 1), (1, 1, 2))
    profile = [
        ("front", -10, 0, 5, 0),
        ("rise", 5, 0, 10, 10),
        ("fall", 10, 10, 15, 0),
        ("land", 15, 0, 30, 0),
    ]
    for name, y0, z0, y1, z1 in profile:
        d.quad(name, (-50, y0, z0), (50, y0, z0), (50, y1, z1), (-50, y1, z1))
    d.triangle("house", (-1, 16, 0), (1, 16, 0), (0, 16, 4))
    why = (
        "The cell is lower than 2, and what is behind lower than 10, so a segment is below the ridge at y = "
        "10; at y = 5 it is above the ground; so it crosses `rise`. `front` and `rise` are seen from above "
        "with nothing between."
    )
    return d.finish(Answer("front rise", "fall land house", why))
