"""A picture of cells and their connections, from above and in perspective.

Notes
-----
matplotlib is an extra and imported where it is used.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.cells.settings import CellError
from tilesnav_ref.scene.model import Scene

SUFFIXES = (".png", ".svg", ".pdf")
SIDES = ((0, 2, 6, 4), (1, 3, 7, 5), (0, 1, 5, 4), (2, 3, 7, 6), (0, 1, 3, 2), (4, 5, 7, 6))
"""Corners around each of the six sides of a cell, whose corner i is on the upper side of axis k where bit k
of i is set."""
WIDTH, HEIGHT, DOTS = 15.0, 7.2, 150
"""Inches, inches, dots an inch."""
FACES_DRAWN = 60_000
"""Of more faces than this the largest are drawn; the others would be smaller than a dot."""
ALL_DRAWN = 300
"""Of more cells than this the perspective leaves out those above the roofs, which would hide the others."""
ABOVE_ROOFS = 1.0
"""m; cells that begin higher than this above all faces below them are above the roofs."""
RASTER = 128
"""Squares along the longer side of the plan by which this is decided."""
LINES_DRAWN = 20_000
"""Of more portals than this an evenly spaced choice is drawn."""


@dataclass(frozen=True)
class View:
    """What is drawn, in metres."""

    faces: list[NDArray[np.float64]]
    """(K, 3) polygons of the faces of the scene over the plan of the cells."""
    sides: NDArray[np.float64]
    """(N, 6, 4, 3) corners around the sides of every cell."""
    heights: NDArray[np.float64]
    """(N,) of the middles of the cells."""
    paths: NDArray[np.float64]
    """(P, 3, 3) from the middle of a cell through the middle of a portal to the middle of the next."""
    stood: tuple[NDArray[np.bool_], NDArray[np.bool_]]
    """(N,) cells and (P,) paths that the perspective shows."""
    box: NDArray[np.float64]
    """(2, 3) bounds of the cells."""


def make_view(scene: Scene, cells: CellComplex) -> View:
    """Work out what a picture shows of a scene and its cells."""
    step = scene.step
    corners = cells.corners * np.float64(step)
    middles = corners.mean(axis=1)
    sources = np.repeat(np.arange(cells.count), np.diff(cells.portal_offsets))
    once = np.flatnonzero(sources < cells.portal_targets)
    once = once[:: max(1, -(-len(once) // LINES_DRAWN))]
    through = _polygon_middles(cells)[cells.portal_polygons[once]] * step
    paths = np.stack((middles[sources[once]], through, middles[cells.portal_targets[once]]), axis=1)
    box = np.stack((corners.min(axis=(0, 1)), corners.max(axis=(0, 1)))).astype(np.float64)
    faces = _faces_near(scene, box)
    shown = np.ones(cells.count, np.bool_)
    if cells.count > ALL_DRAWN:
        shown = _near_faces(faces, corners)
    both = shown[sources[once]] & shown[cells.portal_targets[once]]
    return View(faces, np.asarray(corners[:, SIDES], np.float64), middles[:, 2], paths, (shown, both), box)


def _polygon_middles(cells: CellComplex) -> NDArray[np.float64]:
    """(Q, 3) means of the vertices of the polygons, grid."""
    counts = np.diff(cells.polygon_offsets)
    if len(counts) == 0:
        return np.zeros((0, 3))
    sums = np.add.reduceat(cells.polygon_vertices, cells.polygon_offsets[:-1], axis=0)
    return np.asarray(sums / counts[:, None])


def _faces_near(scene: Scene, box: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Polygons (K, 3) of the faces, cut to the plan of a box."""
    corners = scene.corners() * scene.step
    low, high = corners[:, :, :2].min(axis=1), corners[:, :, :2].max(axis=1)
    faces = corners[np.all((high >= box[0, :2]) & (low <= box[1, :2]), axis=1)]
    if len(faces) > FACES_DRAWN:
        areas = np.linalg.norm(np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0]), axis=1)
        faces = faces[np.sort(np.argsort(-areas, kind="stable")[:FACES_DRAWN])]
    inside = np.all((faces[:, :, :2] >= box[0, :2]) & (faces[:, :, :2] <= box[1, :2]), axis=(1, 2))
    cut = [face if whole else _cut(face, box) for face, whole in zip(faces, inside, strict=True)]
    return [face for face in cut if len(face) >= 3]


