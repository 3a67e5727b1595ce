"""Draw the README's picture: the sample town from above, the cells of one layer, and what one cell may see.

The picture is made from an encoded tileset alone, by the reader of the package.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cli import main as tilesnav
from tilesnav_ref.stream.reader import NavTileset, open_tileset

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "figures" / "town.svg"
WIDTH = 840
EYE_HEIGHT = 2.0
"""Height above the lowest cell's floor of the layer that is drawn, m."""
FLAT = 0.05
"""A face whose projection has less than this share of its area counts as a wall and is drawn as a line."""

STYLE = """
  .ground { fill: #f4f1ea } .seen-ground { fill: #ffe3b0 }
  .roof { fill: #cfd4da } .seen-roof { fill: #f6a13c }
  .wall { stroke: #6b7480; stroke-width: .18; fill: none }
  .seen-wall { stroke: #d9480f; stroke-width: .5; fill: none }
  .cell { fill: none; stroke: #4c6ef5; stroke-width: .1 }
  .here { fill: #1c3faa; stroke: none }
""".strip("\n")


@dataclass(frozen=True)
class Town:
    """What is drawn: corners (F, 3, 3) of all faces and bounds (N, 2, 3) of all cells, metres, nav frame."""

    corners: NDArray[np.float64]
    bounds: NDArray[np.float64]


def read_town(tileset: NavTileset) -> Town:
    """Read faces in the order of their numbers, and cells, whose planes must be those of boxes."""
    corners = np.concatenate([tileset.corners(content) for content in range(len(tileset.contents))])
    planes = np.concatenate([sector.planes for sector in tileset.sectors])
    bounds = np.empty((len(planes), 2, 3))
    for axis in range(3):
        for side, sign in ((0, -1.0), (1, 1.0)):
            facing = planes[:, :, axis] == sign
            if not np.all(facing.sum(axis=1) == 1):
                raise ValueError("the picture shows boxes only, and a cell is none")
            bounds[:, side, axis] = -sign * planes[:, :, 3][facing]
    return Town(corners.astype(np.float64), bounds)


def choose_cell(town: Town) -> int:
    """Return the largest cell at eye height in the middle third of the town."""
    low, high = town.bounds[:, 0], town.bounds[:, 1]
    centre = (low + high) / 2
    span = town.corners.reshape(-1, 3)
    middle = (span.min(axis=0) + span.max(axis=0)) / 2
    near = np.all(np.abs(centre - middle)[:, :2] < np.ptp(span, axis=0)[:2] / 6, axis=1)
    area = np.prod((high - low)[:, :2], axis=1)
    return int(np.argmax(np.where(near & layer(town), area, -1.0)))


def layer(town: Town) -> NDArray[np.bool_]:
    """Cells that a horizontal plane at eye height meets."""
    height = town.bounds[:, 0, 2].min() + EYE_HEIGHT
    return np.asarray((town.bounds[:, 0, 2] <= height) & (town.bounds[:, 1, 2] > height))


def face_shapes(town: Town, seen: NDArray[np.bool_]) -> list[str]:
    """Paths of all faces, from low to high, hidden before seen."""
    edges = town.corners[:, 1:] - town.corners[:, :1]
    normals = np.cross(edges[:, 0], edges[:, 1])
    wall = np.abs(normals[:, 2]) < FLAT * np.linalg.norm(normals, axis=1)
    ground = ~wall & (town.corners[:, :, 2].max(axis=1) <= town.corners[:, :, 2].min() + EYE_HEIGHT)
    kinds = (("ground", ground), ("roof", ~wall & ~ground), ("wall", wall))
    shapes = []
    for prefix, chosen in (("", ~seen), ("seen-", seen)):
        for kind, mask in kinds:
            commands = "".join(path_of(face) for face in town.corners[chosen & mask])
            shapes.append(f'<path class="{prefix}{kind}" d="{commands}"/>')
    order = [0, 3, 1, 4, 2, 5]  # ground below roofs below walls
    return [shapes[index] for index in order]


def path_of(face: NDArray[np.float64]) -> str:
    """Projection of a triangle as path commands, 0.1 m.

    All are wound alike: where two of one path overlap, opposite windings would leave a hole.
    """
    one, two = face[1, :2] - face[0, :2], face[2, :2] - face[0, :2]
    if one[0] * two[1] < one[1] * two[0]:
        face = face[::-1]
    return "M" + "L".join(f"{x:.1f},{-y:.1f}" for x, y, _ in face) + "z"


def rectangle(bounds: NDArray[np.float64], kind: str) -> str:
    """Footprint of a cell."""
    (x0, y0, _), (x1, y1, _) = bounds
    return f'<rect class="{kind}" x="{x0:.2f}" y="{-y1:.2f}" width="{x1 - x0:.2f}" height="{y1 - y0:.2f}"/>'


def draw(tileset: NavTileset) -> str:
    """Return the picture as SVG."""
    town = read_town(tileset)
    cell = choose_cell(town)
    seen = np.zeros(tileset.face_count, dtype=np.bool_)
    seen[tileset.state(cell).faces] = True
    low, high = town.corners.reshape(-1, 3).min(axis=0), town.corners.reshape(-1, 3).max(axis=0)
    width, height = (high - low)[:2] + 4.0
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{WIDTH * height / width:.0f}" '
        f'viewBox="{low[0] - 2:.1f} {-high[1] - 2:.1f} {width:.1f} {height:.1f}">',
        f"<title>Top view of the sample town: the {int(seen.sum())} of {len(seen)} faces that may be seen "
        f"from cell {cell}</title>",
        f"<style>\n{STYLE}\n</style>",
        *face_shapes(town, seen),
        *(rectangle(bounds, "cell") for bounds in town.bounds[layer(town)]),
        rectangle(town.bounds[cell], "here"),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def main() -> int:
    """Encode the sample town and write the picture."""
    with tempfile.TemporaryDirectory() as name:
        scene, out = Path(name) / "town.ply", Path(name) / "tileset"
        status = tilesnav(["sample", str(scene), "--detail", "coarse"]) or tilesnav(
            ["encode", str(scene), str(out), "--quiet"]
        )
        if status:
            return status
        PICTURE.parent.mkdir(parents=True, exist_ok=True)
        PICTURE.write_text(draw(open_tileset(out)), encoding="utf-8")
    print(PICTURE.relative_to(ROOT))
    return 0


if __name__ == "__main__":
    sys.exit(main())
