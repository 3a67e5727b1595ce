"""Pictures of planar features: points coloured by feature, and how their normals deviate.

Notes
-----
matplotlib is an extra and imported where it is used.
"""

from __future__ import annotations

import colorsys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.planar.deviations import Deviations, normal_deviations
from tilesnav_ref.planar.model import PlanarFeatures
from tilesnav_ref.planar.raster import Image, rasterise

SUFFIXES = (".png", ".svg", ".pdf")
DOTS = 150
"""Dots an inch."""
GREY = (0.72, 0.72, 0.72)
"""Points of no feature."""
GOLDEN = 0.6180339887
"""Steps of the hue: neighbours in the order of sizes get colours far apart."""
VIEW = (-55.0, 32.0)
"""Degrees: direction in plan and elevation that the perspective is seen from."""
LIGHT = np.array((-0.35, -0.45, 0.82))
"""From where the perspective is lit."""
STEEP = 0.2
"""Largest vertical component of the normal of a wall."""
FACADE_DEPTH = (6.0, 3.0)
"""Metres in front of and behind a wall that its elevation shows."""
FACADE_SHAPE = 1.7
"""Least width of that elevation in heights of the wall."""
PARALLEL = 0.98
"""Cosine of the greatest angle to the wall at which the rectangle of a feature is outlined."""
SHOWN_SIGMAS = 6.0
"""Standard deviations to both sides that histograms show."""


class PictureError(ValueError):
    """A picture that cannot be drawn or written."""


