"""A picture of the bandwidth experiment: data and bandwidth over time, what it is compared with, the route.

Notes
-----
matplotlib is an extra and imported where it is used. The upper panels are those of figure 9 of the source
paper.
"""

from __future__ import annotations

from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from tilesnav_ref.stream.bandwidth import WINDOW, Series
from tilesnav_ref.stream.path import PathResult
from tilesnav_ref.stream.places import places_of
from tilesnav_ref.stream.reader import NavTileset

COLOURS = {"fine": "tab:green", "coarse": "tab:blue", "auto": "tab:red"}
"""As in the source paper."""
RIVALS = {"tiles": "black", "objects": "tab:purple", "range": "tab:orange"}
WIDTH, HEIGHT, DOTS = 13.0, 8.6, 150
"""Inches, inches, dots an inch."""
SAMPLES = 800
"""Times at which curves are drawn."""
FACES_DRAWN = 40_000
"""Of more faces than this the largest are drawn; the others would be smaller than a dot."""
MARGIN = 15.0
"""m of the map around the route."""


def draw(tileset: NavTileset, result: PathResult, path: Path, title: str) -> None:
    """Draw data and bandwidth over time, the comparison and a map of the route to a file.

    Parameters
    ----------
    path
        .png, .svg or .pdf; the file is replaced when it exists.
    title
        Of the picture.
    """
    import matplotlib as mpl  # noqa: PLC0415 - an extra
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - an extra
    from matplotlib.figure import Figure  # noqa: PLC0415 - an extra

    with mpl.rc_context({"svg.hashsalt": "tilesnav", "font.size": 9, "axes.titlesize": 10}):
        figure = Figure(figsize=(WIDTH, HEIGHT), layout="constrained")
        FigureCanvasAgg(figure)
        figure.suptitle(title, fontsize=11)
        axes = figure.subplots(2, 2)
        _data(axes[0, 0], result)
        _bandwidth(axes[0, 1], result)
        _comparison(axes[1, 0], result)
        _map(axes[1, 1], tileset, result)
        metadata = {"Date": None} if path.suffix.lower() == ".svg" else None
        figure.savefig(path, dpi=DOTS, metadata=metadata, format=path.suffix[1:].lower())


def _times(series: Series) -> NDArray[np.float64]:
    return np.linspace(0.0, series.duration, SAMPLES)


def _data(axes: Any, result: PathResult) -> None:
    for name, driven in result.drives.items():
        times = _times(driven.series)
        axes.plot(times, driven.series.received(times) / 1e3, color=COLOURS[name], label=name)
    axes.set_title("data received, the start included")
    axes.set_ylabel("kB")
    _finish(axes, result, place="upper left")


def _bandwidth(axes: Any, result: PathResult) -> None:
    for name, driven in result.drives.items():
        times, series = _times(driven.series), driven.series
        axes.plot(times, series.rates(times) / 1e3, color=COLOURS[name], label=name)
        label = f"mean {series.mean / 1e3:,.1f} kB/s"
        axes.axhline(series.mean / 1e3, color=COLOURS[name], linestyle=":", label=label)
    axes.set_title(f"bandwidth after the start, in windows of {WINDOW:g} s")
    axes.set_ylabel("kB/s")
    axes.set_ylim(top=1.22 * axes.get_ylim()[1])
    _finish(axes, result, place="upper center", columns=max(1, len(result.drives)))


def _comparison(axes: Any, result: PathResult) -> None:
    for rival in result.rivals:
        kind, _, memory = rival.name.partition("-")
        dashes = "-" if memory == "drop" else "--"
        _all_data(
            axes,
            rival.coded,
            color=RIVALS[kind],
            linestyle=dashes,
            label=f"{rival.title}, holds {rival.memory}",
        )
        if rival.files is not None:
            label = f"{rival.title}, holds {rival.memory}, .glb files"
            _all_data(axes, rival.files, color="0.6", linestyle=dashes, label=label)
    for name in ("fine", "auto"):
        if name in result.drives:
            series = result.drives[name].series
            _all_data(
                axes, series, color=COLOURS[name], linestyle="-", label=f"packets, {name}, holds needed"
            )
            kept = result.keeping[name].series
            label = f"packets, {name}, holds all"
            _all_data(axes, kept, color=COLOURS[name], linestyle="--", label=label)
    axes.set_title("data received, the start included, beside other ways of streaming (same codec but for .glb)")
    axes.set_ylabel("kB")
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    # The lower part is for the legend.
    axes.set_ylim(low * (low / high) ** 0.4, high)
    _finish(axes, result, place="lower right", columns=2, size=7)


