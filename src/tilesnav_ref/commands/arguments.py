"""Arguments of the command line, and the settings that they stand for."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from tilesnav_ref import __version__
from tilesnav_ref.cells import CellError, CellSettings
from tilesnav_ref.commands.coarse_arguments import add_coarse_options
from tilesnav_ref.commands.mission_arguments import add_mission_options
from tilesnav_ref.commands.path_arguments import add_path_options, joined_route
from tilesnav_ref.commands.planes import add_planes
from tilesnav_ref.commands.register import add_register
from tilesnav_ref.commands.sample import SIZES
from tilesnav_ref.commands.scan import add_scan
from tilesnav_ref.commands.survey_arguments import add_survey_options, survey_settings
from tilesnav_ref.commands.values import given_of, integer, number, numbers
from tilesnav_ref.encode import EncodeSettings
from tilesnav_ref.levels import LevelSettings
from tilesnav_ref.lod import LodSettings
from tilesnav_ref.scene import METRES_PER_UNIT, SceneError, SceneSettings
from tilesnav_ref.scene.sample import DETAILS, TownSettings
from tilesnav_ref.survey import SurveySettings
from tilesnav_ref.tileset.model import TilesetSettings
from tilesnav_ref.visibility import VisibilitySettings
from tilesnav_ref.visibility.settings import LIMITS

EXIT_STATUS = """exit status:
  0  done
  1  the input was read, but cannot be encoded (no free space, too large, ...)
  2  the input cannot be read, the output cannot be written, or wrong usage
  3  internal error
  130, 143  interrupted, terminated