def check_picture(path: Path) -> None:
    """Refuse what cannot be drawn or written, before any work is done.

    Raises
    ------
    PictureError
        Another ending, a folder that is not there, or matplotlib is missing.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise PictureError(f"{path}: found the ending {path.suffix!r}; allowed: {', '.join(SUFFIXES)}")
    if not path.parent.is_dir():
        raise PictureError(f"{path}: its parent {path.parent} is not a folder")
    _matplotlib()


def _matplotlib() -> Any:
    try:
        import matplotlib  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise PictureError(
            "pictures need matplotlib; install the extra: pip install 'tilesnav[plot]'"
        ) from error
    return matplotlib


def draw_features(points: NDArray[np.float64], features: PlanarFeatures, path: Path) -> None:
    """Draw points coloured by feature: in perspective, from above, and the elevation of a wall.

    Parameters
    ----------
    points : (N, 3) float64
        Metres, z up; one or more, those that the features were found in.
    features : PlanarFeatures
    path : Path
        .png, .svg or .pdf; replaced when it exists.

    Raises
    ------
    PictureError
        See :func:`check_picture`; or there are no points.
    """
    check_picture(path)
    if not len(points):
        raise PictureError(f"{path}: found no points to draw; allowed: one or more")
    colours = feature_colours(features)

    def fill(figure: Any) -> None:
        grid = figure.add_gridspec(2, 2, width_ratios=(1.55, 1.0), height_ratios=(1.35, 1.0))
        _perspective(figure.add_subplot(grid[:, 0]), points, features, colours)
        _plan(figure.add_subplot(grid[0, 1]), points, colours)
        wall = fullest_wall(features)
        if wall is not None:
            _facade(figure.add_subplot(grid[1, 1]), points, features, colours, wall)
        share = float((features.labels >= 0).mean())
        figure.suptitle(
            f"{len(features):,} planar features hold {share:.1%} of {len(points):,} points; the rest is grey"
        )

    _save(path, (15.0, 8.0), fill)


def draw_normal_deviations(points: NDArray[np.float64], features: PlanarFeatures, path: Path) -> None:
    """Draw how local normals deviate from those of their features, in the two directions within the plane.

    Parameters
    ----------
    points : (N, 3) float64
        Metres, z up; those that the features were found in.
    features : PlanarFeatures
    path : Path
        .png, .svg or .pdf; replaced when it exists.

    Raises
    ------
    PictureError
        See :func:`check_picture`; or no feature has points enough for a local normal.
    """
    check_picture(path)
    found = normal_deviations(points, features)
    if not len(found.across):
        raise PictureError(f"{path}: found no feature with enough points for a local normal; allowed: one")

    def fill(figure: Any) -> None:
        grid = figure.add_gridspec(1, 3, width_ratios=(1.15, 1.0, 1.0))
        _density(figure, figure.add_subplot(grid[0]), found)
        names = ("across, level in the plane", "upwards in the plane")
        for k, (values, name) in enumerate(zip((found.across, found.upwards), names, strict=True)):
            _histogram(figure.add_subplot(grid[k + 1]), values, found.spread[k], name)
        figure.suptitle(
            f"Local normals of {len(found.across):,} points of {found.features:,} planar features,"
            " against the normal of the feature"
        )

    _save(path, (15.0, 4.8), fill)


def _save(path: Path, size: tuple[float, float], fill: Callable[[Any], None]) -> None:
    matplotlib = _matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - an extra
    from matplotlib.figure import Figure  # noqa: PLC0415 - an extra

    with matplotlib.rc_context({"svg.hashsalt": "tilesnav", "font.size": 9}):
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        fill(figure)
        metadata = {"Date": None} if path.suffix.lower() == ".svg" else None
        figure.savefig(path, dpi=DOTS, metadata=metadata)


def feature_colours(features: PlanarFeatures) -> NDArray[np.float64]:
    """(N, 3) colour of the feature of each point, grey where it has none."""
    table = np.empty((len(features) + 1, 3))
    for k in range(len(features)):
        # Three brightnesses, so that hues that come near again after some features still differ.
        table[k] = colorsys.hsv_to_rgb((k * GOLDEN) % 1.0, 0.55 + 0.15 * (k % 3), 0.92 - 0.12 * (k % 4 % 3))
    table[-1] = GREY
    return np.asarray(table[features.labels])


def fullest_wall(features: PlanarFeatures) -> int | None:
    """Feature that stands and has the most points; None when none stands.

    By area a plane through the tops of trees would win in an airborne cloud.
    """
    walls = np.flatnonzero(np.abs(features.normals[:, 2]) < STEEP)
    if not len(walls):
        return None
    return int(walls[np.argmax(features.counts[walls])])


def _perspective(
    axes: Any, points: NDArray[np.float64], features: PlanarFeatures, colours: NDArray[np.float64]
) -> None:
    azimuth, elevation = np.radians(VIEW)
    right = np.array((-np.sin(azimuth), np.cos(azimuth), 0.0))
    to_eye = np.array(
        (np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation))
    )
    centred = points - points.mean(axis=0)
    flat = centred @ np.stack((right, np.cross(to_eye, right)), axis=1)
    shades = np.append(0.6 + 0.4 * np.abs(features.normals @ LIGHT), 0.95)  # the last is for no feature
    lit = colours * shades[features.labels][:, None]
    _show(axes, rasterise(flat, -(centred @ to_eye), lit, 1100))
    axes.set_axis_off()
    _scale_bar(axes, flat)


def _scale_bar(axes: Any, flat: NDArray[np.float64]) -> None:
    """A round length below the picture; level lengths along the image are true in a parallel projection."""
    low, size = flat.min(axis=0), float(np.ptp(flat[:, 0]))
    length = 10.0 ** np.floor(np.log10(max(size, 1e-3) / 4.0))
    length *= max(factor for factor in (1.0, 2.0, 5.0) if factor * length <= size / 4.0)
    y = low[1] - 0.03 * size
    axes.plot((low[0], low[0] + length), (y, y), color="black", linewidth=2.0)
    axes.annotate(f"{length:g} m", (low[0] + length / 2.0, y), ha="center", va="bottom")
    axes.set_ylim(y - 0.02 * size, None)


def _plan(axes: Any, points: NDArray[np.float64], colours: NDArray[np.float64]) -> None:
    _show(axes, rasterise(points[:, :2], -points[:, 2], colours, 800))
    axes.set_title("from above")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")


def _facade(
    axes: Any,
    points: NDArray[np.float64],
    features: PlanarFeatures,
    colours: NDArray[np.float64],
    wall: int,
) -> None:
    """Elevation of the surroundings of a wall, seen from the side that has fewer points behind it."""
    from matplotlib.collections import PolyCollection  # noqa: PLC0415 - an extra

    normal = features.normals[wall] * (1.0, 1.0, 0.0)
    normal /= np.linalg.norm(normal)
    centre = features.extents.centres[wall]
    away = (points - centre) @ normal
    front, behind = FACADE_DEPTH
    near = np.abs(away) < front
    # A wall is scanned from outside: there are more points, of the ground, in front of it.
    if (away[near] > 0).sum() < (away[near] < 0).sum():
        normal, away = -normal, -away
    right = np.array((-normal[1], normal[0], 0.0))
    along = (points - centre) @ right
    corners = features.extents.corners()[wall] - centre
    half = max(1.15 * float(np.abs(corners @ right).max()), FACADE_SHAPE * float(np.abs(corners[:, 2]).max()))
    seen = (away < front) & (away > -behind) & (np.abs(along) < half)
    flat = np.stack((along[seen], points[seen, 2]), axis=1)
    _show(axes, rasterise(flat, -away[seen], colours[seen], 800))
    parallel = np.abs(features.normals @ normal) > PARALLEL
    middle = features.extents.centres - centre
    parallel &= (np.abs(middle @ right) < half) & (middle @ normal < front) & (middle @ normal > -behind)
    corners = features.extents.corners()[parallel]
    outlines = np.stack(((corners - centre) @ right, corners[:, :, 2]), axis=2)
    axes.add_collection(
        PolyCollection(list(outlines), facecolors="none", edgecolors=(0.1, 0.1, 0.1), linewidths=0.8)
    )
    axes.set_title("around the wall with most points; rectangles of what is parallel")
    axes.set_xlabel("along the wall, m")
    axes.set_ylabel("z, m")


def _show(axes: Any, image: Image) -> None:
    axes.imshow(image.pixels, extent=image.extent, interpolation="nearest", aspect="equal")


def _density(figure: Any, axes: Any, found: Deviations) -> None:
    """Both directions at once, with ellipses of one and of four standard deviations."""
    from matplotlib.colors import LogNorm  # noqa: PLC0415 - an extra
    from matplotlib.patches import Ellipse  # noqa: PLC0415 - an extra

    reach = _reach(max(found.spread))
    counts, edges, _ = np.histogram2d(found.across, found.upwards, bins=90, range=((-reach, reach),) * 2)
    shown = axes.pcolormesh(
        edges, edges, np.where(counts > 0, counts, np.nan).T, norm=LogNorm(), cmap="viridis", rasterized=True
    )
    for sigmas, style in ((1.0, "-"), (4.0, "--")):
        wide, high = (2.0 * sigmas * spread for spread in found.spread)
        label = f"{sigmas:g} standard deviation{'s' if sigmas > 1 else ''}"
        axes.add_patch(Ellipse((0, 0), wide, high, fill=False, color="crimson", linestyle=style, label=label))
    axes.set_aspect("equal")
    axes.set_xlabel("across, level in the plane")
    axes.set_ylabel("upwards in the plane")
    axes.legend(loc="upper right", fontsize=8)
    figure.colorbar(shown, ax=axes, label="points")


def _histogram(axes: Any, values: NDArray[np.float64], spread: float, name: str) -> None:
    reach = _reach(spread)
    axes.hist(values, bins=100, range=(-reach, reach), density=True, color="steelblue", label="measured")
    at = np.linspace(-reach, reach, 300)
    middle = float(np.median(values))
    width = max(spread, 1e-12)
    curve = np.exp(-0.5 * ((at - middle) / width) ** 2) / (width * np.sqrt(2.0 * np.pi))
    degrees = np.degrees(np.arcsin(min(spread, 1.0)))
    label = f"normal distribution, standard\ndeviation {spread:.4f} ({degrees:.2f} degrees)"
    axes.plot(at, curve, color="crimson", label=label)
    beyond = float((np.abs(values - middle) > 4.0 * spread).mean())
    for side in (-4.0, 4.0):
        axes.axvline(middle + side * spread, color="black", linestyle="--", linewidth=1.0)
    axes.plot([], [], color="black", linestyle="--", label=f"4 standard deviations, {beyond:.1%} beyond")
    axes.set_title(name)
    axes.set_xlabel("component of the local normal")
    axes.set_ylabel("density")
    axes.margins(y=0.28)
    axes.legend(loc="upper right", fontsize=8)


def _reach(spread: float) -> float:
    return max(SHOWN_SIGMAS * spread, 1e-6)
