"""Scenes and neighbouring cells that the benchmarks share."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from tilesnav_ref.cells import CellSettings, decompose
from tilesnav_ref.cells.model import CellComplex
from tilesnav_ref.scene import Scene, SceneSettings, load_scene
from tilesnav_ref.scene.sample import TRAINING_SITE, make_town

TOWN = "town"
"""Stands for the sample town at its fine setting in the place of a file."""


def load(source: str, region: tuple[float, float, float, float] | None) -> Scene:
    """Read a mesh file, or make the sample town, about 70,000 faces."""
    if source == TOWN:
        return make_town(replace(TRAINING_SITE, detail="fine"))
    return load_scene(Path(source), SceneSettings(region=region))[0]


def neighbouring_cells(scene: Scene, settings: CellSettings, number: int) -> CellComplex:
    """Cells nearest to the middle of all, with the portals between them."""
    cells = decompose(scene, settings)
    centres = (cells.lower + cells.upper) / 2
    away = np.linalg.norm(centres - np.median(centres, axis=0), axis=1)
    chosen = np.sort(np.argsort(away, kind="stable")[:number])
    return cells.select(chosen)
