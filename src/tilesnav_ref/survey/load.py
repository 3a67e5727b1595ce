"""From a point cloud to a scene: planes, their mesh, and what is not known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.planar.detect import detect_planes
from tilesnav_ref.planar.ground import ground_points
from tilesnav_ref.planar.heightfield import fill_ground
from tilesnav_ref.planar.mesh import PlanarMesh, mesh_planes
from tilesnav_ref.planar.model import NO_PLANE, PlanarFeatures
from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.load import Clock, Placed, finish
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.scene.parts import MeshFile, Part
from tilesnav_ref.scene.planes import PlaneTable
from tilesnav_ref.scene.settings import SceneReport, SceneSettings
from tilesnav_ref.scene.unknown import UnknownSpace
from tilesnav_ref.survey.beams import unknown_beside_beams
from tilesnav_ref.survey.columns import unknown_below
from tilesnav_ref.survey.read import Survey, read_survey
from tilesnav_ref.survey.settings import SurveySettings

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class SurveyReport:
    """What became of a point cloud; lengths in metres."""

    points: int
    """In the region; those of the classes of noise are not counted."""
    left_out: int
    """Beyond the region."""
    planes: int
    inliers: int
    """Points on a plane; the others are stated nowhere but in what is not known to be free, and in the height
    field between planes of the ground."""
    ground_faces: int
    """Faces of that height field."""
    inlier_distance: float
    point_distance_95: float
    """95 of 100 inliers are this near to the faces of their plane or nearer."""
    view: str
    unknown_share: float
    """Part of the box of the returns that is not known to be free; 0 where all of it was taken for free."""
    origin: tuple[float, float, float] | None
    """What was taken off the coordinates of the file, in metres, z up."""


def load_survey(
    path: Path, settings: SceneSettings, survey: SurveySettings, progress: Progress | None = None
) -> tuple[Scene, SceneReport]:
    """Read a point cloud and make it the scene that is published and proved.

    Parameters
    ----------
    path : Path
        LAS, LAZ, PCD, E57, XYZ, or PLY without faces; or a folder of scans with their poses.
    settings : SceneSettings
        `region` keeps the points in it.
    survey : SurveySettings
    progress : callable or None
        Called with the steps done and all steps.

    Returns
    -------
    scene : Scene
        With the table of planes and the unknown space.
    report : SceneReport

    Raises
    ------
    SceneError
        When the file cannot be read, or no plane is found in it.
    """
    clock, show = Clock(), progress or (lambda *_: None)
    cloud = read_survey(path, settings, survey.poses)
    clock.lap("read")
    inside = _chosen(cloud.points, settings)
    cloud = cloud.only(inside)
    points = cloud.points
    if not len(points):
        raise SceneError(
            str(path), "points", f"none of {len(inside)} is in the region", "a part of the cloud"
        )
    show(1, 4)
    features = detect_planes(points, survey.planes)
    clock.lap("planes")
    show(2, 4)
    mesh = mesh_planes(points, features, survey.mesh)
    clock.lap("mesh")
    show(3, 4)
    if not len(mesh.faces):
        found = f"no plane in {len(points)} points"
        raise SceneError(str(path), "points", found, "flat surfaces; see --units")
    parts, plane_of_part = _parts(mesh)
    filled = _ground(cloud, features, mesh, survey)
    if filled is not None:
        parts, plane_of_part = (*parts, filled), np.append(plane_of_part, NO_PLANE)
    file = MeshFile(parts, 0)
    local = replace(cloud.frame, positions=np.concatenate([part.vertices for part in parts]))
    built, report = finish(Placed(str(path), file, local), replace(settings, region=None), clock)
    owner = np.repeat(plane_of_part, [len(part.faces) for part in parts])[built.source]
    scene = replace(built.scene, planes=_table(features, mesh, owner))
    if not survey.unknown_is_free:
        scene = replace(scene, unknown=_unknown(path, scene, cloud, survey))
    clock.lap("unknown")
    became = replace(
        _report(cloud, features, mesh, survey),
        left_out=int((~inside).sum()),
        ground_faces=0 if filled is None else len(filled.faces),
        unknown_share=0.0 if scene.unknown is None else round(scene.unknown.share(), 4),
    )
    return scene, replace(report, survey=asdict(became), seconds=clock.seconds)


def _chosen(points: NDArray[np.float64], settings: SceneSettings) -> NDArray[np.bool_]:
    """(N,) which points are in the region, grown by its margin."""
    if settings.region is None:
        return np.ones(len(points), np.bool_)
    low, high = np.array(settings.region[:2]), np.array(settings.region[2:])
    margin = settings.region_margin
    return np.asarray(((points[:, :2] >= low - margin) & (points[:, :2] <= high + margin)).all(axis=1))


def _parts(mesh: PlanarMesh) -> tuple[tuple[Part, ...], NDArray[np.int64]]:
    """One part for every plane that has faces, and the planes."""
    planes = np.unique(mesh.face_plane)
    parts = []
    for plane in planes:
        used, faces = np.unique(mesh.faces[mesh.face_plane == plane], return_inverse=True)
        parts.append(Part(f"plane {plane}", mesh.vertices[used], faces.reshape(-1, 3).astype(np.int64)))
    return tuple(parts), planes.astype(np.int64)


def _ground(
    cloud: Survey, features: PlanarFeatures, mesh: PlanarMesh, survey: SurveySettings
) -> Part | None:
    """The ground between planes, None where there is none or it was not seen from above."""
    if survey.view != "air" or not survey.fill_ground:
        return None
    ground = ground_points(cloud.points, cloud.classes)
    field = fill_ground(cloud.points, ground, features, mesh, survey.mesh)
    return Part("ground", field.vertices, field.faces) if len(field.faces) else None


def _table(features: PlanarFeatures, mesh: PlanarMesh, owner: NDArray[np.int64]) -> PlaneTable:
    return PlaneTable(
        normals=features.normals,
        offsets=features.offsets,
        centres=features.extents.centres,
        axes=features.extents.axes,
        half_sizes=features.extents.half_sizes,
        areas=np.array([shape.area for shape in mesh.shapes]),
        rms=features.rms,
        counts=features.counts,
        covariances=features.covariances,
        face_plane=owner.astype(np.int32),
    )


def _unknown(path: Path, scene: Scene, cloud: Survey, survey: SurveySettings) -> UnknownSpace:
    step = scene.step
    bounds = np.stack((scene.vertices.min(axis=0), scene.vertices.max(axis=0)))
    size, rise = max(round(survey.block / step), 1), max(round(survey.rise / step), 1)
    returns = np.round(cloud.points / step).astype(np.int64)
    if survey.view == "air":
        return unknown_below(returns, bounds, size, rise)
    if cloud.origins is None:
        found = "no positions of the scanner, so that nothing is known to be free"
        raise SceneError(str(path), "points", found, "scans with poses, view air, or unknown_is_free")
    origins = np.round(cloud.origins / step).astype(np.int64)
    return unknown_beside_beams(origins, returns, bounds, size)


def _report(
    cloud: Survey, features: PlanarFeatures, mesh: PlanarMesh, survey: SurveySettings
) -> SurveyReport:
    distances = mesh.inlier_distances(cloud.points, features)
    return SurveyReport(
        points=len(cloud.points),
        left_out=0,
        planes=len(features),
        inliers=int((features.labels != NO_PLANE).sum()),
        ground_faces=0,
        inlier_distance=round(float(features.inlier_distance), 6),
        point_distance_95=round(float(np.quantile(distances, 0.95)), 4),
        view=survey.view,
        unknown_share=0.0,
        origin=cloud.origin,
    )
