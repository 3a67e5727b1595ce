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
"""Height above the lowest face at which cells are cut for the picture, m."""
LEAST_AREA = 0.01
"""Smaller sections cannot be seen in the picture, m2."""
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
    """What is drawn, metres, nav frame."""

    corners: NDArray[np.float64]
    """(F, 3, 3) of all faces."""
    layer: dict[int, NDArray[np.float64]]
    """Cells that a horizontal plane at eye height meets, with the outlines (K, 2) in it."""


def read_town(tileset: NavTileset) -> Town:
    """Read faces in the order of their numbers, and the cells at eye height."""
    corners = np.concatenate([tileset.corners(content) for content in range(len(tileset.contents))])
    planes = np.concatenate([sector.planes for sector in tileset.sectors])
    low, high = corners.reshape(-1, 3).min(axis=0), corners.reshape(-1, 3).max(axis=0)
    plan = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
    sections = (section(six, plan.astype(np.float64), float(low[2]) + EYE_HEIGHT) for six in planes)
    layer = {cell: outline for cell, outline in enumerate(sections) if area(outline) > LEAST_AREA}
    return Town(corners.astype(np.float64), layer)


def section(planes: NDArray[np.float64], plan: NDArray[np.float64], height: float) -> NDArray[np.float64]:
    """Part (K, 2) of a polygon (P, 2) at a height that lies in a cell, by cutting it with each plane (6, 4).

    References
    ----------
    I. E. Sutherland, G. W. Hodgman, "Reentrant polygon clipping", Communications of the ACM 17(1), 1974.
    """
    for nx, ny, nz, d in planes:
        over = plan @ np.array([nx, ny]) + nz * height + d
        kept = []
        for a in range(len(plan)):
            b = (a + 1) % len(plan)
            if over[a] <= 0:
                kept.append(plan[a])
            if over[a] * over[b] < 0:
                kept.append(plan[a] + over[a] / (over[a] - over[b]) * (plan[b] - plan[a]))
        plan = np.array(kept).reshape(-1, 2)
    return plan


def area(outline: NDArray[np.float64]) -> float:
    """Area of a polygon (K, 2) that runs counter-clockwise, m2."""
    x, y = outline[:, 0], outline[:, 1]
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2)


def choose_cell(town: Town) -> int:
    """Return the largest cell at eye height in the middle third of the town."""
    span = town.corners.reshape(-1, 3)
    middle = (span.min(axis=0) + span.max(axis=0))[:2] / 2
    reach = np.ptp(span, axis=0)[:2] / 6
    near = [
        cell for cell, outline in town.layer.items() if np.all(abs(outline.mean(axis=0) - middle) < reach)
    ]
    return max(near, key=lambda cell: area(town.layer[cell]))


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


def polygon(outline: NDArray[np.float64], kind: str) -> str:
    """Outline of a cell."""
    return f'<polygon class="{kind}" points="{" ".join(f"{x:.2f},{-y:.2f}" for x, y in outline)}"/>'


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
        *(polygon(outline, "cell") for outline in town.layer.values()),
        polygon(town.layer[cell], "here"),
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
