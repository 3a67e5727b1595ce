"""Houses, towers, courtyards and arcades drawn from their plan."""

from __future__ import annotations

from dataclasses import dataclass, replace

from tilesnav_ref.scene.sample.canvas import Canvas, Terrain
from tilesnav_ref.scene.sample.facade import Opening, Wall, draw_wall
from tilesnav_ref.scene.sample.plan import Building, Rectangle
from tilesnav_ref.scene.sample.settings import METRE, UNIT

STOREY = 3 * METRE
SILL = METRE * 7 // 8
HEAD = METRE * 17 // 8
OPENING = METRE
"""Width of a window or door."""
THICKNESS = METRE // 4
"""Of the walls and the ceiling of a house that can be entered."""
PASSAGE = 3 * METRE
"""Width of a passage, wide enough to fly through."""
PASSAGE_HEAD = METRE * 13 // 4
PASSAGE_STOREY = 4 * METRE
WING = METRE * 11 // 2
"""Depth of the wings round a courtyard."""

SPACING = {"coarse": None, "median": 5 * METRE, "fine": 2 * METRE}
"""Least distance of windows; None for a door and no window."""
GAP = METRE // 4
"""Least distance of a window and a passage; windows are less deep."""


@dataclass(frozen=True)
class Site:
    """Where and how to draw."""

    canvas: Canvas
    terrain: Terrain
    detail: str


def draw_building(site: Site, building: Building) -> None:
    """Draw a building on the ground, closed but for its bottom."""
    site.canvas.begin(building.name)
    {"house": _house, "tower": _tower, "courtyard": _courtyard, "arcade": _arcade}[building.kind](
        site, building
    )


def _floor(site: Site, footprint: Rectangle) -> int:
    """Height of the highest ground at the footprint."""
    return max(site.terrain.height(footprint[0]), site.terrain.height(footprint[2]))


def _row_lines(
    floor: int, storeys: int, first_storey: int = STOREY, first_head: int = HEAD
) -> tuple[int, ...]:
    """Sill and head of every storey, and the top."""
    lines = [floor + SILL, floor + first_head]
    for k in range(1, storeys):
        foot = floor + first_storey + (k - 1) * STOREY
        lines += [foot + SILL, foot + HEAD]
    return (*lines, floor + first_storey + (storeys - 1) * STOREY)


def _sides(
    rectangle: Rectangle, clockwise: bool = False
) -> list[tuple[tuple[int, int], tuple[int, int], int]]:
    """Origin, direction and length of the walls south, east, north, west; clockwise for the walls of a
    courtyard."""
    x0, y0, x1, y1 = rectangle
    if clockwise:
        return [
            ((x1, y0), (-1, 0), x1 - x0),
            ((x1, y1), (0, -1), y1 - y0),
            ((x0, y1), (1, 0), x1 - x0),
            ((x0, y0), (0, 1), y1 - y0),
        ]
    return [
        ((x0, y0), (1, 0), x1 - x0),
        ((x1, y0), (0, 1), y1 - y0),
        ((x1, y1), (-1, 0), x1 - x0),
        ((x0, y1), (0, -1), y1 - y0),
    ]


