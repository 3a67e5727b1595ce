"""Arguments of the coarse levels of the meshes."""

from __future__ import annotations

from typing import Any

from tilesnav_ref.commands.values import integer, numbers
from tilesnav_ref.levels import LEVELS_MAX, LevelSettings


def add_coarse_options(group: Any) -> None:
    """Add the options to a group of a parser."""
    levels = LevelSettings()
    group.add_argument(
        "--levels",
        type=integer(1, LEVELS_MAX),
        metavar="N",
        help=f"levels of the meshes: finest, median, coarse ({levels.levels})",
    )
    group.add_argument(
        "--level-errors",
        type=numbers(None),
        metavar="M,M",
        help="greatest distance of median and coarse level from the finest one, m"
        f" ({','.join(f'{error:g}' for error in levels.level_errors)})",
    )
