"""Snapping to the grid, welding of equal vertices, and removal of faces without area."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.model import COORDINATE_LIMIT

SNAP_LIMIT = float(1 << 52)
"""Beyond it float64 has no fractions, so rounding to the grid would say nothing."""


def snap(positions: NDArray[np.float64], exponent: int, source: str) -> NDArray[np.int64]:
    """Round positions to the grid, halves to even.

    Parameters
    ----------
    positions : (V, 3) float64
        Metres, nav frame.
    exponent : int
        The grid step is 2**exponent metres.
    source : str
        File named in errors.

    Returns
    -------
    (V, 3) int64
        Grid coordinates.

    Raises
    ------
    SceneError
        When a coordinate exceeds 2**52 steps.

    Notes
    -----
    The step is a power of two, so the division is exact and the result is the nearest grid point.
    """
    with np.errstate(over="ignore"):  # infinity is refused below
        scaled = np.ldexp(positions, -exponent)
    far = np.flatnonzero(~(np.abs(scaled) <= SNAP_LIMIT).all(axis=1))
    if len(far):
        where = np.array2string(positions[far[0]], separator=", ")
        raise SceneError(
            source, f"vertex {far[0]}", f"{where} m", "at most 2^52 grid steps; see --units, --origin"
        )
    return np.rint(scaled).astype(np.int64)


def weld(
    vertices: NDArray[np.int64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Give equal vertices one number and drop those that no face uses.

    Parameters
    ----------
    vertices : (V, 3) int64
        Grid coordinates.
    faces : (F, 3) int64
        Indices into vertices, within range.

    Returns
    -------
    vertices : (W, 3) int64
        Different grid coordinates, in lexicographic order, each used by a face.
    faces : (F, 3) int64
        The same faces with the new numbers.
    """
    if not len(faces):
        return np.zeros((0, 3), np.int64), np.zeros((0, 3), np.int64)
    used = np.zeros(len(vertices), bool)
    used[faces.ravel()] = True
    kept = np.flatnonzero(used)
    order = kept[np.lexsort(vertices[kept].T[::-1])]
    ordered = vertices[order]
    first = np.ones(len(order), bool)
    first[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    number = np.zeros(len(vertices), np.int64)
    number[order] = np.cumsum(first) - 1
    return ordered[first], number[faces]


def check_limit(vertices: NDArray[np.int64], exponent: int, source: str) -> None:
    """Refuse coordinates of 2**23 steps or more.

    Raises
    ------
    SceneError
        Naming the first such vertex and what the user can do.
    """
    bad = np.flatnonzero((np.abs(vertices) >= COORDINATE_LIMIT).any(axis=1))
    if not len(bad):
        return
    step = 2.0**exponent
    where = ", ".join(f"{v * step:.3f}" for v in vertices[bad[0]])
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle = ",".join(
        f"{round((a + b) / 2 * step)}" for a, b in zip(low.tolist(), high.tolist(), strict=True)
    )
    raise SceneError(
        source,
        f"vertex at ({where}) m",
        f"{len(bad)} of {len(vertices)} vertices at 2^23 grid steps or more from the origin",
        f"below {COORDINATE_LIMIT * step:g} m from it: move it with --origin (to the middle: {middle} m), "
        "crop with --region, check --units, or take a coarser --grid",
    )


def has_area(corners: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether triangles have area, exactly.

    Parameters
    ----------
    corners : (F, 3, 3) int64
        Grid coordinates of magnitude below 2**23, so that products of differences fit 48 bits.

    Returns
    -------
    (F,) bool
    """
    first = corners[:, 1] - corners[:, 0]
    second = corners[:, 2] - corners[:, 0]
    return np.asarray((np.cross(first, second) != 0).any(axis=1))
