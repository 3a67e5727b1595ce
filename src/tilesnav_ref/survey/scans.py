"""Scans and where they were made: a folder with a file a scan, or one file whose points name their scan."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.clouds import OPENERS, Chunk, CloudSettings, PointCloud, cloud_chunks, read_cloud
from tilesnav_ref.clouds.model import CloudFile
from tilesnav_ref.registration.motion import place
from tilesnav_ref.registration.poses import read_poses
from tilesnav_ref.registration.settings import RegistrationError
from tilesnav_ref.scene.errors import SceneError

POSES = "poses.txt"
"""Poses of the scans in a folder."""


def is_scans(path: Path, poses: Path | None = None) -> bool:
    """Whether a path is a folder of scans: one with `POSES`, or any for which poses are given."""
    return path.is_dir() and (poses is not None or (path / POSES).is_file())


def read_scans(path: Path, settings: CloudSettings, poses: Path | None = None) -> PointCloud:
    """Read a cloud or a folder of scans, with the places of the scanner where they are known.

    Parameters
    ----------
    path : Path
        A point cloud; or a folder with a point cloud a scan, each in the frame of its scanner. The order of
        their names is that of the poses.
    settings : CloudSettings
        For a folder, the region is in the frame that the poses lead to, in metres.
    poses : Path or None
        Lines as in :mod:`tilesnav_ref.registration.poses`, frame of the result from scanner, metres. None:
        those in the folder. For a file: its points have a field `scan`, the number of their line from 0.

    Returns
    -------
    PointCloud
        The places of the scanner are those in the fields `PLACE` of the points, else where the pose is.

    Raises
    ------
    SceneError
        When poses are missing, broken or of another number than scans, or a file cannot be read.
    """
    if path.is_dir():
        return read_cloud(_folder(path, settings, poses), replace(settings, units="m", classes=()))
    cloud = read_cloud(path, settings)
    return cloud if poses is None else _with_poses(str(path), cloud, poses)


def _poses(path: Path) -> NDArray[np.float64]:
    """(S, 4, 4)."""
    try:
        return read_poses(path)
    except RegistrationError as error:
        raise SceneError(error.source, "poses", error.found, error.allowed) from error
    except OSError as error:
        raise SceneError(str(path), "poses", error.strerror or str(error), "a file of poses") from error


def _folder(path: Path, settings: CloudSettings, given: Path | None) -> CloudFile:
    """The scans in a folder as one file, in metres."""
    source = path / POSES if given is None else given
    poses = _poses(source)
    own = source.name if source.parent.resolve() == path.resolve() else POSES
    names = sorted(file for file in path.iterdir() if file.suffix.lower() in OPENERS and file.name != own)
    names = [file for file in names if file.name != POSES]
    if len(names) != len(poses):
        found = f"{len(poses)} for {len(names)} scans in {path}"
        raise SceneError(str(source), "poses", found, "one line for each scan, in the order of their names")
    reading = replace(settings, region=None, thin=0.0)
    return CloudFile(str(path), None, _placed(names, poses, reading), scan_origins=poses[:, :3, 3].copy())


def _placed(names: list[Path], poses: NDArray[np.float64], reading: CloudSettings) -> Iterator[Chunk]:
    for number, (file, pose) in enumerate(zip(names, poses, strict=True)):
        for chunk, _, _ in cloud_chunks(file, reading):
            # A scanner without places of its own stood still where the frame of its scan begins.
            local = np.zeros_like(chunk.points) if chunk.places is None else chunk.places
            scans = np.full(len(local), number, np.int32)
            points, places = place(pose, chunk.points), place(pose, local)
            yield chunk._replace(points=points, places=places, scans=scans, ids=None)


def _with_poses(source: str, cloud: PointCloud, path: Path) -> PointCloud:
    """A cloud with the places of its scans."""
    poses = _poses(path)
    if cloud.ids is None:
        raise SceneError(source, "points", "no field 'scan' to tie them to poses", "the number of the scan")
    wrong = (cloud.ids < 0) | (cloud.ids >= len(poses))
    if wrong.any():
        found = f"scan {cloud.ids[np.argmax(wrong)]} where {path} has {len(poses)} poses"
        raise SceneError(source, "points", found, "numbers of lines of poses, counted from 0")
    return replace(cloud, places=poses[cloud.ids, :3, 3] - cloud.origin)
