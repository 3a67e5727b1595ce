"""Table 2, figure 9 and table 3 of the paper, beside what this repository gives.

Usage: python benchmarks/paper.py [--munich munich.ply] [--tileset NAME=OUT ...] [--speed 20]

Table 2 (storage) is made from the sample town at its fine setting, and from a region of 200 m of Munich
where its mesh is named. Figure 9 and table 3 need tilesets with coarse levels; each is driven along the stock
routes of `tilesnav path`. The paper's scene is not public, so its figures stand beside, not against. No test
asserts a time.
"""

from __future__ import annotations

import argparse
import lzma
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.levels import CoarseLevel, LevelSettings, coarse_levels
from tilesnav_ref.packet.change import apply_packet, make_packet
from tilesnav_ref.packet.model import ObjectFaces
from tilesnav_ref.packet.state import HeldState, Parts
from tilesnav_ref.scene import Scene, SceneSettings, load_scene
from tilesnav_ref.scene.sample import TRAINING_SITE, make_town
from tilesnav_ref.stream.errors import RouteError
from tilesnav_ref.stream.levels import LevelFaces, smallest_first
from tilesnav_ref.stream.path import PathResult, PathSettings, run_path
from tilesnav_ref.stream.policy import NAMES
from tilesnav_ref.stream.reader import NavTileset, open_tileset
from tilesnav_ref.stream.sender import LIMITS
from tilesnav_ref.stream.stock import STOCK

REGION = (-100.0, -100.0, 100.0, 100.0)
"""Of Munich, m."""
SITE = (-50.0, -50.0, 50.0, 50.0)
"""Of the sample town, m."""
GRID_EXPONENT = -7
"""Of Munich in table 2: 2^-7 m, about 1 cm. Coordinates of the town are multiples of 2^-6 m by themselves."""
PITCH = 0.05
"""m between the points of the paper's cloud."""
POINT_BYTES = 12
"""x, y and z as float32."""
PAPER_STORAGE = (
    ("extent of the site, m2", "10,000"),
    ("surfaces, m2", "20,000"),
    ("cloud of 5 cm pitch, points", "180,000,000"),
    ("cloud, kB", "not stated"),
    ("vertices, fine", "30,000"),
    ("faces, fine", "70,000"),
    ("error, fine, m", "not stated"),
    ("fine, kB", "183"),
    ("fine, bytes a face", "2.61"),
    ("fine, indexed and LZMA, bytes a face", ""),
    ("vertices, coarse", "1,800"),
    ("faces, coarse", "3,000"),
    ("error, coarse, m", "not stated"),
    ("coarse, kB", "4"),
    ("coarse, bytes a face", "1.33"),
    ("coarse, indexed and LZMA, bytes a face", ""),
    ("cloud / fine", ""),
    ("fine / coarse", "46"),
)
"""Rows of table 2, and what the paper states."""
PAPER_BANDWIDTH = {("roof", "auto"): "51", ("ground", "auto"): "24"}
"""Mean kB/s that the paper states in its text."""
PAPER_REDUCTION = {
    ("roof", "fine"): "3.3",
    ("ground", "fine"): "10.0",
    ("roof", "coarse"): "17.1",
    ("ground", "coarse"): "85.7",
    ("roof", "auto"): "2.9",
    ("ground", "auto"): "10",
}
"""Table 3, %."""


Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stored:
    """A level as it is stored."""

    vertices: int
    faces: int
    error: float
    size: int
    """Bytes of its faces by the codec of packets."""
    plain: int
    """Bytes of an indexed mesh (int32 vertices, uint32 corners) by LZMA, as the paper names it."""

    def cells(self) -> list[str]:
        """Six cells of the table."""
        each = (self.size / self.faces, self.plain / self.faces)
        return [
            f"{self.vertices:,}",
            f"{self.faces:,}",
            f"{self.error:.2f}",
            f"{self.size / 1e3:,.1f}",
            *(f"{one:.2f}" for one in each),
        ]


