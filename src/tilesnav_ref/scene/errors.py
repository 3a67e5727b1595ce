"""The one error that scene input raises."""

from __future__ import annotations


class SceneError(ValueError):
    """Input that cannot become a scene.

    Parameters
    ----------
    source : str
        File, or setting, that is at fault.
    place : str
        Where in it: header, first bad vertex or face.
    found : str
        What is there.
    allowed : str
        What may be there, and what the user can do.
    """

    def __init__(self, source: str, place: str, found: str, allowed: str) -> None:
        self.source = source
        self.place = place
        self.found = found
        self.allowed = allowed
        super().__init__(f"{source}: {place}: found {found}; allowed: {allowed}")