def _cut(polygon: NDArray[np.float64], box: NDArray[np.float64]) -> NDArray[np.float64]:
    """A convex polygon (K, 3) cut to the plan of a box (Sutherland and Hodgman, CACM 17(1), 1974)."""
    for axis in range(2):
        for place, sign in ((box[0, axis], 1.0), (box[1, axis], -1.0)):
            inner = sign * (polygon[:, axis] - place)
            kept = []
            for here, there, a, b in zip(
                polygon, np.roll(polygon, -1, axis=0), inner, np.roll(inner, -1), strict=True
            ):
                if a >= 0.0:
                    kept.append(here)
                if a * b < 0.0:
                    kept.append(here + a / (a - b) * (there - here))
            polygon = np.array(kept).reshape(-1, 3)
            if len(polygon) == 0:
                return polygon
    return polygon


def _near_faces(faces: list[NDArray[np.float64]], corners: NDArray[np.floating[Any]]) -> NDArray[np.bool_]:
    """Which cells (N, 8, 3) begin no higher than a little above the faces below them; (N,) bool."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    least, pitch = (
        low[:, :2].min(axis=0),
        max(float(np.ptp(corners[:, :, :2], axis=(0, 1)).max()) / RASTER, 1e-9),
    )
    tops = np.full((RASTER + 1, RASTER + 1), -np.inf)
    for face in faces:
        i, j = ((face[:, :2].min(axis=0) - least) / pitch).astype(int).clip(0, RASTER)
        k, m = ((face[:, :2].max(axis=0) - least) / pitch).astype(int).clip(0, RASTER) + 1
        tops[i:k, j:m] = np.maximum(tops[i:k, j:m], face[:, 2].max())
    first = ((low[:, :2] - least) / pitch).astype(int).clip(0, RASTER)
    last = ((high[:, :2] - least) / pitch).astype(int).clip(0, RASTER) + 1
    return np.array(
        [
            z <= tops[a:c, b:d].max() + ABOVE_ROOFS
            for z, (a, b), (c, d) in zip(low[:, 2], first, last, strict=True)
        ]
    )


def check_picture(path: Path) -> None:
    """Refuse what cannot be drawn or written, before any work is done.

    Raises
    ------
    CellError
        Another ending, a folder that is not there, or matplotlib is missing.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise CellError(f"{path}: found the ending {path.suffix!r}; allowed: {', '.join(SUFFIXES)}")
    if not path.parent.is_dir():
        raise CellError(f"{path}: its parent {path.parent} is not a folder")
    _matplotlib()


def _matplotlib() -> Any:
    try:
        import matplotlib  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise CellError(
            "pictures need matplotlib; install the extra: pip install 'tilesnav[plot]'"
        ) from error
    return matplotlib