def stored(scene: Scene, errors: Array) -> Stored:
    """Store all faces of a level."""
    used, corners = np.unique(scene.faces, return_inverse=True)
    raw = scene.vertices[used].astype("<i4").tobytes() + corners.astype("<u4").tobytes()
    state = HeldState(bytes(8), 0, False, parts_of(scene))
    return Stored(
        len(used),
        scene.face_count,
        float(errors.max(initial=0.0)),
        packed(state),
        len(lzma.compress(raw, preset=9)),
    )


def packed(state: HeldState) -> int:
    """Bytes of all faces of a state by the codec of packets; PacketError unless they are read back alike."""
    packet = make_packet(None, state)
    apply_packet(packet, None, LIMITS)  # the mark in the packet is that of the state
    return len(packet.body)


def parts_of(scene: Scene) -> Parts:
    """All faces of a scene, object by object."""
    offsets = np.searchsorted(scene.face_object, np.arange(scene.object_count + 1))
    return all_parts(LevelFaces(offsets, smallest_first(scene.corners().astype(np.int32))), 0)


def all_parts(geometry: LevelFaces, level: int) -> Parts:
    """All faces of a level, object by object."""
    bounds = geometry.offsets.tolist()
    return tuple(
        ObjectFaces(number, level, 0, np.arange(b - a, dtype=np.uint32), geometry.corners[a:b])
        for number, (a, b) in enumerate(pairwise(bounds))
    )


def area_within(corners: Array, region: tuple[float, float, float, float]) -> float:
    """Area of the parts of triangles (F, 3, 3), m, that lie in a rectangle of the plan, m2.

    References
    ----------
    I. Sutherland, G. Hodgman, "Reentrant polygon clipping", Communications of the ACM 17(1), 1974.
    """
    total = 0.0
    for triangle in corners:
        ring = triangle
        for axis, sign, border in zip((0, 1, 0, 1), (1, 1, -1, -1), region, strict=True):
            ring = _clipped(ring, sign * (ring[:, axis] - border))
        crosses = np.cross(ring[1:-1] - ring[:1], ring[2:] - ring[:1])
        total += float(np.linalg.norm(crosses.sum(axis=0))) / 2 if len(ring) > 2 else 0.0
    return total


def _clipped(ring: Array, inside: Array) -> Array:
    """Part of a polygon where a linear function, given at its corners, is not negative."""
    kept = []
    for k in range(len(ring)):
        before, here = inside[k - 1], inside[k]
        if before * here < 0.0:
            kept.append(ring[k - 1] + (ring[k] - ring[k - 1]) * (before / (before - here)))
        if here >= 0.0:
            kept.append(ring[k])
    return np.array(kept).reshape(-1, 3)


def storage(scene: Scene, region: tuple[float, float, float, float]) -> list[str]:
    """A column of table 2; all faces count for the mesh, their parts in the region for the cloud."""
    extent = (region[2] - region[0]) * (region[3] - region[1])
    area = area_within(np.asarray(scene.corners() * scene.step, np.float64), region)
    points = area / PITCH**2
    coarse: CoarseLevel = coarse_levels(scene, LevelSettings(3))[-1]
    fine, coarsest = stored(scene, np.zeros(1)), stored(coarse.scene, coarse.errors)
    ratios = (points * POINT_BYTES / fine.size, fine.size / coarsest.size)
    cloud = [f"{points:,.0f}", f"{points * POINT_BYTES / 1e3:,.0f}"]
    head = [f"{extent:,.0f}", f"{area:,.0f}", *cloud]
    return [*head, *fine.cells(), *coarsest.cells(), *(f"{ratio:,.0f}" for ratio in ratios)]


def print_storage(scenes: dict[str, tuple[Scene, tuple[float, float, float, float]]]) -> None:
    """Table 2."""
    columns = {name: storage(*scene) for name, scene in scenes.items()}
    print("| | paper | " + " | ".join(columns) + " |")
    print("|---" * (2 + len(columns)) + "|")
    for row, (name, paper) in enumerate(PAPER_STORAGE):
        print(f"| {name} | {paper} | " + " | ".join(column[row] for column in columns.values()) + " |")


def whole_map(tileset: NavTileset) -> dict[str, tuple[int, int]]:
    """Faces of the level that a policy starts from, and their bytes in one key frame."""
    last = tileset.levels[-1]
    fine, coarse = all_parts(tileset.finest, 0), all_parts(last.geometry, last.level)
    states = {
        name: HeldState(bytes(8), 0, False, parts)
        for name, parts in zip(NAMES, (fine, coarse, fine), strict=True)
    }
    return {name: (state.face_count, packed(state)) for name, state in states.items()}


