"""Questions to the kernels that hide faces by their own sheets and by patches; prints JSON.

Run as a program so that a changed copy of the package can be asked.
"""

from __future__ import annotations

import json

import numpy as np
from visibility_probes import CELL, FRAME, UNIT, listed, scene_of

from tilesnav_ref.visibility.backs import find_inner_sides
from tilesnav_ref.visibility.certify import Workspace, back_is_hidden, make_workspace
from tilesnav_ref.visibility.geometry import Geometry, build_geometry
from tilesnav_ref.visibility.sight import make_crossed
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
    cell = np.array(region, float) * UNIT
    return [face for face in range(len(triangles)) if back_is_hidden(geometry, work, cell, face)]


def back_of_a_house() -> bool:
    """The far side of a box is hidden by the rest of it, the near side is not."""
    found = hidden(box((20, -9, -9), (30, 9, 9)), CELL)
    return {10, 11} <= set(found) and not {0, 1} & set(found)


def back_of_a_house_without_its_front() -> bool:
    """Through a missing front the far side is visible: the border of the sheet is in the shaft."""
    return not {8, 9} & set(hidden(box((20, -9, -9), (30, 9, 9))[2:], CELL))


def house_inside_the_region() -> bool:
    """A region that holds the front of a house proves nothing by it."""
    return not {10, 11} & set(hidden(box((20, -3, -3), (90, 3, 3)), [[0, -9, -9], [60, 9, 9]]))


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


def fine_wall(y: int, z: int) -> list[Triangle]:
    """A wall at x = 20 in squares of 2, from -y to y and from -z to z."""
    found: list[Triangle] = []
    for i in range(-y, y, 2):
        for j in range(-z, z, 2):
            found += quad((20, i, j), (20, i + 2, j), (20, i + 2, j + 2), (20, i, j + 2))
    return found


TARGET: Triangle = [(40, -30, -40), (40, 30, -40), (40, 0, 36)]


def fine_wall_that_is_too_low() -> bool:
    """What a finely divided wall leaves free is visible, as it is behind a plain one."""
    wall = fine_wall(24, 12)
    return len(wall) in listed([*wall, TARGET], [CELL])[0]


def fine_wall_that_hides() -> bool:
    """A finely divided wall of more faces than an occluder may have hides what is behind it, as a patch."""
    wall = fine_wall(44, 44)
    return len(wall) not in listed([*wall, TARGET], [CELL])[0]


PROBES = (
    back_of_a_house,
    back_of_a_house_without_its_front,
    house_inside_the_region,
    roof_whose_plane_cuts_the_cell,
    plate_through_the_front,
    wall_below_a_canopy,
    fine_wall_that_is_too_low,
    fine_wall_that_hides,
)


def main() -> dict[str, bool]:
    """Name of each probe and whether its answer is sound, and as sharp as it says."""
    return {probe.__name__: bool(probe()) for probe in PROBES}


if __name__ == "__main__":
    print(json.dumps(main()))  # noqa: T201
