"""The billboard of the paper's figure 8: L(phi, d) of its triangles from a cell very near to it.

Usage: python benchmarks/billboard.py [--plot billboard.png]

A square board of 98 triangles on a pedestal of ten, and a cell (a box) 0.3 m in front of it. For each
triangle the largest L = cos(phi) / d over the whole cell and the whole triangle, which is what the encoder
codes, beside the rule of the paper: the largest of the values at the corners and the centroid of the
triangle, seen from the corners of the cell. `--plot` needs the extra `bench`.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.lod import LodSettings, largest_level
from tilesnav_ref.lod.codes import level_codes

Array = NDArray[np.float64]

SIDE = 7
"""Squares along a side of the board, two triangles each: about a hundred."""
BOARD = (-3.5, 3.5, 1.0, 8.0)
"""Left, right, lower and upper edge of the board in the plane y = 0, m."""
PEDESTAL = ((-1.0, -1.0, 0.0), (1.0, 1.0, 0.75))
"""Lower and upper corner of the pedestal, m."""
GAP = 0.3
"""From the cell to the board, m."""
MIDDLE = (1.0, 4.5)
"""x and z of the middle of the cell, m."""
SIZE = 0.5
"""Edge of the cell, m."""


def board(side: int = SIDE) -> Array:
    """(2 * side * side, 3, 3) triangles of the board, m."""
    left, right, bottom, top = BOARD
    xs, zs = np.linspace(left, right, side + 1), np.linspace(bottom, top, side + 1)
    triangles = []
    for a, b in pairwise(xs.tolist()):
        for low, high in pairwise(zs.tolist()):
            triangles.append(((a, 0.0, low), (b, 0.0, low), (b, 0.0, high)))
            triangles.append(((a, 0.0, low), (b, 0.0, high), (a, 0.0, high)))
    return np.array(triangles)


def pedestal() -> Array:
    """(10, 3, 3) triangles of the top and the four sides of the pedestal, m."""
    (x0, y0, z0), (x1, y1, z1) = PEDESTAL
    ring = ((x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0))
    squares = [((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1))]
    squares += [((*a, z0), (*b, z0), (*b, z1), (*a, z1)) for a, b in pairwise(ring)]
    return np.array([(s[0], *pair) for s in squares for pair in (s[1:3], s[2:4])])


def cell(size: float = SIZE) -> Array:
    """(8, 3) corners of a cell of that edge in front of the board, m; bit k of a number: side of axis k."""
    x, z = MIDDLE
    lower = np.array((x - size / 2, -GAP - size, z - size / 2))
    upper = (np.arange(8)[:, None] >> np.arange(3)) & 1
    return np.asarray(lower + upper * size, dtype=np.float64)


def sampled_rule(corners: Array, triangle: Array) -> float:
    """The paper's estimate: the largest L between the corners of a cell and four points of a triangle.

    Parameters
    ----------
    corners : (8, 3) float64
        Of the cell, m.
    triangle : (3, 3) float64
        Corners, m.

    Returns
    -------
    float
        1/m.

    References
    ----------
    "Lidar Data Reduction for Unmanned Systems Navigation in Urban Canyon", section 4.6: "based on its samples
    on all corner vertices and the triangle centroid".
    """
    points = np.concatenate((triangle, triangle.mean(axis=0, keepdims=True)))
    normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
    rays = (corners[:, None] - points[None]).reshape(-1, 3)
    values = np.abs(rays @ normal) / np.linalg.norm(normal) / np.einsum("ij,ij->i", rays, rays)
    return float(values.max())


def both(triangles: Array, corners: Array) -> tuple[Array, Array]:
    """Exact and sampled largest L of each triangle from a cell, 1/m."""
    exact = np.array([largest_level(corners, triangle) for triangle in triangles])
    return exact, np.array([sampled_rule(corners, triangle) for triangle in triangles])


def row(name: str, triangles: Array, corners: Array) -> str:
    """A row of the table."""
    exact, sampled = both(triangles, corners)
    ratio = exact / sampled
    settings = LodSettings()
    coarser = np.count_nonzero(level_codes(sampled, settings) > level_codes(exact, settings))
    object_ratio = exact.max() / sampled.max()
    figures = (f"{ratio.max():.2f}", f"{np.median(ratio):.2f}", f"{object_ratio:.2f}", f"{coarser}")
    return " | ".join((f"| {name}", f"{len(triangles):,}", *figures)) + " |"


def plot(path: Path) -> None:
    """Draw the board from its front with both values and their ratio, and all of it from above."""
    from matplotlib import pyplot as plt  # noqa: PLC0415 - an extra
    from matplotlib.cm import ScalarMappable  # noqa: PLC0415
    from matplotlib.colors import LogNorm, Normalize  # noqa: PLC0415

    triangles = np.concatenate((board(), pedestal()))
    exact, sampled = both(triangles, cell())
    scale: dict[str, Any] = {"norm": LogNorm(exact.min(), exact.max()), "cmap": "turbo"}
    ratios: dict[str, Any] = {"norm": Normalize(1.0, (exact / sampled).max()), "cmap": "Purples"}
    figure, axes = plt.subplots(2, 3, figsize=(13, 6.6), height_ratios=(9, 3.2), layout="constrained")
    draw(axes[0, 0], triangles, exact, scale, (0, 2))
    axes[0, 0].set(title="Front, exact", ylabel="z, m")
    draw(axes[0, 1], triangles, sampled, scale, (0, 2))
    axes[0, 1].set(title="Front, samples of the paper's rule")
    draw(axes[0, 2], triangles, exact / sampled, ratios, (0, 2))
    axes[0, 2].set(title="Front, exact / samples")
    for place, title, values in ((axes[1, 0], "exact", exact), (axes[1, 1], "samples", sampled)):
        draw(place, triangles, values, scale, (0, 1))
        place.set(title=f"Top, {title}", xlabel="x, m", ylabel="y, m")
    axes[1, 2].set_axis_off()
    figure.colorbar(ScalarMappable(**scale), ax=axes[:, 1], label="L*, 1/m")
    figure.colorbar(ScalarMappable(**ratios), ax=axes[0, 2], label="factor")
    figure.savefig(path, dpi=90)


def draw(axes: Any, triangles: Array, values: Array, scale: dict[str, Any], plane: tuple[int, int]) -> None:
    """Triangles in an orthographic view, those that are seen from the edge as lines, and the cell in grey."""
    from matplotlib.collections import PolyCollection  # noqa: PLC0415 - an extra
    from matplotlib.patches import Rectangle  # noqa: PLC0415

    # What lies nearer to the viewer is drawn last: the least y from the front, the greatest z from above.
    depth = triangles[:, :, 1].max(axis=1) * -1.0 if plane == (0, 2) else triangles[:, :, 2].min(axis=1)
    order = np.argsort(depth, kind="stable")
    faces = PolyCollection(list(triangles[order][:, :, plane]), array=values[order], **scale)
    faces.set(edgecolor="face" if plane == (0, 1) else "#333333", linewidth=2.5 if plane == (0, 1) else 0.4)
    axes.add_collection(faces)
    corners = cell()[:, plane]
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    axes.add_patch(Rectangle(lower, *(upper - lower), facecolor="#80808099", edgecolor="black"))
    axes.set_aspect("equal")
    axes.autoscale_view()


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plot", type=Path)
    given = parser.parse_args()
    everything = np.concatenate((board(), pedestal()))
    exact, _ = both(everything, cell())
    print(f"L* of {len(exact)} triangles: {exact.min():.4f} to {exact.max():.2f} 1/m\n")
    print("| what | triangles | exact / samples, most | median | of the whole | coarser code |")
    print("|---|---|---|---|---|---|")
    print(row("board and pedestal", everything, cell()))
    for side in (SIDE, 4 * SIDE, 16 * SIDE):
        print(row(f"board, triangles of {(BOARD[1] - BOARD[0]) / side:g} m", board(side), cell()))
    for size in (2.0, 4.0):
        print(row(f"board and pedestal, cell of {size:g} m", everything, cell(size)))
    if given.plot:
        plot(given.plot)


if __name__ == "__main__":
    main()
