"""A scene from whatever file there is: a mesh, a tileset or a point cloud."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.load import load_scene
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.scene.settings import SceneReport, SceneSettings
from tilesnav_ref.survey.read import is_cloud
from tilesnav_ref.survey.scans import is_scans
from tilesnav_ref.survey.settings import SurveySettings


def open_scene(
    path: Path,
    settings: SceneSettings,
    survey: SurveySettings,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Scene, SceneReport]:
    """Read a scene; a point cloud is turned into planes and these into a mesh.

    Raises
    ------
    SceneError
        When the file cannot be read or holds no scene.
    """
    if not is_cloud(path) and not is_scans(path, survey.poses):
        if survey.poses is not None:
            raise SceneError(str(path), "poses", str(survey.poses), "poses for scans or a point cloud only")
        return load_scene(path, settings)
    try:
        from tilesnav_ref.survey.load import load_survey  # noqa: PLC0415 - extra 'lidar'
    except ImportError as error:
        allowed = "the extra 'lidar': pip install 'tilesnav[lidar]'"
        raise SceneError(str(path), "point cloud", f"no module {error.name}", allowed) from error
    return load_survey(path, settings, survey, progress)
