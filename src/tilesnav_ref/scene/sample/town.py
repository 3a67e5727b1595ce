"""The town: ground and buildings become a scene."""

from __future__ import annotations

from itertools import pairwise

from tilesnav_ref.scene.build import build_scene
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.scene.sample.buildings import WING, Site, draw_building
from tilesnav_ref.scene.sample.canvas import Canvas, Terrain
from tilesnav_ref.scene.sample.plan import Block, make_plan
from tilesnav_ref.scene.sample.settings import TownSettings
from tilesnav_ref.scene.settings import SceneSettings


def make_town(settings: TownSettings | None = None) -> Scene:
    """Make the sample town.

    Parameters
    ----------
    settings : TownSettings or None
        None for the small default.

    Returns
    -------
    Scene
        Metres are 1024 grid steps; the ground of every block and every building is an object.

    Notes
    -----
    Equal settings give equal scenes. Buildings stand on the ground without overlap; each is closed but for
    its bottom; no vertex lies inside an edge.
    """
    settings = settings or TownSettings()
    plan = make_plan(settings)
    canvas = Canvas()
    site = Site(canvas, plan.terrain, settings.detail)
    for number, block in enumerate(plan.blocks):
        canvas.begin(f"block {number} ground")
        _draw_ground(canvas, plan.terrain, block)
        for building in block.buildings:
            draw_building(site, building)
    return build_scene(canvas.soup(), SceneSettings(), name="sample town").scene


def _draw_ground(canvas: Canvas, terrain: Terrain, block: Block) -> None:
    """Rectangles between all lines of the block's footprints, so that walls stand on edges of the ground."""
    x0, y0, x1, y1 = block.ground
    xs, ys = {x0, x1}, {y0, y1}
    for building in block.buildings:
        a, b, c, d = building.footprint
        xs |= {a, c}
        ys |= {b, d}
        if building.kind == "courtyard":
            xs |= {a + WING, c - WING}
            ys |= {b + WING, d - WING}
    columns, rows = sorted(xs), sorted(ys)
    for left, right in pairwise(columns):
        for low, high in pairwise(rows):
            canvas.polygon(
                terrain.point(left, low),
                terrain.point(right, low),
                terrain.point(right, high),
                terrain.point(left, high),
            )
