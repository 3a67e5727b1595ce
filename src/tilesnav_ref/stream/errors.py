"""What can be wrong with a tileset that is read, or with a delta that is applied."""

from __future__ import annotations


class TilesetError(ValueError):
    """A tileset that cannot be read.

    Parameters
    ----------
    source : str
        The file.
    place : str
        Where in it.
    found : str
        What is there.
    allowed : str
        What may be there.
    """

    def __init__(self, source: str, place: str, found: str, allowed: str) -> None:
        self.source = source
        self.place = place
        super().__init__(f"{source}: {place}: found {found}; allowed: {allowed}")


class DeltaError(ValueError):
    """A delta that does not fit the state that it is applied to."""


class RouteError(ValueError):
    """A route that leads nowhere: a way point outside of all cells, or two that no way joins."""