def _openings(site: Site, length: int, storeys: int, side: int) -> tuple[Opening, ...]:
    """Windows of a wall; on the south side the middle one of the lowest row is a door."""
    spacing = SPACING[site.detail]
    if spacing is None and side:
        return ()
    count = 1 if spacing is None else max(1, length // spacing)
    levels = 1 if spacing is None else storeys
    found = []
    for i in range(count):
        start = (length * (2 * i + 1) // (2 * count) - OPENING // 2) // UNIT * UNIT
        for k in range(levels):
            door = side == 0 and k == 0 and i == count // 2
            window = Opening(start, start + OPENING, 2 * k + 1, 2 * k + 1, framed=site.detail == "fine")
            found.append(replace(window, first_row=0, framed=False) if door else window)
    return tuple(found)


def _house(site: Site, building: Building) -> None:
    floor = _floor(site, building.footprint)
    rows = _row_lines(floor, building.storeys)
    for side, (origin, direction, length) in enumerate(_sides(building.footprint)):
        openings = _openings(site, length, building.storeys, side)
        if building.hollow:
            openings = tuple(replace(o, depth=THICKNESS, pane=False, framed=False) for o in openings)
        wall = Wall(origin, direction, length, _used_rows(rows, openings), openings)
        draw_wall(site.canvas, site.terrain, wall)
        if building.hollow:
            inner = _used_rows((*rows[:-1], rows[-1] - THICKNESS), openings)
            draw_wall(
                site.canvas,
                site.terrain,
                replace(wall, rows=inner, setback=THICKNESS, inset=THICKNESS, facing_in=True),
            )
    if building.hollow:
        x0, y0, x1, y1 = building.footprint
        t = THICKNESS
        _plate(site, (x0 + t, y0 + t, x1 - t, y1 - t), rows[-1] - t, facing_down=True)
    _roof(site, building, rows[-1])


def _used_rows(rows: tuple[int, ...], openings: tuple[Opening, ...]) -> tuple[int, ...]:
    """Row lines up to the highest opening, and the top; a wall without openings is one rectangle."""
    highest = max((o.last_row for o in openings), default=-1)
    return (*rows[: highest + 1], rows[-1])


def _plate(site: Site, rectangle: Rectangle, z: int, facing_down: bool = False) -> None:
    x0, y0, x1, y1 = rectangle
    corners = [(x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)]
    site.canvas.polygon(*(corners[::-1] if facing_down else corners))


def _roof(site: Site, building: Building, top: int) -> None:
    """Flat, with a stair head unless coarse, or gabled with the ridge along the longer side."""
    x0, y0, x1, y1 = building.footprint
    if not building.gabled:
        draw_flat = _plate if site.detail == "coarse" else _flat_roof
        draw_flat(site, building.footprint, top)
        return
    draw = site.canvas.polygon
    if x1 - x0 >= y1 - y0:
        y, ridge = (y0 + y1) // 2, top + (y1 - y0) * 3 // 8
        draw((x0, y0, top), (x1, y0, top), (x1, y, ridge), (x0, y, ridge))
        draw((x1, y1, top), (x0, y1, top), (x0, y, ridge), (x1, y, ridge))
        draw((x1, y0, top), (x1, y1, top), (x1, y, ridge))
        draw((x0, y1, top), (x0, y0, top), (x0, y, ridge))
        return
    x, ridge = (x0 + x1) // 2, top + (x1 - x0) * 3 // 8
    draw((x1, y0, top), (x1, y1, top), (x, y1, ridge), (x, y0, ridge))
    draw((x0, y1, top), (x0, y0, top), (x, y0, ridge), (x, y1, ridge))
    draw((x0, y0, top), (x1, y0, top), (x, y0, ridge))
    draw((x1, y1, top), (x0, y1, top), (x, y1, ridge))


def _flat_roof(site: Site, footprint: Rectangle, top: int) -> None:
    """A plate with a box on it, drawn in nine parts, the middle one raised."""
    x0, y0, _, _ = footprint
    inner = (x0 + 2 * METRE, y0 + 2 * METRE, x0 + 4 * METRE, y0 + 4 * METRE)
    high = top + 2 * METRE
    _ring(site, footprint, inner, top)
    for (x, y), (dx, dy), length in _sides(inner):
        site.canvas.polygon(
            (x, y, top),
            (x + dx * length, y + dy * length, top),
            (x + dx * length, y + dy * length, high),
            (x, y, high),
        )
    _plate(site, inner, high)


def _ring(site: Site, outer: Rectangle, inner: Rectangle, z: int) -> None:
    """The level surface between two rectangles, with mitred corners."""
    corners = [[(r[i], r[j], z) for i, j in ((0, 1), (2, 1), (2, 3), (0, 3))] for r in (outer, inner)]
    for k in range(4):
        site.canvas.polygon(corners[0][k], corners[0][k - 3], corners[1][k - 3], corners[1][k])


def _tower(site: Site, building: Building) -> None:
    """A high house with a pyramid."""
    rows = _row_lines(_floor(site, building.footprint), building.storeys)
    for side, (origin, direction, length) in enumerate(_sides(building.footprint)):
        openings = _openings(site, length, building.storeys, side)
        draw_wall(
            site.canvas, site.terrain, Wall(origin, direction, length, _used_rows(rows, openings), openings)
        )
    x0, y0, x1, y1 = building.footprint
    apex = ((x0 + x1) // 2, (y0 + y1) // 2, rows[-1] + (x1 - x0))
    for (x, y), (dx, dy), length in _sides(building.footprint):
        site.canvas.polygon((x, y, rows[-1]), (x + dx * length, y + dy * length, rows[-1]), apex)


def _courtyard(site: Site, building: Building) -> None:
    """Four wings round a yard that a passage through the southern wing leads to."""
    x0, y0, x1, y1 = building.footprint
    yard = (x0 + WING, y0 + WING, x1 - WING, y1 - WING)
    floor = _floor(site, building.footprint)
    rows = _row_lines(floor, building.storeys, PASSAGE_STOREY, PASSAGE_HEAD)
    passage = Opening(0, PASSAGE, 0, 1, depth=WING, pane=False)
    for clockwise, rectangle in ((False, building.footprint), (True, yard)):
        for side, (origin, direction, length) in enumerate(_sides(rectangle, clockwise)):
            openings = _openings(site, length, building.storeys, side + 2 if side == 0 else side)
            if side == 0:
                openings = _with_passages(openings, [(length - PASSAGE) // 2], passage)
            wall = Wall(origin, direction, length, _used_rows(rows, openings), openings)
            draw_wall(site.canvas, site.terrain, _without_reveals(wall) if clockwise else wall)
    _ring(site, building.footprint, yard, rows[-1])


def _without_reveals(wall: Wall) -> Wall:
    """A wall whose passages are drawn from their other end: here they are holes only."""
    return replace(wall, openings=tuple(o if o.pane else replace(o, depth=0) for o in wall.openings))


def _with_passages(openings: tuple[Opening, ...], starts: list[int], passage: Opening) -> tuple[Opening, ...]:
    """Put passages in, and leave out the openings whose columns they would cut."""
    passages = [replace(passage, start=s // UNIT * UNIT, end=s // UNIT * UNIT + PASSAGE) for s in starts]
    kept = [o for o in openings if all(_apart(o, p) for p in passages)]
    return (*passages, *kept)


def _apart(opening: Opening, passage: Opening) -> bool:
    above = opening.first_row > passage.last_row
    return above or opening.end + GAP <= passage.start or opening.start >= passage.end + GAP


def _arcade(site: Site, building: Building) -> None:
    """A house over passages that run through it from south to north."""
    x0, y0, x1, y1 = building.footprint
    rows = _row_lines(_floor(site, building.footprint), building.storeys, PASSAGE_STOREY, PASSAGE_HEAD)
    count = (x1 - x0) // (PASSAGE + METRE)
    bay = (x1 - x0) // count
    starts = [(k * bay + (bay - PASSAGE) // 2) // UNIT * UNIT for k in range(count)]
    passage = Opening(0, PASSAGE, 0, 1, depth=y1 - y0, pane=False)
    for side, (origin, direction, length) in enumerate(_sides(building.footprint)):
        openings = _openings(site, length, building.storeys, side + 2 if side == 0 else side)
        if side % 2 == 0:
            mirrored = [length - s - PASSAGE for s in starts] if side == 2 else starts
            openings = tuple(o for o in openings if o.first_row > 1)
            openings = _with_passages(openings, mirrored, passage)
        wall = Wall(origin, direction, length, _used_rows(rows, openings), openings)
        draw_wall(site.canvas, site.terrain, _without_reveals(wall) if side == 2 else wall)
    _roof(site, building, rows[-1])
