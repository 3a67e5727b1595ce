"""The one error that the simulated scanner raises."""

from __future__ import annotations


class ScanError(ValueError):
    """A scan that cannot be simulated or written.

    Parameters
    ----------
    source : str
        File, or setting, that is at fault.
    found : str
        What is there.
    allowed : str
        What may be there, and what the user can do.
    """

    def __init__(self, source: str, found: str, allowed: str) -> None:
        self.source = source
        self.found = found
        self.allowed = allowed
        super().__init__(f"{source}: found {found}; allowed: {allowed}")


def require(holds: bool, name: str, found: object, allowed: str) -> None:
    """Raise for a setting that is not as allowed."""
    if not holds:
        raise ScanError(name, repr(found), allowed)
