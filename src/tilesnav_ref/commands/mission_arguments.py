"""Options that say which space is divided: missions, altitudes and sectors."""

from __future__ import annotations

from typing import Any

from tilesnav_ref.cells import CellSettings
from tilesnav_ref.commands.values import line, number, sector


def add_mission_options(group: Any) -> None:
    """Add the options to the parser or group."""
    cells = CellSettings()
    group.add_argument(
        "--mission",
        choices=("aerial", "ground", "corridor"),
        help="a band of altitude, what ground vehicles reach, or a tube along a line (aerial)",
    )
    group.add_argument(
        "--altitude-above",
        choices=("ground", "lowest"),
        help="altitudes count from the ground below, or from the lowest point of the scene (ground)",
    )
    lengths = (
        (
            "--altitude-min",
            "altitude_min",
            f"lower end of the cells above the ground ({cells.altitude_min:g})",
        ),
        ("--altitude-max", "altitude_max", "upper end of the cells above the ground (152.4 or less)"),
        (
            "--ground-height",
            "ground_height",
            f"height of the cells of ground vehicles ({cells.ground_height:g})",
        ),
        ("--ground-step", "ground_step", f"highest step that they climb ({cells.ground_step:g})"),
        ("--corridor-radius", "corridor_radius", f"radius of the tube ({cells.corridor_radius:g})"),
        ("--sector-size", "sector_size", "edge of the sectors whose borders no cell crosses (no sectors)"),
    )
    for option, name, help_text in lengths:
        group.add_argument(option, dest=name, type=number, metavar="M", help=f"{help_text}, m")
    group.add_argument(
        "--ground-slope",
        type=number,
        metavar="S",
        help=f"steepest ground that carries them, rise over run ({cells.ground_slope:g})",
    )
    group.add_argument(
        "--corridor",
        type=line,
        metavar="X,Y,Z;...",
        help="points of the line of the tube, m, or a .json or .csv file of them",
    )
    group.add_argument(
        "--sector",
        type=sector,
        metavar="I,J",
        help="this sector alone; 0,0 begins at the zero of the nav frame",
    )
