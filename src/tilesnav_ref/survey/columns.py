"""What a survey from the air leaves unknown: everything below the highest return of a column.

Notes
-----
Pulses come from above and end where something is in their way, so the space above all returns of a column is
known to be free. Below them nothing is: a pulse may have gone past a wall, under eaves or through leaves, but
a cloud does not tell which. A column without a return is unknown up to the sky.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.model import COORDINATE_LIMIT
from tilesnav_ref.scene.unknown import UnknownSpace

COLUMNS_LIMIT = 1 << 25
"""Most blocks of unknown space; their edge is doubled to stay below. 32 MiB."""


def unknown_below(
    returns: NDArray[np.int64], bounds: NDArray[np.int64], size: int, rise: int
) -> UnknownSpace:
    """Unknown space under the returns of a survey from the air.

    Parameters
    ----------
    returns : (N, 3) int64
        All returns, of whatever class, on the grid of the scene.
    bounds : (2, 3) int64
        Box of the scene; columns cover it.
    size : int
        Edge of a column, grid steps; doubled where there would be too many blocks.
    rise : int
        Heights are rounded up to multiples of it, grid steps.

    Returns
    -------
    UnknownSpace
        Open above.
    """
    low = np.minimum(returns.min(axis=0), bounds[0])
    extent = np.maximum(returns.max(axis=0), bounds[1]) - low + 1
    layers = -(-extent[2] // rise) + 2
    while np.prod(-(-extent[:2] // size), dtype=np.float64) * layers > COLUMNS_LIMIT:
        size *= 2
    shape = -(-extent[:2] // size)
    column = (returns[:, :2] - low[:2]) // size
    # the layer of the highest return is unknown as a whole, and what is above it is known
    layer = (returns[:, 2] - low[2]) // rise + 1
    tops = np.full(tuple(shape), layers, np.int64)
    seen = np.zeros(tuple(shape), np.int64)
    np.maximum.at(seen, (column[:, 0], column[:, 1]), layer)
    tops[seen > 0] = seen[seen > 0]
    unknown = np.arange(layers)[None, None, :] < tops[:, :, None]
    heights = low[2] + np.arange(layers + 1) * rise
    heights[-1] = COORDINATE_LIMIT - 1
    cuts = (low[0] + np.arange(shape[0] + 1) * size, low[1] + np.arange(shape[1] + 1) * size, heights)
    return UnknownSpace(cuts, unknown, open_above=True)
