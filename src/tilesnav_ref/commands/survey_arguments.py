"""Options for scenes that are point clouds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from tilesnav_ref.commands.values import number
from tilesnav_ref.planar.mesh_settings import MeshSettings
from tilesnav_ref.planar.settings import PlaneSettings
from tilesnav_ref.survey import SurveySettings
from tilesnav_ref.survey.settings import VIEWS


def add_survey_options(group: Any) -> None:
    """Add what only matters where the scene is a point cloud."""
    group.add_argument(
        "--inlier-distance",
        type=number,
        metavar="M",
        help="greatest distance of a point from its plane, m (four times the noise of the cloud)",
    )
    group.add_argument(
        "--outline-resolution",
        type=number,
        metavar="M",
        help=f"points nearer to each other add nothing to an outline ({MeshSettings().resolution:g}), m",
    )
    group.add_argument(
        "--view",
        choices=VIEWS,
        help="scanned from the air, so that what is above all returns is free, or from known places (air)",
    )
    group.add_argument(
        "--poses",
        type=Path,
        metavar="FILE",
        help="poses of the scans: a line each, time x y z qx qy qz qw (poses.txt in a folder of scans)",
    )
    group.add_argument(
        "--unknown-is-free",
        action="store_const",
        const=True,
        help="place cells also where the cloud says nothing: below eaves, under trees, behind walls",
    )
    group.add_argument(
        "--unknown-block",
        type=number,
        metavar="M",
        help=f"edge of the columns in which unknown space is stated ({SurveySettings().block:g}), m",
    )
    group.add_argument(
        "--fill-ground",
        action="store_const",
        const=True,
        help="close gaps between planes of the ground by a height field; doubles the faces (view air)",
    )


def survey_settings(values: dict[str, Any]) -> SurveySettings:
    """Make the settings of point clouds; what was not given keeps its default.

    Raises
    ------
    SceneError, ValueError
        When a setting is refused.
    """
    planes, mesh, survey = PlaneSettings(), MeshSettings(), SurveySettings()
    return SurveySettings(
        planes=replace(
            planes,
            inlier_distance=values.get("inlier_distance", planes.inlier_distance),
            seed=values.get("seed", planes.seed),
            threads=values.get("threads", planes.threads),
        ),
        mesh=replace(mesh, resolution=values.get("outline_resolution", mesh.resolution)),
        unknown_is_free=values.get("unknown_is_free", False),
        view=values.get("view", survey.view),
        block=values.get("unknown_block", survey.block),
        poses=values.get("poses"),
        fill_ground=values.get("fill_ground", False),
    )
