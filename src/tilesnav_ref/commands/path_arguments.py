"""Options of `tilesnav path`, and the settings that they stand for."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from tilesnav_ref.commands.values import integer, line, number
from tilesnav_ref.stream.baseline import ScreenSettings
from tilesnav_ref.stream.comparison import ComparisonSettings
from tilesnav_ref.stream.drive import UNLIMITED, DriveSettings
from tilesnav_ref.stream.path import PathSettings
from tilesnav_ref.stream.policy import NAMES
from tilesnav_ref.stream.stock import STOCK


def add_path_options(parser: argparse.ArgumentParser) -> None:
    """Add the options to the parser."""
    path, screen, comparison = PathSettings(), ScreenSettings(), ComparisonSettings()
    parser.add_argument(
        "tileset", type=Path, metavar="OUT", help="folder with tileset.json, or the file itself"
    )
    parser.add_argument(
        "--route",
        type=route,
        default=path.route,
        metavar="ROUTE",
        help="'X,Y,Z X,Y,Z ...' (m, nav frame), a .json or .csv file of them, 'roof' or 'ground' (roof)",
    )
    parser.add_argument(
        "--speed", type=number, default=path.speed, metavar="M/S", help=f"m/s ({path.speed:g})"
    )
    parser.add_argument(
        "--lod", action="append", choices=NAMES, help="level of detail; may be repeated (all of them)"
    )
    parser.add_argument(
        "--retain",
        type=integer(0, UNLIMITED),
        default=path.retain,
        metavar="N",
        help=f"faces held beyond what the cell calls for ({path.retain})",
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures and series")
    parser.add_argument(
        "--plot", type=Path, metavar="FILE", help="picture to write, .png, .svg or .pdf (extra 'plot')"
    )
    parser.add_argument(
        "--packets",
        type=Path,
        metavar="FILE",
        help="write the packets, one behind the other (.vep); needs one --lod",
    )
    parser.add_argument("--quiet", action="store_true", help="no progress and no tables")
    group = parser.add_argument_group("what it is compared with")
    group.add_argument(
        "--screen-error",
        type=number,
        default=screen.maximum_error,
        metavar="PX",
        help=f"error that a viewer allows, pixels of {screen.screen_height} lines over"
        f" {screen.field_of_view:g} degrees ({screen.maximum_error:g})",
    )
    group.add_argument(
        "--sensor-range",
        type=number,
        default=comparison.sensor_range,
        metavar="M",
        help=f"range within which everything is sent, m ({comparison.sensor_range:g})",
    )


def path_settings(given: argparse.Namespace) -> PathSettings:
    """Make the settings; ValueError where one is out of range or they do not go together."""
    policies = tuple(dict.fromkeys(given.lod or NAMES))
    if given.packets is not None and len(policies) != 1:
        raise ValueError(f"--packets: found {len(policies)} levels of detail; allowed: one --lod")
    DriveSettings(speed=given.speed, retain=given.retain)
    comparison = ComparisonSettings(ScreenSettings(given.screen_error), given.sensor_range)
    return PathSettings(given.route, policies, given.speed, given.retain, comparison)


def route(text: str) -> str | tuple[tuple[float, ...], ...]:
    """Name of a stock route, or its way points."""
    if text in STOCK:
        return text
    if "," not in text and Path(text).suffix.lower() not in (".json", ".csv"):
        allowed = f"{', '.join(STOCK)}, a .json or .csv file, or points X,Y,Z with spaces between them"
        raise argparse.ArgumentTypeError(f"found {text!r}; allowed: {allowed}")
    return line(text if Path(text).suffix.lower() in (".json", ".csv") else ";".join(text.split()) + ";")


def joined_route(arguments: Sequence[str]) -> list[str]:
    """Join way points that were given one by one, which argparse would not take for one value.

    Examples
    --------
    >>> joined_route(["path", "OUT", "--route", "-1,2,3", "4,5,6", "--speed", "20"])
    ['path', 'OUT', '--route=-1,2,3 4,5,6', '--speed', '20']
    """
    if "--route" not in arguments:
        return list(arguments)
    first = list(arguments).index("--route") + 1
    last = first + 1
    while last < len(arguments) and arguments[last].count(",") == 2 and not arguments[last].startswith("--"):
        last += 1
    points = " ".join(arguments[first:last])
    option = [f"--route={points}"] if points else ["--route"]
    return [*arguments[: first - 1], *option, *arguments[last:]]