def _all_data(axes: Any, series: Series, **style: Any) -> None:
    times = _times(series)
    axes.plot(times, series.received(times) / 1e3, linewidth=1.3, **style)


def _finish(axes: Any, result: PathResult, place: str, columns: int = 1, size: int = 8) -> None:
    axes.set_xlabel("time, s")
    axes.set_xlim(0.0, next(iter(result.drives.values())).series.duration)
    if axes.get_yscale() == "linear":
        axes.set_ylim(bottom=0.0)
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.legend(loc=place, ncols=columns, fontsize=size, framealpha=0.85)


def _map(axes: Any, tileset: NavTileset, result: PathResult) -> None:
    from matplotlib.collections import PolyCollection  # noqa: PLC0415 - an extra

    points = result.route.points
    low, high = points[:, :2].min(axis=0) - MARGIN, points[:, :2].max(axis=0) + MARGIN
    faces, greys = _plan_of_faces(tileset, low, high)
    axes.add_collection(PolyCollection(list(faces), facecolors=greys, edgecolors="none", rasterized=True))
    outlines = [one for one in (footprint(tileset, cell) for cell in _passed(result)) if len(one)]
    axes.add_collection(
        PolyCollection(
            outlines, facecolors=(0.2, 0.45, 0.8, 0.10), edgecolors=(0.1, 0.3, 0.7, 0.6), linewidths=0.5
        )
    )
    axes.plot(points[:, 0], points[:, 1], color="tab:red", linewidth=1.6)
    series = next(iter(result.drives.values())).series
    _ticks(axes, result, series.duration)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.set_title(f"the route from above, and the {len(outlines):,} cells that it passes")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")


def _ticks(axes: Any, result: PathResult, duration: float) -> None:
    """Mark round times along the route."""
    steps = np.array((0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 1e4, 1e5, 1e6))
    step = steps[np.searchsorted(steps, min(duration / 10, steps[-1]))]
    times = np.arange(0.0, duration, step)
    marks = result.route.at(times * (result.route.length / duration))
    axes.plot(marks[:, 0], marks[:, 1], "o", color="tab:red", markersize=4, markeredgecolor="white")
    for moment, mark in zip(times, marks, strict=True):
        box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.6}
        axes.annotate(f"{moment:g} s", mark[:2], (4, 4), textcoords="offset points", fontsize=7, bbox=box)


def _passed(result: PathResult) -> list[int]:
    return sorted({passage.cell for passage in result.route.passages})


def _plan_of_faces(
    tileset: NavTileset, low: NDArray[np.float64], high: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Triangles (K, 3, 2) that are not upright, the highest last, and greys (K, 3), darker where higher."""
    corners = tileset.finest.corners * np.float64(tileset.step)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.abs(normals[:, 2])
    plan = corners[:, :, :2]
    near = np.all((plan.max(axis=1) >= low) & (plan.min(axis=1) <= high), axis=1)
    shown = np.flatnonzero(near & (areas > 0.05 * np.linalg.norm(normals, axis=1)))
    shown = shown[np.argsort(-areas[shown], kind="stable")[:FACES_DRAWN]]
    heights = corners[shown, :, 2].max(axis=1) if len(shown) else np.zeros(0)
    order = np.argsort(heights, kind="stable")
    bottom, top = (heights.min(), np.percentile(heights, 98)) if len(shown) else (0.0, 1.0)
    share = np.clip((heights[order] - bottom) / max(top - bottom, 1.0), 0.0, 1.0)
    return plan[shown[order]], np.repeat((0.95 - 0.45 * share)[:, None], 3, axis=1)


def footprint(tileset: NavTileset, cell: int) -> NDArray[np.float64]:
    """(K, 2) corners around a cell as seen from above; none where its planes bound nothing."""
    planes = places_of(tileset).planes[cell]
    corners = []
    for chosen in combinations(range(6), 3):
        rows = planes[list(chosen)]
        # Three unit normals of a smaller determinant have no well-defined common point.
        if abs(np.linalg.det(rows[:, :3])) > 1e-9:
            point = np.linalg.solve(rows[:, :3], -rows[:, 3])
            # Rounding of the solution, far below a dot of the picture.
            if np.all(planes[:, :3] @ point + planes[:, 3] <= 1e-6):
                corners.append(point[:2])
    try:
        return np.asarray(np.array(corners)[ConvexHull(np.array(corners)).vertices])
    except (QhullError, ValueError, IndexError):
        return np.zeros((0, 2))