def reduction(part: float, whole: float) -> str:
    """What is saved, in percent."""
    return f"{100 * (1 - part / whole):.1f}"


def print_route(name: str, route: str, result: PathResult, whole: dict[str, tuple[int, int]]) -> None:
    """Figure 9 and table 3 for one route."""
    rivals = {rival.name: rival.coded for rival in result.rivals}
    # One tile an object is the kinder tiling; vehicles keep what they have received, on both sides.
    ordinary, within = rivals["objects-keep"], rivals["range-keep"]
    for policy in NAMES:
        series, all_kept = result.drives[policy].series, result.keeping[policy].series
        mean = f"{series.mean / 1e3:.1f}"
        figures = (f"{series.first / 1e3:,.1f}", mean, PAPER_BANDWIDTH.get((route, policy), ""))
        shares = (
            PAPER_REDUCTION[route, policy],
            reduction(float(result.keeping[policy].new_faces.sum()), whole[policy][0]),
            reduction(all_kept.total, whole[policy][1]),
            reduction(all_kept.total, within.total),
            reduction(all_kept.total, ordinary.total),
        )
        held = f"{series.mean_held:,.0f}"
        print(
            " | ".join((f"| {name}", route, policy, *figures, f"{series.total / 1e3:,.0f}", held, *shares))
            + " |"
        )


HEADS = (
    *("scene", "path", "detail", "start, kB", "mean, kB/s", "paper", "all, kB", "faces held"),
    *("paper's table 3, %", "faces never sent, %", "bytes less than the whole map, %"),
    *("than all in range, %", "than 3D Tiles, %"),
)


def print_paths(tilesets: dict[str, NavTileset], speed: float) -> None:
    """Figure 9 and table 3 for every tileset."""
    print("| " + " | ".join(HEADS) + " |")
    print("|---" * len(HEADS) + "|")
    lengths = []
    for name, tileset in tilesets.items():
        whole = whole_map(tileset)
        for route in STOCK:
            try:
                result = run_path(tileset, PathSettings(route=route, speed=speed), _silent)
            except RouteError as error:  # a corridor in the streets has no way over the roofs
                lengths.append(f"{name}, no {route}: {error}")
                continue
            print_route(name, route, result, whole)
            lengths.append(
                f"{name}, {route}: {result.route.length:,.0f} m, {len(result.route.passages)} cells"
            )
    print("\n" + "; ".join(lengths))


def _silent(stage: str, done: int, total: int) -> None:
    """Progress is not shown."""


def named(text: str) -> tuple[str, Path]:
    """Split NAME=OUT."""
    name, equals, path = text.partition("=")
    if not (name and equals and path):
        raise argparse.ArgumentTypeError(f"found {text!r}; allowed: NAME=OUT")
    return name, Path(path)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--no-storage", action="store_true", help="without table 2")
    parser.add_argument("--munich", type=Path, help="munich.ply; its region of 200 m goes into table 2")
    parser.add_argument("--grid-exponent", type=int, default=GRID_EXPONENT, help="grid of Munich in table 2")
    parser.add_argument("--tileset", type=named, action="append", default=[], metavar="NAME=OUT")
    parser.add_argument("--speed", type=float, default=20.0, help="m/s")
    given = parser.parse_args()
    if not given.no_storage:
        scenes = {"sample town": (make_town(TRAINING_SITE), SITE)}
        if given.munich:
            settings = SceneSettings(region=REGION, grid_exponent=given.grid_exponent)
            scenes["Munich, 200 m"] = (load_scene(given.munich, settings)[0], REGION)
        print_storage(scenes)
        print()
    tilesets = {name: open_tileset(path) for name, path in given.tileset}
    for name, tileset in tilesets.items():
        if not tileset.levels:
            parser.error(
                f"{name}: found no coarse levels; allowed: a tileset of `tilesnav encode --levels 3`"
            )
    if tilesets:
        print_paths(tilesets, given.speed)


if __name__ == "__main__":
    main()
