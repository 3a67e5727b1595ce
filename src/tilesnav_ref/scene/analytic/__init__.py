"""Small scenes whose visibility is known by reasoning.

Every scene is a function without parameters; `SCENES` has them by name.

>>> case = SCENES["one_wall"]()
>>> sorted(case.visible & case.hidden)
[]
"""

from __future__ import annotations

from collections.abc import Callable

from tilesnav_ref.scene.analytic import contact, rooms, walls
from tilesnav_ref.scene.analytic.case import AnalyticScene

SCENES: dict[str, Callable[[], AnalyticScene]] = {
    make.__name__: make
    for make in (
        walls.one_wall,
        walls.two_walls,
        walls.two_walls_apart,
        walls.slot,
        walls.corner_gap,
        walls.corner_closed,
        walls.t_junction,
        walls.doubled,
        walls.ridge,
        rooms.closed_room,
        rooms.box_in_room,
        rooms.l_corridor,
        rooms.party_walls,
        contact.touching_cell,
        contact.coplanar_target,
        contact.edge_on,
        contact.edge_on_hidden,
    )
}
"""The makers by the name of their scene."""


def all_scenes() -> tuple[AnalyticScene, ...]:
    """Make every scene."""
    return tuple(make() for make in SCENES.values())


__all__ = ["SCENES", "AnalyticScene", "all_scenes"]
