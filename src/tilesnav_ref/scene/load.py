"""From a file to a scene and a report on it."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.build import Build, Soup, build_scene
from tilesnav_ref.scene.crop import Crop, crop
from tilesnav_ref.scene.errors import SceneError
from tilesnav_ref.scene.frame import NavFrame, to_nav
from tilesnav_ref.scene.kinds import part_kinds
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.scene.parts import MeshFile
from tilesnav_ref.scene.read import read_mesh
from tilesnav_ref.scene.settings import METRES_PER_UNIT, SceneReport, SceneSettings
from tilesnav_ref.scene.tiles import place, read_tileset
from tilesnav_ref.scene.weld import snap, weld


class Clock:
    """Seconds by step."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, name: str) -> None:
        """Book the time since the last lap under a name."""
        now = time.perf_counter()
        self.seconds[name] = round(now - self._last, 4)
        self._last = now


def load_scene(path: str | PathLike[str], settings: SceneSettings | None = None) -> tuple[Scene, SceneReport]:
    """Read a mesh file and make it the scene that is published and proved.

    Parameters
    ----------
    path : str or path
        PLY, OBJ, STL, GLB, glTF or OFF file, or the entry tileset of 3D Tiles (.json).
    settings : SceneSettings or None
        None for the defaults.

    Returns
    -------
    scene : Scene
        Grid coordinates in the nav frame.
    report : SceneReport
        What was found and done.

    Raises
    ------
    SceneError
        Naming the file, the place, what was found and what is allowed.
    """
    settings = settings or SceneSettings()
    path = Path(path)
    clock = Clock()
    by_name = settings.transparent + settings.one_sided + settings.terrain
    is_tileset = path.suffix.lower() == ".json"
    if is_tileset:
        mesh = read_tileset(path, settings.up, settings.max_faces, with_materials=bool(by_name))
    else:
        mesh = read_mesh(path, settings.max_faces, with_materials=bool(by_name))
    labels = [part.labels for part in mesh.parts]
    named = (settings.transparent, settings.one_sided, str(path), settings.terrain)
    kinds = part_kinds(labels, *named) if by_name else None
    clock.lap("read")
    vertices = _concatenate(mesh)[0]
    if is_tileset:
        frame = place(str(path), vertices, settings)
    else:
        frame = to_nav(str(path), path.suffix.lower(), vertices, settings)
    built, report = finish(Placed(str(path), mesh, frame), settings, clock, kinds)
    return built.scene, report


@dataclass(frozen=True)
class Placed:
    """Parts of a file in the nav frame."""

    source: str
    """File named in errors."""
    mesh: MeshFile
    frame: NavFrame
    """Its positions are the vertices of all parts."""


def finish(
    placed: Placed, settings: SceneSettings, clock: Clock, kinds: NDArray[np.int64] | None = None
) -> tuple[Build, SceneReport]:
    """Snap, crop and build what has been read and placed; ``kinds`` (P,) are those of kinds.py.

    Raises
    ------
    SceneError
        As for :func:`load_scene`.
    """
    source, mesh, frame = placed.source, placed.mesh, placed.frame
    _, faces, part = _concatenate(mesh)
    snapped = snap(frame.positions, settings.grid_exponent, source)
    used = len(np.unique(faces))
    soup = Soup(*weld(snapped, faces), part, tuple(p.name for p in mesh.parts), kinds)
    merged = used - len(soup.vertices)
    clock.lap("snap")
    soup, cropping = _crop(soup, settings, source)
    clock.lap("crop")
    built = build_scene(soup, settings, frame.tileset_from_nav, source)
    clock.lap("build")
    return built, _report(source, mesh, _Steps(frame, snapped, merged, cropping, built), settings, clock)


@dataclass(frozen=True)
class _Steps:
    """Results of the steps, for the report."""

    frame: NavFrame
    snapped: NDArray[np.int64]
    merged: int
    cropping: Crop | None
    built: Build


def _concatenate(mesh: MeshFile) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    starts = np.cumsum([0, *(len(p.vertices) for p in mesh.parts[:-1])])
    vertices = np.concatenate([p.vertices for p in mesh.parts])
    faces = np.concatenate([p.faces + start for p, start in zip(mesh.parts, starts, strict=True)])
    return vertices, faces, np.repeat(np.arange(len(mesh.parts)), [len(p.faces) for p in mesh.parts])


def _crop(soup: Soup, settings: SceneSettings, source: str) -> tuple[Soup, Crop | None]:
    """Keep what the region keeps."""
    if settings.region is None:
        return soup, None
    x0, y0, x1, y1 = (c / settings.step for c in settings.region)
    margin = settings.region_margin / settings.step
    result = crop(soup.vertices.astype(np.float64), soup.faces, (x0, y0, x1, y1), margin)
    if not result.keep.any():
        lower, upper = soup.vertices.min(axis=0), soup.vertices.max(axis=0)
        extent = f"{np.array2string(lower * settings.step)} to {np.array2string(upper * settings.step)} m"
        raise SceneError(source, "region", f"no face in {settings.region}", f"a part of {extent}")
    kept = result.keep
    return replace(soup, faces=soup.faces[kept], part=soup.part[kept]), result


def _report(
    source: str, mesh: MeshFile, steps: _Steps, settings: SceneSettings, clock: Clock
) -> SceneReport:
    scene, built, cropping = steps.built.scene, steps.built, steps.cropping
    moved = np.linalg.norm(steps.snapped * settings.step - steps.frame.positions, axis=1)
    lower, upper = (
        tuple(float(c) * settings.step for c in bound)
        for bound in (scene.vertices.min(axis=0), scene.vertices.max(axis=0))
    )
    return SceneReport(
        source=source,
        parts=len(mesh.parts),
        file_vertices=sum(len(p.vertices) for p in mesh.parts),
        file_faces=sum(len(p.faces) for p in mesh.parts),
        up=steps.frame.up,
        metres_per_unit=METRES_PER_UNIT[settings.units],
        vertices=len(scene.vertices),
        faces=scene.face_count,
        objects=scene.object_count,
        contents=scene.content_count,
        lower=(lower[0], lower[1], lower[2]),
        upper=(upper[0], upper[1], upper[2]),
        moved_max=float(moved.max()),
        vertices_merged=steps.merged,
        degenerate_removed=built.degenerate_removed,
        components=built.topology.components,
        boundary_edges=built.topology.boundary_edges,
        non_manifold_edges=built.topology.non_manifold_edges,
        doubled_faces=built.topology.doubled_faces,
        junctions=built.junctions,
        faces_divided=built.faces_divided,
        faces_before_noding=built.faces_before_noding,
        cropped_faces=0 if cropping is None else int((~cropping.keep).sum()),
        cut_components=0 if cropping is None else cropping.cut_components,
        notes=(*steps.frame.notes, *mesh.notes, *_notes(mesh, cropping, settings)),
        seconds=clock.seconds,
    )


def _notes(mesh: MeshFile, cropping: Crop | None, settings: SceneSettings) -> list[str]:
    notes = []
    if mesh.skipped:
        notes.append(f"{mesh.skipped} sets of points or lines were left out")
    if cropping is not None and cropping.cut_components:
        count = f"{cropping.cut_components} of {cropping.components} components"
        near = f"faces within {settings.region_margin:g} m of it"
        notes.append(f"{count} are larger than the region; of them only the {near} were kept")
    return notes