Except for status 0, nothing is left behind and an older tileset at OUT is as it was.
"""

LISTS = ("--region", "--origin", "--seed-point", "--corridor", "--sector", "--route")
"""Options whose value may begin with a minus sign and is no plain number."""


class UsageError(ValueError):
    """Arguments that make no command."""


class _Parser(argparse.ArgumentParser):
    """A parser that raises instead of printing its usage."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(message)


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Parse the command line.

    Raises
    ------
    UsageError
        When it is wrong.
    """
    return _parser().parse_args(_joined(joined_route(arguments)))


def encode_settings(given: argparse.Namespace) -> EncodeSettings:
    """Make the settings of every stage; what was not given keeps its default.

    Raises
    ------
    UsageError
        When a stage refuses its settings.
    """
    values = _values(given)
    try:
        return EncodeSettings(
            scene=_settings(SceneSettings, values),
            survey=survey_settings(values),
            cells=_settings(CellSettings, values),
            visibility=_settings(VisibilitySettings, values),
            lod=_settings(LodSettings, values),
            coarse=_settings(LevelSettings, values),
            tileset=_settings(TilesetSettings, values),
            update=given.update,
        )
    except (SceneError, CellError, ValueError) as error:
        raise UsageError(str(error)) from error


def cell_settings(given: argparse.Namespace) -> tuple[SceneSettings, CellSettings, SurveySettings]:
    """Make the settings of the scene, of its cells and of surveys; what was not given keeps its default.

    Raises
    ------
    UsageError
        When a stage refuses its settings.
    """
    values = _values(given)
    try:
        cells = _settings(CellSettings, values)
        return _settings(SceneSettings, values), cells, survey_settings(values)
    except (SceneError, CellError) as error:
        raise UsageError(str(error)) from error


def scene_settings(given: argparse.Namespace) -> SceneSettings:
    """Make the settings of the scene; what was not given keeps its default.

    Raises
    ------
    UsageError
        When it refuses them.
    """
    try:
        return SceneSettings(**given_of(SceneSettings, _values(given)))
    except SceneError as error:
        raise UsageError(str(error)) from error


def _values(given: argparse.Namespace) -> dict[str, Any]:
    values = {name: value for name, value in vars(given).items() if value is not None}
    if "seed" in values:
        values["coverage_seed"] = values["seed"]
    for name in ("seeds", "transparent", "one_sided", "terrain"):
        if name in values:
            values[name] = tuple(values[name])
    return values


def town_settings(given: argparse.Namespace) -> TownSettings:
    """Make the settings of the sample town; what was not given keeps the default of the small town."""
    size, town = SIZES[given.size], TownSettings()
    return TownSettings(
        seed=town.seed if given.seed is None else given.seed,
        detail=given.detail or town.detail,
        width=size.width,
        depth=size.depth,
        sloped=given.terrain,
    )


def _settings(kind: type[Any], values: dict[str, Any]) -> Any:
    return kind(**given_of(kind, values))


def _joined(arguments: Sequence[str]) -> list[str]:
    """Join options and values such as ``--region -5,-5,5,5``, which argparse takes for two options."""
    joined: list[str] = []
    for argument in arguments:
        if joined and joined[-1] in LISTS:
            joined[-1] += f"={argument}"
        else:
            joined.append(argument)
    return joined


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="tilesnav",
        description="Encode and inspect 3D Tiles with the extension 3DTILES_nav.",
        epilog=EXIT_STATUS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"tilesnav {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_encode(_command(commands, "encode", "make a tileset of a scene"))
    _add_cells(_command(commands, "cells", "divide the free space of a scene, and draw it"))
    _add_info(_command(commands, "info", "print the figures of a tileset"))
    add_path_options(_command(commands, "path", "drive a route and print what a vehicle receives"))
    _add_sample(_command(commands, "sample", "write the sample scene, a town"))
    _add_scene_options(add_scan(_command(commands, "scan", "scan a scene with a simulated LiDAR")))
    add_planes(_command(commands, "planes", "find the planar features of a point cloud"))
    add_register(_command(commands, "register", "bring scans together into one point cloud"))
    return parser


def _command(commands: Any, name: str, help_text: str) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = commands.add_parser(
        name,
        help=help_text,
        description=f"{help_text[0].upper()}{help_text[1:]}.",
        epilog=EXIT_STATUS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--debug", action="store_true", help="print the traceback of an error")
    return parser


def _add_info(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "tileset", type=Path, metavar="OUT", help="folder with tileset.json, or the file itself"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def _add_sample(parser: argparse.ArgumentParser) -> None:
    town = TownSettings()
    parser.add_argument(
        "out", type=Path, metavar="OUT.ply", help="file to write, .ply or .glb; it must not exist"
    )
    parser.add_argument(
        "--detail", choices=DETAILS, help=f"about 50, 250 or 1000 faces a building ({town.detail})"
    )
    parser.add_argument(
        "--size", choices=tuple(SIZES), default="small", help="a quarter of the site or all (small)"
    )
    parser.add_argument(
        "--seed", type=integer(0), metavar="N", help=f"start of the random numbers ({town.seed})"
    )
    parser.add_argument("--terrain", action="store_true", help="ground that rises and falls")


def _add_encode(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scene",
        type=Path,
        metavar="SCENE",
        help="PLY, OBJ, STL, OFF, GLB or glTF file, tileset.json, or point cloud",
    )
    parser.add_argument("out", type=Path, metavar="OUT", help="folder to make")
    parser.add_argument("--force", action="store_true", help="replace an older tileset at OUT when done")
    parser.add_argument("--quiet", action="store_true", help="no progress and no summary")
    parser.add_argument("--seed", type=integer(0), metavar="N", help="start of all random numbers")
    parser.add_argument(
        "--threads", type=integer(0), metavar="N", help="threads of each stage; 0: one for each processor"
    )
    parser.add_argument(
        "--work",
        type=Path,
        metavar="FOLDER",
        help="keep finished work there until done, so that the same command goes on after it was stopped",
    )
    parser.add_argument(
        "--update",
        type=Path,
        metavar="PREVIOUS",
        help="take over from this tileset of an earlier scene what cells list that see nothing of the change",
    )
    _add_scene_options(parser.add_argument_group("scene"))
    add_survey_options(parser.add_argument_group("point clouds"))
    _add_cell_options(parser.add_argument_group("cells"))
    _add_table_options(parser.add_argument_group("sets, levels and files"))
    add_coarse_options(parser.add_argument_group("coarse meshes"))


def _add_cells(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scene",
        type=Path,
        metavar="SCENE",
        help="PLY, OBJ, STL, OFF, GLB or glTF file, tileset.json, or point cloud",
    )
    parser.add_argument(
        "--plot", type=Path, metavar="FILE", help="picture to write, .png, .svg or .pdf (extra 'plot')"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--quiet", action="store_true", help="no progress")
    parser.add_argument("--seed", type=integer(0), metavar="N", help="start of the random points")
    parser.add_argument(
        "--coverage-points",
        type=integer(1),
        metavar="N",
        help=f"random points that measure the coverage ({CellSettings().coverage_points})",
    )
    parser.add_argument("--threads", type=integer(0), metavar="N", help="threads; 0: one for each processor")
    _add_scene_options(parser.add_argument_group("scene"))
    add_survey_options(parser.add_argument_group("point clouds"))
    _add_cell_options(parser.add_argument_group("cells"))


def _add_scene_options(group: Any) -> None:
    group.add_argument("--units", choices=tuple(METRES_PER_UNIT), help="length unit of the file (m)")
    group.add_argument("--up", choices=("auto", "x", "y", "z"), help="axis of the file that points up (auto)")
    group.add_argument("--crs", help="'enu' or a coordinate system such as EPSG:25832")
    group.add_argument(
        "--origin", type=numbers(3), metavar="X,Y,Z", help="zero of the nav frame, or lon,lat,height"
    )
    group.add_argument(
        "--grid", dest="grid_exponent", type=integer(), metavar="EXP", help="step 2^EXP m (-10)"
    )
    group.add_argument(
        "--region", type=numbers(4), metavar="X0,Y0,X1,Y1", help="part of the scene, m, nav frame"
    )
    group.add_argument(
        "--transparent",
        action="append",
        metavar="PATTERN",
        help="parts or materials whose name matches (shell-style) are seen and hide nothing; may be repeated",
    )
    group.add_argument(
        "--one-sided",
        action="append",
        metavar="PATTERN",
        help="those whose name matches are seen only from where their corners run counter-clockwise",
    )
    group.add_argument(
        "--terrain",
        action="append",
        metavar="PATTERN",
        help="those whose name matches are the ground; may be repeated (found by its shape)",
    )


def _add_cell_options(group: Any) -> None:
    cells = CellSettings()
    add_mission_options(group)
    group.add_argument(
        "--cells",
        dest="method",
        choices=("prisms", "boxes", "voxel"),
        help=f"prisms over trapezoids, merged boxes, or voxels ({cells.method})",
    )
    lengths = (
        ("--min-cell", "min_size", f"smallest edge of a cell ({cells.min_size:g})"),
        ("--max-cell", "max_size", f"largest edge of a cell ({cells.max_size:g})"),
        ("--voxel-size", "voxel_size", f"edge of a voxel ({cells.voxel_size:g})"),
        ("--clearance", "clearance", f"free distance around every cell ({cells.clearance:g})"),
    )
    for option, name, help_text in lengths:
        group.add_argument(option, dest=name, type=number, metavar="M", help=f"{help_text}, m")
    group.add_argument(
        "--cell-price",
        type=number,
        metavar="N",
        help=f"cubes of the smallest edge that a prism must add to be kept ({cells.cell_price:g})",
    )
    group.add_argument(
        "--keep-interiors", action="store_const", const=True, help="keep cells that are shut off from the sky"
    )
    group.add_argument(
        "--seed-point",
        dest="seeds",
        type=numbers(3),
        action="append",
        metavar="X,Y,Z",
        help="keep what is connected to this point instead of the sky; may be repeated",
    )


def _add_table_options(group: Any) -> None:
    sight, lod = VisibilitySettings(), LodSettings()
    group.add_argument(
        "--rays",
        type=integer(0, LIMITS["rays"]),
        metavar="N",
        help=f"uniform rays of a cell that find faces ({sight.rays})",
    )
    group.add_argument(
        "--max-range", type=number, metavar="M", help="leave out faces not seen from nearer than this, m"
    )
    group.add_argument(
        "--attempts", type=integer(0), metavar="N", help=f"tries to prove a face hidden ({sight.attempts})"
    )
    group.add_argument(
        "--depth", type=integer(0, LIMITS["depth"]), metavar="N", help=f"cuts above a try ({sight.depth})"
    )
    group.add_argument(
        "--certificates",
        action="store_const",
        const=True,
        help="write the proofs that faces are hidden, for others to check",
    )
    group.add_argument(
        "--lod-reference",
        dest="reference",
        type=number,
        metavar="L",
        help=f"L of code 0, 1/m ({lod.reference:g})",
    )
    group.add_argument(
        "--lod-base", dest="base", type=number, metavar="B", help=f"ratio of L of two codes ({lod.base:g})"
    )
    group.add_argument(
        "--lod-levels",
        dest="level_count",
        type=integer(1, 256),
        metavar="N",
        help=f"codes ({lod.level_count})",
    )
    group.add_argument(
        "--sector-cells",
        dest="cells_per_sector",
        type=integer(1),
        metavar="N",
        help=f"most cells in one nav file ({TilesetSettings().cells_per_sector})",
    )