def draw(scene: Scene, cells: CellComplex, path: Path) -> None:
    """Draw cells and their connections to a file.

    Parameters
    ----------
    scene
        Its faces are drawn in grey.
    cells
        Their sides are coloured by height, and lines run from cell to cell through the portals.
    path
        .png, .svg or .pdf; replaced when it exists.

    Raises
    ------
    CellError
        See :func:`check_picture`.
    """
    check_picture(path)
    matplotlib = _matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - an extra
    from matplotlib.figure import Figure  # noqa: PLC0415 - an extra

    view = make_view(scene, cells)
    with matplotlib.rc_context({"svg.hashsalt": "tilesnav", "font.size": 9}):
        figure = Figure(figsize=(WIDTH, HEIGHT), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.add_gridspec(1, 2, width_ratios=(1.0, 1.15))
        colours = _Colours(view.heights, matplotlib)
        _plan(figure.add_subplot(grid[0]), view, colours)
        _perspective(figure.add_subplot(grid[1], projection="3d", computed_zorder=False), view, colours)
        colours.bar(figure)
        metadata = {"Date": None} if path.suffix.lower() == ".svg" else None
        figure.savefig(path, dpi=DOTS, metadata=metadata)


class _Colours:
    """Colours of cells by the height of their middles."""

    def __init__(self, heights: NDArray[np.float64], matplotlib: Any) -> None:
        high = max(float(heights.max()), float(heights.min()) + 1.0)
        self._norm = matplotlib.colors.Normalize(float(heights.min()), high)
        self._map = matplotlib.colormaps["viridis"]
        self._mappable = matplotlib.cm.ScalarMappable(self._norm, self._map)

    def of(self, heights: NDArray[np.float64], alpha: float) -> NDArray[np.float64]:
        colours = np.array(self._map(self._norm(heights)))
        colours[:, 3] = alpha
        return colours

    def bar(self, figure: Any) -> None:
        figure.colorbar(
            self._mappable,
            ax=figure.axes,
            shrink=0.6,
            pad=0.04,
            label="height of the middle of a cell, z in m",
        )


def _plan(axes: Any, view: View, colours: _Colours) -> None:
    """From above: the highest cells last; faces that stand or slope are outlines over them."""
    from matplotlib.collections import LineCollection, PolyCollection  # noqa: PLC0415 - an extra

    size = _dot_sizes(view)
    low_first = np.argsort(view.heights, kind="stable")
    tops = np.array([face[:, 2].max() for face in view.faces] or [0.0])
    order = np.argsort(tops, kind="stable")
    greys = _greys(0.96 - 0.5 * (tops[order] - tops.min()) / max(float(np.ptp(tops)), 1.0))
    flat = [view.faces[k][:, :2] for k in order] if view.faces else []
    axes.add_collection(PolyCollection(flat, facecolors=greys, edgecolors=greys, linewidths=0.2))
    top = view.sides[low_first, 5, :, :2]
    axes.add_collection(
        PolyCollection(
            list(top),
            facecolors=colours.of(view.heights[low_first], 0.07),
            edgecolors=(0.1, 0.2, 0.4, 0.5),
            linewidths=size[0],
            label="cell",
        )
    )
    axes.add_collection(
        LineCollection(
            list(view.paths[:, :, :2]), colors=(0.85, 0.2, 0.1, 0.45), linewidths=size[1], label="portal"
        )
    )
    middles = view.sides.mean(axis=(1, 2))
    axes.scatter(middles[:, 0], middles[:, 1], s=size[2], color="black", linewidths=0, zorder=3)
    axes.set_xlim(view.box[0, 0], view.box[1, 0])
    axes.set_ylim(view.box[0, 1], view.box[1, 1])
    axes.set_aspect("equal")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    _legend(axes)


def _perspective(axes: Any, view: View, colours: _Colours) -> None:
    from matplotlib.ticker import MaxNLocator  # noqa: PLC0415 - an extra
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection  # noqa: PLC0415 - an extra

    size = _dot_sizes(view)
    axes.add_collection3d(
        Poly3DCollection(view.faces, facecolors=_shades(view.faces), edgecolors="none", zorder=1)
    )
    shown, paths = view.stood
    sides = view.sides[shown].reshape(-1, 4, 3)
    axes.add_collection3d(
        Poly3DCollection(
            sides,
            facecolors=colours.of(np.repeat(view.heights[shown], 6), 0.07),
            edgecolors=(0.1, 0.2, 0.4, 0.35),
            linewidths=size[0],
            zorder=2,
        )
    )
    axes.add_collection3d(
        Line3DCollection(view.paths[paths], colors=(0.85, 0.2, 0.1, 0.5), linewidths=size[1], zorder=3)
    )
    low, high = view.box
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_zlim(low[2], high[2])
    axes.set_box_aspect(np.maximum(high - low, 0.15 * (high - low).max()), zoom=1.1)
    axes.set_proj_type("persp", focal_length=0.8)
    axes.view_init(elev=32.0, azim=-60.0)
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    axes.set_zlabel("z, m")
    axes.zaxis.set_major_locator(MaxNLocator(4))
    if not shown.all():
        axes.annotate(
            "cells above the roofs are left out here",
            (0.5, 0.97),
            xycoords="axes fraction",
            ha="center",
            fontsize=8,
        )


def _greys(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.repeat(values[:, None], 3, axis=1)


def _shades(faces: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Greys of faces lit from the upper left, both sides alike."""
    normals = np.array([np.cross(face[1] - face[0], face[2] - face[0]) for face in faces]).reshape(-1, 3)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return _greys(0.45 + 0.45 * np.abs(normals @ np.array((-0.35, -0.45, 0.82))))


def _dot_sizes(view: View) -> tuple[float, float, float]:
    """Line width of cells and of portals, and size of dots, in points: thinner the more there are."""
    share = min(1.0, (200.0 / max(len(view.heights), 1)) ** 0.5)
    return 0.25 + 0.5 * share, 0.2 + 0.7 * share, 0.5 + 8.0 * share


def _legend(axes: Any) -> None:
    from matplotlib.lines import Line2D  # noqa: PLC0415 - an extra
    from matplotlib.patches import Patch  # noqa: PLC0415 - an extra

    entries = (
        Patch(facecolor="0.7", label="faces of the scene, darker where higher"),
        Patch(facecolor=(0.3, 0.6, 0.5, 0.3), edgecolor=(0.1, 0.2, 0.4, 0.6), label="cell"),
        Line2D([], [], color="black", marker="o", markersize=3, linestyle="none", label="middle of a cell"),
        Line2D([], [], color=(0.85, 0.2, 0.1), label="way through a portal"),
    )
    axes.figure.legend(handles=entries, loc="outside lower center", ncols=4, frameon=False)
