"""Small questions to the visibility kernels, each of which one condition of the theorem decides; prints JSON.

Run as a program so that a changed copy of the package can be asked.
"""

from __future__ import annotations

import json

import numpy as np

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.visibility import VisibilitySettings, compute_pvs
from tilesnav_ref.visibility.certify import make_workspace
from tilesnav_ref.visibility.geometry import FineFrame, build_geometry
from tilesnav_ref.visibility.lines import cell_prisms, share_lines
from tilesnav_ref.visibility.occluder import PROVED, Obstacle, prove_hidden, surface_of
from tilesnav_ref.visibility.prisms import box_prism
from tilesnav_ref.visibility.shaft import set_shaft
from tilesnav_ref.visibility.sight import find_crossed, sees
from tilesnav_ref.visibility.units import divide

UNIT = 1024
FRAME = FineFrame(np.zeros(3, np.int64), UNIT)


def scene_of(triangles: list[list[tuple[int, int, int]]]) -> Scene:
    corners = np.asarray(triangles, np.int64).reshape(-1, 3)
    vertices, inverse = np.unique(corners, axis=0, return_inverse=True)
    faces = inverse.reshape(-1, 3).astype(np.int32)
    return Scene(vertices, faces, np.zeros(len(faces), np.int32), np.zeros(1, np.int32), ("probe",))


def listed(triangles: list[list[tuple[int, int, int]]], boxes: list[list[list[int]]]) -> list[list[int]]:
    """Faces listed for each box with hardly any rays, so that certificates do the work."""
    cells = np.asarray(boxes, np.int64)
    none = np.zeros(0, np.int64)
    complex_ = CellComplex(
        cells[:, 0], cells[:, 1], np.zeros(len(cells), np.uint8), np.zeros(len(cells) + 1, np.int64),
        none, none, 0, 1.0,
    )  # fmt: skip
    work = VisibilitySettings(rays=1, attempts=8, depth=4, leaf_segments=0, threads=1)
    table = compute_pvs(scene_of(triangles), complex_, work)
    return [table.faces_of(i).tolist() for i in range(len(boxes))]


CELL = [[0, -4, -4], [8, 4, 4]]


def wall_with_a_gap() -> bool:
    """A wall that leaves a thin strip of the target free: the target is visible."""
    wall = [[(20, -90, -90), (20, 90, -90), (20, 0, 12)], [(20, -200, -90), (20, -199, -90), (20, -200, -89)]]
    target = [[(40, -30, -40), (40, 30, -40), (40, 0, 36)]]
    return 2 in listed(wall + target, [CELL])[0]


def wall_that_pierces() -> bool:
    """A huge wall that the target sticks through: its front part is visible."""
    wall = [[(20, -900, -900), (20, 900, -900), (20, 0, 900)]]
    target = [[(18, 0, 0), (90, -40, -40), (90, 40, 40)]]
    return 1 in listed(wall + target, [CELL])[0]


def wall_between_two_cells() -> bool:
    """A wall inside the block of two cells hides nothing from the second cell."""
    wall = [[(20, -900, -900), (20, 900, -900), (20, 0, 900)]]
    targets = [[(90, -9 + i, -9), (90, -8 + i, -9), (90, -9 + i, -8)] for i in range(12)]
    cells = [[[22, -4, -4], [30, 4, 4]]] + [[[10 * i - 60, -4, -4], [10 * i - 52, 4, 4]] for i in range(7)]
    return set(range(1, 13)) <= set(listed(wall + targets, cells)[0])


def closed_solid_through_its_edge() -> bool:
    """A segment that enters a tetrahedron by a face and leaves by an edge has crossed nothing odd."""
    a, b, c, d = (20, -9, -9), (20, 9, -9), (20, 0, 9), (30, 0, 0)
    solid = [[a, b, c], [a, b, d], [b, c, d], [c, a, d]]
    target = [[(60, -9, -9), (60, 9, -9), (60, 0, 9)]]
    scene = scene_of(solid + target)
    geometry = build_geometry(scene, FRAME)
    division = divide(geometry, scene.faces)
    work = make_workspace((geometry, division), 16, 4)
    cell = box_prism(np.array(CELL, float) * UNIT)
    set_shaft(work.shaft, cell, geometry.corners[4], 3)
    on_edge = np.array([25.0, 0.0, 4.5]) * UNIT  # the middle of edge c d
    inside_front = np.array([20.0, 0.0, 4.0]) * UNIT
    start, end = inside_front - 2 * (on_edge - inside_front), inside_front + 7 * (on_edge - inside_front)
    nowhere = np.zeros((8, 3)), np.zeros((2, 3))
    segment = (tuple(start.tolist()), tuple(end.tolist()))
    find_crossed(geometry, *segment, 4, work.crossed)
    work.single.stamps[:] = 1
    how = segment[0], False
    bounds = np.stack([geometry.corners[4].min(axis=0), geometry.corners[4].max(axis=0)])
    obstacle = Obstacle(*nowhere, 4, bounds)
    verdict = prove_hidden(
        surface_of(geometry), work.single, (work.shaft, work.crossed), obstacle, 0, how
    )
    return bool(verdict != PROVED)


