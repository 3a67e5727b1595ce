"""Cells and targets that touch planes: walls on the cell's border, coplanar neighbours, faces seen on
edge."""

from __future__ import annotations

from tilesnav_ref.scene.analytic.case import AnalyticScene, Answer, Drawing


def touching_cell() -> AnalyticScene:
    """A cell that touches a wall with a whole side sees the wall and nothing behind it."""
    d = Drawing("touching_cell", (-1, 0, -1), (1, 2, 1))
    d.wall_y("wall", 2, (-20, 20))
    d.triangle("behind", (-1, 3, -1), (1, 3, -1), (0, 3, 1))
    why = (
        "The interior of the cell is on one side of y = 2, and every segment to `behind` crosses it within "
        "x, z = -1 to 1."
    )
    return d.finish(Answer("wall", "behind", why))


def coplanar_target() -> AnalyticScene:
    """Faces that continue the target's plane do not hide it; a panel in front does, as far as it reaches."""
    d = Drawing("coplanar_target", (-1, -1, -1), (1, 1, 1))
    d.wall_y("left", 10, (-20, 0), (-1, 1))
    d.wall_y("target", 10, (0, 2), (-1, 1))
    d.wall_y("middle", 10, (2, 10), (-1, 1))
    d.wall_y("right", 10, (10, 20), (-1, 1))
    d.wall_y("panel", 5, (-3, 4), (-4, 4))
    why = (
        "Segments to `target` cross y = 5 within x = -1 to 2, on `panel`. Segments from the middle of the "
        "cell to `right` cross it at x of 5 or more; those to the far half of `left` cross it at x < -3. The "
        "plane y = 10 is met at the end of a segment only, so coplanar faces never hide each other from the "
        "cell."
    )
    return d.finish(Answer("left right panel", "target", why))


def edge_on() -> AnalyticScene:
    """A face in the plane of the cell's lower side is visible at a grazing angle."""
    d = Drawing("edge_on", (-1, -1, 0), (1, 1, 2))
    d.plate("grazed", 0, (-1, 1), (10, 12))
    d.plate("lid", 0.125, (-1, 1), (10, 12))
    d.plate("below", -1, (-1, 1), (10, 12))
    why = (
        "Interior points have z > 0. From z = 1/64 at y = 0 the segment to (0, 10.5, 0) is at z < 1/8 all "
        "the way, below `lid`. Segments to `below` from z > 0 cross z = 0; those with y < 10 there reach "
        "it: from (0, 0, 1/4) to (0, 11, -1) at y = 2.2."
    )
    return d.finish(Answer("grazed lid below", "", why))


def edge_on_hidden() -> AnalyticScene:
    """A face that would be seen only on edge, from the border of the cell, is hidden from its interior."""
    d = Drawing("edge_on_hidden", (-2, -1, -1), (0, 1, 1))
    d.wall_y("wall", 5, (-20, 0))
    d.wall_x("fin", 0, (10, 12), (-1, 1))
    why = (
        "`fin` lies in x = 0, the plane of the cell's side. An interior point has x < 0, so a segment to "
        "`fin` has x < 0 at y = 5, where it meets `wall`."
    )
    return d.finish(Answer("wall", "fin", why))
