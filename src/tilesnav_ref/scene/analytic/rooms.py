"""Cells within walls: closed rooms, a box in a room, a corridor with a corner, party walls."""

from __future__ import annotations

from tilesnav_ref.scene.analytic.case import AnalyticScene, Answer, Drawing

SIX = ("west", "east", "south", "north", "floor", "ceiling")


def _six(prefix: str, without: str = "") -> str:
    return " ".join(prefix + side for side in SIX if side != without)


def closed_room() -> AnalyticScene:
    """From inside a closed room all of it is visible and nothing else."""
    d = Drawing("closed_room", (1, 1, 1), (2, 2, 2))
    d.room("", (0, 0, 0), (6, 5, 3))
    d.triangle("outside", (7, 1, 1), (7, 3, 1), (7, 2, 2))
    d.triangle("above", (1, 1, 4), (3, 1, 4), (2, 2, 4))
    why = (
        "The room is convex and closed: every segment to its border is free, and every segment out of it "
        "crosses the border."
    )
    return d.finish(Answer(_six(""), "outside above", why))


def box_in_room() -> AnalyticScene:
    """A pillar as high as the room hides its own back and the wall behind."""
    d = Drawing("box_in_room", (9, 2, 2), (11, 3, 3))
    d.room("", (0, 0, 0), (20, 20, 6))
    d.wall_y("front", 9, (4, 16), (0, 6))
    d.wall_y("back", 11, (4, 16), (0, 6))
    d.wall_x("left", 4, (9, 11), (0, 6))
    d.wall_x("right", 16, (9, 11), (0, 6))
    d.triangle("behind", (9, 13, 2), (11, 13, 2), (10, 13, 3))
    why = (
        "Segments to `behind` and to `back` cross y = 9 within x = 4 to 16, on `front`. Segments to `north` "
        "(y = 20) cross y = 9 at x of at least 9 - 9 * 7/18 = 5.5 and at most 14.5. The cell is in front of "
        "`front` and within the convex room, whose other sides have points on both triangles with y < 9. The "
        "cell is between the planes of `left` and `right`, so a segment to them crosses `front` first."
    )
    visible = _six("", without="north") + " front"
    return d.finish(Answer(visible, "behind back north left right", why))


def l_corridor() -> AnalyticScene:
    """A corridor with a corner: only a strip of the second leg is seen."""
    d = Drawing("l_corridor", (1, 1, 1), (2, 2, 2))
    z = (0.0, 3.0)
    d.wall_y("south", 0, (0, 20), z)
    d.wall_x("west", 0, (0, 3), z)
    d.wall_y("inner_north", 3, (0, 17), z)
    d.wall_x("east", 20, (0, 3), z)
    d.plate("floor", 0, (0, 20), (0, 3))
    d.plate("ceiling", 3, (0, 20), (0, 3))
    d.wall_x("east_strip", 20, (3, 4), z)
    d.wall_x("east_far", 20, (4, 20), z)
    d.wall_x("inner_west", 17, (3, 20), z)
    d.wall_y("end", 20, (17, 20), z)
    d.plate("far_floor", 0, (17, 20), (4, 20))
    d.plate("far_ceiling", 3, (17, 20), (4, 20))
    why = (
        "The first leg is convex and holds the cell, so its walls are visible. A segment into the second "
        "leg passes the inner corner (17, 3) on its right, so at x = 20 it has y <= 3 + (3 - 1) 3 / (17 - "
        "2) = 3.4: `east_strip` is partly visible, and all that has y > 4 is hidden. To reach `inner_west` "
        "from x < 17 a segment crosses `inner_north`."
    )
    visible = "south west inner_north east floor ceiling east_strip"
    return d.finish(Answer(visible, "east_far inner_west end far_floor far_ceiling", why))


def party_walls() -> AnalyticScene:
    """Two closed houses with a party wall that both have: from within one, both copies are visible."""
    d = Drawing("party_walls", (2, 2, 2), (4, 4, 3))
    d.room("a_", (0, 0, 0), (10, 8, 6))
    d.room("b_", (10, 0, 0), (20, 8, 6))
    why = (
        "House a is convex and closed. The western wall of house b lies in the eastern wall of house a, and "
        "a half-open segment that ends there has met nothing. Every other face of b is beyond that wall."
    )
    return d.finish(Answer(_six("a_") + " b_west", _six("b_", without="west"), why))
