"""What is read: meshes become one scene of exact grid coordinates."""

from tilesnav_ref.scene.build import Build, Soup, build_scene
from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.load import load_scene
from tilesnav_ref.scene.model import COORDINATE_LIMIT, Scene
from tilesnav_ref.scene.settings import METRES_PER_UNIT, SceneReport, SceneSettings
from tilesnav_ref.scene.write import write_mesh

__all__ = [
    "COORDINATE_LIMIT",
    "METRES_PER_UNIT",
    "Build",
    "Scene",
    "SceneError",
    "SceneReport",
    "SceneSettings",
    "Soup",
    "build_scene",
    "load_scene",
    "write_mesh",
]
