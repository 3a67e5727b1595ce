"""Square sectors on a fixed lattice of the nav frame, whose borders no cell crosses.

Notes
-----
Sector (i, j) is the plan from (i, j) to (i + 1, j + 1) times the sector size. Roots are cut at the borders,
cells are merged within a sector only, and a cell is kept when it is connected to the open sky (or to a seed)
within the three by three sectors around its own. So the cells of a sector depend on these nine sectors and
on nothing beyond them, and a sector that is made alone has the cells that it has among all.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tilesnav_ref.cells.settings import CellError


def lattice_cuts(low: int, high: int, size: int) -> NDArray[np.int64]:
    """Both ends of an interval and the multiples of size between them, ascending."""
    inner = np.arange((low // size + 1) * size, high, size, dtype=np.int64)
    return np.concatenate(([low], inner, [high])).astype(np.int64)


def sector_places(lower: NDArray[np.int64], size: int) -> NDArray[np.int64]:
    """Sector (N, 2) of cells by their least coordinates (N, 3); all (0, 0) where size is 0."""
    return np.zeros((len(lower), 2), np.int64) if size == 0 else lower[:, :2] // size


def roots_around(
    roots: NDArray[np.int64], size: int, sector: tuple[int, int] | None, step: float
) -> NDArray[np.int64]:
    """The roots (R, 2, 3) at most two sectors from a sector; all of them where sector is None. The outer of
    them are what those next to the sector see of the sky.

    Raises
    ------
    CellError
        No root is in the sector; ``step`` is the grid step, m, for the message.
    """
    if sector is None:
        return roots
    places = sector_places(roots[:, 0], size)
    if not np.any(np.all(places == sector, axis=1)):
        low, high = places.min(axis=0).tolist(), places.max(axis=0).tolist()
        raise CellError(
            f"sector {sector[0]},{sector[1]} of {size * step:g} m holds no part of the domain; "
            f"allowed: {low[0]} to {high[0]} and {low[1]} to {high[1]}"
        )
    return roots[np.all(np.abs(places - sector) <= 2, axis=1)]


def only_sector(places: NDArray[np.int64], sector: tuple[int, int] | None) -> NDArray[np.bool_]:
    """Which cells, by their sectors (N, 2), are in the one that was asked for; (N,) bool, all without one."""
    return np.ones(len(places), np.bool_) if sector is None else np.all(places == sector, axis=1)


def sector_by_sector(
    roots: NDArray[np.int64],
    size: int,
    sector: tuple[int, int] | None,
    divide: Callable[[NDArray[np.int64], NDArray[np.int64]], NDArray[np.int64]],
) -> NDArray[np.int64]:
    """Divide roots (R, 2, 3) into cells, sector by sector.

    Parameters
    ----------
    roots
        Of all sectors, or those of :func:`roots_around`.
    size
        Edge of a sector, grid steps; 0: no sectors.
    sector
        The one that is asked for; it and the eight around it are divided. None: all.
    divide
        Makes the cells of one sector from its roots and the domain (2, 3) of the roots of it and of the eight
        around it, in which it may look for the sky.
    """
    if size == 0:
        return divide(roots, _hull(roots))
    places, parts = sector_places(roots[:, 0], size), []
    for place in np.unique(places, axis=0):
        if sector is None or np.all(np.abs(place - sector) <= 1):
            near = np.all(np.abs(places - place) <= 1, axis=1)
            own = np.all(places == place, axis=1)
            parts.append(divide(np.ascontiguousarray(roots[own]), _hull(roots[near])))
    return np.concatenate(parts)


def _hull(roots: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.stack((roots[:, 0].min(axis=0), roots[:, 1].max(axis=0)))


def connected_within(
    pairs: NDArray[np.int64], starts: NDArray[np.bool_], places: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Which cells are connected to a start within the three by three sectors around their own.

    Parameters
    ----------
    pairs
        (Q, 2) cells that touch.
    starts
        (N,) cells that are kept by themselves.
    places
        (N, 2) sector of each cell.

    Returns
    -------
    ndarray
        (N,) bool.
    """
    kept = np.zeros(len(starts), np.bool_)
    for place in np.unique(places, axis=0):
        near = np.all(np.abs(places - place) <= 1, axis=1)
        inside = pairs[near[pairs[:, 0]] & near[pairs[:, 1]]]
        links = coo_array(
            (np.ones(len(inside), np.int8), (inside[:, 0], inside[:, 1])), shape=(len(starts), len(starts))
        )
        _, component = connected_components(links, directed=False)
        own = np.all(places == place, axis=1)
        kept[own] = np.isin(component[own], np.unique(component[starts & near]))
    return kept


def sector_order(
    boxes: NDArray[np.int64], size: int, order: Callable[[NDArray[np.int64]], NDArray[np.int64]]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Order of boxes (N, 2, 3) by sectors, and by ``order`` within each, and where sectors begin.

    Returns
    -------
    order, offsets
        (N,) and (S + 1,) int64.
    """
    numbers = _numbers(sector_places(boxes[:, 0], size))
    members = [np.flatnonzero(numbers == number) for number in np.unique(numbers)]
    ordered = [one[order(boxes[one])] for one in members]
    offsets = np.cumsum([0, *(len(one) for one in members)], dtype=np.int64)
    return (np.concatenate(ordered) if ordered else np.zeros(0, np.int64)), offsets


def _numbers(places: NDArray[np.int64]) -> NDArray[np.int64]:
    """0, 1, ... for the sectors (N, 2), column by column."""
    return np.unique(places, axis=0, return_inverse=True)[1].reshape(-1).astype(np.int64)
