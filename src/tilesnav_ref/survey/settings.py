"""Settings of the way from a point cloud to a scene."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from tilesnav_ref.planar.mesh_settings import MeshSettings
from tilesnav_ref.planar.settings import PlaneSettings
from tilesnav_ref.scene.errors import SceneError

VIEWS = ("air", "ground")


@dataclass(frozen=True)
class SurveySettings:
    """How a point cloud becomes a scene."""

    planes: PlaneSettings = field(default_factory=PlaneSettings)
    mesh: MeshSettings = field(default_factory=MeshSettings)
    unknown_is_free: bool = False
    """Whether cells may be placed where the survey says nothing."""
    view: str = "air"
    """Where from it was scanned: "air", so that the space above all returns is known to be free, or "ground",
    so that only what beams from known positions have crossed is."""
    block: float = 1.0
    """Edge of the columns or blocks in which unknown space is stated, metres; a column needs a return."""
    poses: Path | None = None
    """File of the poses of the scans, where it is not in the folder with them."""
    rise: float = 0.25
    """Heights of unknown columns are rounded up to multiples of it, metres."""
    fill_ground: bool = False
    """Whether gaps between the planes on the ground are closed by a height field; seen from the air only.
    Off, since it doubles the faces of real clouds."""

    def __post_init__(self) -> None:
        """Check every setting: SceneError naming it."""
        for name in ("block", "rise"):
            value = getattr(self, name)
            if not 0.01 <= value <= 1000.0:
                raise SceneError("settings", name, repr(value), "0.01 to 1000 metres")
        if self.view not in VIEWS:
            raise SceneError("settings", "view", repr(self.view), ", ".join(VIEWS))
