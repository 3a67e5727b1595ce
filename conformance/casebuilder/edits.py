"""Small changes that the modules of invalid cases are composed of."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from casebuilder.state import Tables

Edit = Callable[[Any], object]
Edits = dict[str, Any]
"""Members of Case that make it differ from the ring."""


def edits(**members: Any) -> Edits:
    """Changes of one case."""
    return members


def setting(*path: str | int, value: object) -> Edit:
    """Edit that sets a member of a JSON value."""

    def edit(target: Any) -> None:
        for key in path[:-1]:
            target = target[key]
        target[path[-1]] = value

    return edit


def adding(*path: str | int, amount: float) -> Edit:
    """Edit that adds to a number of a JSON value."""

    def edit(target: Any) -> None:
        for key in path[:-1]:
            target = target[key]
        target[path[-1]] += amount

    return edit


def dropping(*path: str | int) -> Edit:
    """Edit that removes a member of a JSON value."""

    def edit(target: Any) -> None:
        for key in path[:-1]:
            target = target[key]
        del target[path[-1]]

    return edit


def of_first(change: Edit) -> Callable[[Any, object], object]:
    """Edit that is given a JSON value and bytes, and changes the JSON value."""
    return lambda value, _: change(value)


def in_table(name: str, index: Any, value: Any) -> Callable[[list[Tables]], None]:
    """Edit that sets an element of a table of the first sector."""

    def edit(sectors: list[Tables]) -> None:
        sectors[0][name] = sectors[0][name].copy()
        sectors[0][name][index] = value

    return edit


def whole_table(name: str, change: Callable[[Any], Any]) -> Callable[[list[Tables]], None]:
    """Edit that exchanges a table of the first sector."""

    def edit(sectors: list[Tables]) -> None:
        sectors[0][name] = change(sectors[0][name])

    return edit
