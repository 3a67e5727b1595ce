"""Questions to the kernels that hide faces by their own sheets and by patches; prints JSON.

Run as a program so that a changed copy of the package can be asked.
"""

from __future__ import annotations

import json

import numpy as np
from visibility_probes import CELL, FRAME, UNIT, listed, scene_of

from tilesnav_ref.visibility.backs import crossings_of_sheet, find_inner_sides, sheet_hides
from tilesnav_ref.visibility.certify import Workspace, make_workspace
from tilesnav_ref.visibility.geometry import Geometry, build_geometry
from tilesnav_ref.visibility.prisms import box_prism
from tilesnav_ref.visibility.shaft import set_shaft
from tilesnav_ref.visibility.sight import find_crossed, make_crossed
from tilesnav_ref.visibility.units import divide

Triangle = list[tuple[int, int, int]]


def quad(a: tuple[int, ...], b: tuple[int, ...], c: tuple[int, ...], d: tuple[int, ...]) -> list[Triangle]:
    return [[a, b, c], [a, c, d]]  # type: ignore[list-item]


def box(low: tuple[int, int, int], high: tuple[int, int, int]) -> list[Triangle]:
    """Twelve faces; the first two are at the lower x, the last two at the upper x."""
    (x, y, z), (u, v, w) = low, high
    return [
        *quad((x, y, z), (x, v, z), (x, v, w), (x, y, w)),
        *quad((x, y, z), (u, y, z), (u, y, w), (x, y, w)),
        *quad((x, v, z), (u, v, z), (u, v, w), (x, v, w)),
        *quad((x, y, z), (u, y, z), (u, v, z), (x, v, z)),
        *quad((x, y, w), (u, y, w), (u, v, w), (x, v, w)),
        *quad((u, y, z), (u, v, z), (u, v, w), (u, y, w)),
    ]


def prepared(triangles: list[Triangle]) -> tuple[Geometry, Workspace]:
    scene = scene_of(triangles)
    geometry = build_geometry(scene, FRAME)
    division = divide(geometry, scene.faces)
    find_inner_sides(geometry, division, make_crossed(1))
    return geometry, make_workspace((geometry, division), 16, 4)


def hidden(triangles: list[Triangle], region: list[list[int]]) -> list[int]:
    """Faces that their own sheets are proved to hide from a region."""
    geometry, work = prepared(triangles)
    cell = box_prism(np.array(region, float) * UNIT)
    found = []
    for face, part in enumerate(geometry.corners):
        set_shaft(work.shaft, cell, part, 3)
        if sheet_hides(geometry, work, cell, cell, part, face):
            found.append(face)
    return found


def back_of_a_house() -> bool:
    """The far side of a box is hidden by the rest of it, the near side is not."""
    found = hidden(box((20, -9, -9), (30, 9, 9)), CELL)
    return {10, 11} <= set(found) and not {0, 1} & set(found)


def back_of_a_house_with_a_hole() -> bool:
    """Through a small hole in the front the far side is visible: the border of the sheet is in the shaft."""
    a, b, c, d = (20, -9, -9), (20, 9, -9), (20, 9, 9), (20, -9, 9)
    p, q, r = (20, -1, -1), (20, 1, -1), (20, 0, 1)
    front = [[a, b, p], [b, q, p], [b, c, q], [c, r, q], [c, d, r], [d, p, r], [d, a, p]]
    return not {15, 16} & set(hidden(front + box((20, -9, -9), (30, 9, 9))[2:], CELL))


def house_inside_the_region() -> bool:
    """A region that holds the front of a house proves nothing by it."""
    return not {10, 11} & set(hidden(box((20, -3, -3), (90, 3, 3)), [[0, -9, -9], [60, 9, 9]]))


def house_inside_the_next_region() -> bool:
    """What was found out for one region is not taken for true of the next, which holds the front."""
    geometry, work = prepared(box((20, -3, -3), (90, 3, 3)))
    found = []
    for region in (CELL, [[0, -9, -9], [60, 9, 9]]):
        cell = box_prism(np.array(region, float) * UNIT)
        set_shaft(work.shaft, cell, geometry.corners[10], 3)
        found.append(sheet_hides(geometry, work, cell, cell, geometry.corners[10], 10))
    return found == [True, False]


def roof_whose_plane_cuts_the_cell() -> bool:
    """The top of a box is visible from the part of the cell above it."""
    return not {8, 9} & set(hidden(box((20, -9, -9), (30, 9, 1)), CELL))


def plate_through_the_front() -> bool:
    """A back wall that reaches out of its house through the front is visible there."""
    house = box((20, -9, -9), (30, 9, 9))[:10]
    house += [[(30, -9, -9), (30, 9, -9), (10, 0, 9)]]
    house += [[(30, -9, -9), (30, -9, 9), (10, 0, 9)], [(30, 9, -9), (30, 9, 9), (10, 0, 9)]]
    return 10 not in hidden(house, CELL)


def wall_below_a_canopy() -> bool:
    """A wall below a far reaching roof is taken for an inside by the probes, and is visible from below."""
    wall = quad((30, -9, -9), (30, 9, -9), (30, 9, 9), (30, -9, 9))
    roof = quad((30, -9, 9), (30, 9, 9), (-900, 900, 9), (-900, -900, 9))
    return not {0, 1} & set(hidden(wall + roof, CELL))


def sheet_left_by_an_edge() -> bool:
    """A segment that leaves a box by an edge is in general position with nothing."""
    geometry, work = prepared(box((20, -9, -9), (30, 9, 9)))
    start, end = (0.0, 3.0 * UNIT, -0.5 * UNIT), (60.0 * UNIT, 15.0 * UNIT, 2.5 * UNIT)
    assert find_crossed(geometry, start, end, -1, work.crossed)
    return bool(crossings_of_sheet(work.sheets, work.crossed, 0) == -1)


def fine_wall(top: int) -> list[Triangle]:
    """A wall at x = 20 in squares of 4, as broad and as deep as it has to be."""
    found: list[Triangle] = []
    for i in range(-44, 44, 4):
        for j in range(-44, top, 4):
            found += quad((20, i, j), (20, i + 4, j), (20, i + 4, j + 4), (20, i, j + 4))
    return found


TARGET: Triangle = [(40, -30, -40), (40, 30, -40), (40, 0, 36)]


def fine_wall_that_is_too_low() -> bool:
    """What a finely divided wall leaves free is visible, as it is behind a plain one."""
    wall = fine_wall(12)
    return len(wall) in listed([*wall, TARGET], [CELL])[0]


def fine_wall_that_hides() -> bool:
    """A finely divided wall of more faces than an occluder may have hides what is behind it, as a patch."""
    wall = fine_wall(44)
    return len(wall) not in listed([*wall, TARGET], [CELL])[0]


PROBES = (
    back_of_a_house,
    back_of_a_house_with_a_hole,
    house_inside_the_region,
    house_inside_the_next_region,
    roof_whose_plane_cuts_the_cell,
    plate_through_the_front,
    wall_below_a_canopy,
    sheet_left_by_an_edge,
    fine_wall_that_is_too_low,
    fine_wall_that_hides,
)


def main() -> dict[str, bool]:
    """Name of each probe and whether its answer is sound, and as sharp as it says."""
    return {probe.__name__: bool(probe()) for probe in PROBES}


if __name__ == "__main__":
    print(json.dumps(main()))  # noqa: T201
