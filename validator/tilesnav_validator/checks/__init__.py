"""Every requirement that code checks has one function here, registered under its id."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

from tilesnav_validator.findings import Check


@dataclass(frozen=True)
class Registered:
    """A check and the requirements that must have passed before it says anything useful."""

    run: Check
    needs: tuple[str, ...]


_CHECKS: dict[str, Registered] = {}
_MODULES = (
    "links",
    "contents",
    "container",
    "cells",
    "portals",
    "states",
    "levels",
    "deltas",
    "conservative",
    "certificates",
    "coarse",
    "packets",
)


def check(requirement: str, needs: tuple[str, ...] = ()) -> Callable[[Check], Check]:
    """Register a function as the check of a requirement.

    Parameters
    ----------
    requirement : str
        Id in the registry.
    needs : tuple of str
        Ids that must have passed; else the check is not run.
    """

    def register(function: Check) -> Check:
        if requirement in _CHECKS:
            raise ValueError(f"two checks of {requirement}")
        _CHECKS[requirement] = Registered(function, needs)
        return function

    return register


def registered() -> dict[str, Registered]:
    """All checks by the id of their requirement."""
    for module in _MODULES:
        import_module(f"{__name__}.{module}")
    return _CHECKS


def registered_ids() -> frozenset[str]:
    """Ids of all requirements that code checks."""
    return frozenset(registered())
