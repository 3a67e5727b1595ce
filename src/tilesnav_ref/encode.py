"""The pipeline: from a scene file to a tileset."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tilesnav_ref.cells import CellSettings, decompose, planes
from tilesnav_ref.levels import CoarseLevel, LevelSettings, coarse_levels
from tilesnav_ref.lod import LodSettings, choose_levels
from tilesnav_ref.scene import SceneSettings
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.survey import SurveySettings, open_scene
from tilesnav_ref.tileset.delta import make_deltas
from tilesnav_ref.tileset.folder import new_folder
from tilesnav_ref.tileset.model import NavMap, TilesetSettings
from tilesnav_ref.tileset.provenance import make_provenance
from tilesnav_ref.tileset.run_report import StageProgress, Stopwatch, run_report, write_report
from tilesnav_ref.tileset.write import write_tileset
from tilesnav_ref.update import Update, find_changes, open_previous
from tilesnav_ref.visibility import VisibilitySettings, compute_pvs, forget_work


@dataclass(frozen=True)
class EncodeSettings:
    """Settings of every stage."""

    scene: SceneSettings = field(default_factory=SceneSettings)
    survey: SurveySettings = field(default_factory=SurveySettings)
    """Of point clouds."""
    cells: CellSettings = field(default_factory=CellSettings)
    visibility: VisibilitySettings = field(default_factory=VisibilitySettings)
    lod: LodSettings = field(default_factory=LodSettings)
    coarse: LevelSettings = field(default_factory=LevelSettings)
    tileset: TilesetSettings = field(default_factory=TilesetSettings)
    update: Path | None = None
    """An earlier tileset; what cells list that see nothing of the change is taken over."""

    def __post_init__(self) -> None:
        """Refuse certificates where faces are left out without one: ValueError."""
        if self.visibility.certificates and (self.scene.one_sided or self.visibility.max_range is not None):
            raise ValueError(
                "setting certificates: found with one_sided or max_range, which leave faces out without a"
                " certificate; allowed: certificates alone or with transparent"
            )


def encode(
    source: Path,
    out: Path,
    settings: EncodeSettings,
    force: bool = False,
    progress: StageProgress | None = None,
    work: Path | None = None,
) -> dict[str, Any]:
    """Make a tileset of a scene; `out` appears complete or not at all.

    Parameters
    ----------
    source : mesh file, tileset or point cloud.
    out : folder to make.
    settings : of every stage.
    force : whether an older tileset at `out` is replaced.
    progress : called with the stage, its finished and all its steps.
    work : folder where finished parts of the longest stage are kept for a run that is stopped; a later run
        with the same input and settings goes on from there.

    Returns
    -------
    dict
        The report of the run.
    """
    watch = Stopwatch(progress)
    update: Update | None = None
    with new_folder(out, force) as folder:
        previous = None if settings.update is None else open_previous(settings.update, settings.visibility)
        with watch.stage("scene") as steps:
            scene, found = open_scene(source, settings.scene, settings.survey, steps)
            if previous is not None:
                previous.check_frame(scene)
        with watch.stage("cells") as steps:
            cells = decompose(scene, settings.cells, steps)
        if previous is not None:
            with watch.stage("changes") as steps:
                update = find_changes(previous, scene, cells, settings.visibility, steps)
        todo = cells if update is None else update.todo
        with watch.stage("visibility") as steps:
            pvs = compute_pvs(scene, todo, settings.visibility, steps, work)
            pvs = pvs if update is None else update.merge(pvs)
        with watch.stage("levels") as steps:
            lod = choose_levels(scene, cells, pvs, settings.lod, steps, settings.visibility.threads)
        with watch.stage("deltas"):
            deltas = make_deltas(cells, pvs, lod)
        coarse = _coarse_levels(scene, settings, watch)
        with watch.stage("write"):
            provenance = make_provenance(source, _stages(settings, scene, update), found, cells, pvs)
            if update is not None:
                provenance["update"] = update.findings
            nav_map = NavMap(
                scene, cells, pvs, lod, deltas, provenance, settings.visibility.max_range, coarse
            )
            write_tileset(folder, nav_map, planes(cells, scene.step), settings.tileset)
        report = run_report(watch)
        write_report(folder, report)
    if work is not None:
        forget_work(scene, todo, settings.visibility, work)
    return report


def _coarse_levels(scene: Scene, settings: EncodeSettings, watch: Stopwatch) -> tuple[CoarseLevel, ...]:
    """Coarse levels, where any are asked for."""
    if settings.coarse.levels == 1:
        return ()
    with watch.stage("simplification") as steps:
        return coarse_levels(scene, settings.coarse, steps, settings.visibility.threads)


def _stages(settings: EncodeSettings, scene: Scene, update: Update | None) -> dict[str, Any]:
    """Settings of the stages that ran; an update is stated by what was updated, not by where it lay."""
    left_out = {"update"} if settings.coarse.levels > 1 else {"update", "coarse"}
    left_out |= set() if scene.planes is not None else {"survey"}
    stages = {name: of_stage for name, of_stage in vars(settings).items() if name not in left_out}
    return stages if update is None else {**stages, "update": update.parameters}