def box_behind_a_wall_it_touches() -> bool:
    """A wall that runs through the middle of a box of faces hides those behind it only."""
    wall = [[(40, -900, -900), (40, 900, -900), (40, 0, 900)]]
    near = [[(38, -9 + i, -9), (38, -8 + i, -9), (38, -9 + i, -8)] for i in range(3)]
    far = [[(50, -9 + i, -9), (50, -8 + i, -9), (50, -9 + i, -8)] for i in range(14)]
    return {1, 2, 3} <= set(listed(wall + near + far, [CELL])[0])


def suggestion_behind_a_wall() -> bool:
    """A ray's suggestion alone proves nothing: the wall is in the way."""
    wall = [[(20, -900, -900), (20, 900, -900), (20, 0, 900)]]
    target = [[(90, -4, -4), (90, 4, -4), (90, 0, 4)]]
    geometry = build_geometry(scene_of(wall + target), FRAME)
    seen = np.zeros((1, 2), np.uint8)
    line = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]], np.float32)
    hits = np.array([1, -1], np.int32), np.full((2, 2), 0.3)
    share_lines(geometry, cell_prisms(box_prism(np.array(CELL, float) * UNIT)[None]), line, hits, seen)
    return not seen[0, 1]


def flagged(
    triangles: list[list[tuple[int, int, int]]], porous: tuple[int, ...], sided: tuple[int, ...]
) -> Scene:
    """A scene in which every face is an object, some of them porous or one-sided."""
    plain, count = scene_of(triangles), len(triangles)
    numbers = np.arange(count, dtype=np.int32)
    return Scene(
        plain.vertices, plain.faces, numbers, np.zeros(count, np.int32), ("probe",) * count,
        object_porous=np.isin(numbers, porous), object_one_sided=np.isin(numbers, sided),
    )  # fmt: skip


def idle_listed(scene: Scene, max_range: float | None = None) -> list[int]:
    """Faces listed for CELL where segments are hardly ever tried."""
    cells, none = np.asarray([CELL], np.int64), np.zeros(0, np.int64)
    complex_ = CellComplex(
        cells[:, 0], cells[:, 1], np.zeros(1, np.uint8), np.zeros(2, np.int64),
        none, none, 0, 1.0,
    )  # fmt: skip
    work = VisibilitySettings(
        rays=1, attempts=8, depth=4, leaf_segments=0, aimed_rounds=0, threads=1, max_range=max_range
    )
    return list(compute_pvs(scene, complex_, work).faces_of(0).tolist())


def opaque_wall_that_goes_on_porous() -> bool:
    """A wall whose upper end is porous: what is seen through that end is visible."""
    tip, left, right = (20, 0, 12), (20, -90, -90), (20, 90, -90)
    top_left, top_right = (20, -90, 90), (20, 90, 90)
    wall = [[left, right, tip], [right, top_right, tip], [left, tip, top_left], [tip, top_right, top_left]]
    target = [[(40, -30, -40), (40, 30, -40), (40, 0, 36)]]
    return 4 in idle_listed(flagged(wall + target, (1, 2, 3), ()))


def one_sided_face_from_behind() -> bool:
    """A segment that comes from behind proves nothing of a one-sided face."""
    geometry = build_geometry(flagged([[(20, -9, -9), (20, 9, -9), (20, 0, 9)]], (), (0,)), FRAME)
    t = (20.0 * UNIT, 0.0, 0.0)
    from_front = sees(geometry, (30.0 * UNIT, 0.0, 0.0), t, 0)
    return bool(from_front and not sees(geometry, (0.0, 0.0, 0.0), t, 0))


def one_sided_face_across_the_cell() -> bool:
    """A one-sided floor whose plane cuts the cell is visible from above it."""
    return idle_listed(flagged([[(20, -9, 0), (60, 0, 0), (20, 9, 0)]], (), (0,))) == [0]


def face_just_out_of_range() -> bool:
    """A free segment that is longer than the range, but not along the first axis, proves nothing."""
    scene = flagged([[(20, -9, -9), (20, 9, -9), (20, 0, 9)]], (), ())
    geometry = build_geometry(scene, FRAME, 12 * scene.step)
    t = (20.0 * UNIT, 0.0, 0.0)
    near, far = (8.5 * UNIT, 0.0, 0.0), (8.5 * UNIT, 6.0 * UNIT, 0.0)
    return bool(sees(geometry, near, t, 0) and not sees(geometry, far, t, 0))


def face_just_within_the_range() -> bool:
    """A face 16 steps from the cell is visible within 17."""
    scene = flagged([[(20, -9, -9), (20, 9, -9), (20, 0, 9)]], (), ())
    return idle_listed(scene, 17 * scene.step) == [0]


PROBES = (
    wall_with_a_gap,
    wall_that_pierces,
    wall_between_two_cells,
    closed_solid_through_its_edge,
    box_behind_a_wall_it_touches,
    suggestion_behind_a_wall,
    opaque_wall_that_goes_on_porous,
    one_sided_face_from_behind,
    one_sided_face_across_the_cell,
    face_just_out_of_range,
    face_just_within_the_range,
)


def main() -> dict[str, bool]:
    """Name of each probe and whether its answer is sound."""
    return {probe.__name__: bool(probe()) for probe in PROBES}


if __name__ == "__main__":
    print(json.dumps(main()))  # noqa: T201
