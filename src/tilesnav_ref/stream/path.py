"""The bandwidth experiment: one route, with packets at several levels and by what users have today."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from tilesnav_ref.stream.comparison import ComparisonSettings, Rival, rivals
from tilesnav_ref.stream.delivery import Delivery
from tilesnav_ref.stream.drive import UNLIMITED, Drive, DriveSettings, drive
from tilesnav_ref.stream.gates import gates_of
from tilesnav_ref.stream.places import places_of
from tilesnav_ref.stream.policy import NAMES, LevelPolicy
from tilesnav_ref.stream.reader import NavTileset
from tilesnav_ref.stream.route import Route, route_through
from tilesnav_ref.stream.stock import stock_route

Progress = Callable[[str, int, int], None]
"""Stage, steps done, steps in all."""


@dataclass(frozen=True)
class PathSettings:
    """What is driven, and how."""

    route: str | tuple[tuple[float, ...], ...] = "roof"
    """Name of a stock route, or way points, m, nav frame."""
    policies: tuple[str, ...] = NAMES
    speed: float = 20.0
    """m/s."""
    retain: int = 0
    """Faces that the vehicle may hold beyond what its cell calls for."""
    comparison: ComparisonSettings = field(default_factory=ComparisonSettings)


@dataclass(frozen=True)
class PathResult:
    """A route and what was received along it."""

    route: Route
    drives: dict[str, Drive]
    """By policy."""
    keeping: dict[str, Drive]
    """The same for a vehicle that drops nothing."""
    rivals: tuple[Rival, ...]


def find_route(tileset: NavTileset, wanted: str | tuple[tuple[float, ...], ...]) -> Route:
    """Choose a stock route by its name, or find the way through way points.

    Raises
    ------
    RouteError
        When there is none.
    """
    gates = gates_of(tileset)
    if isinstance(wanted, str):
        return stock_route(tileset, gates, wanted)
    return route_through(gates, places_of(tileset), wanted)


def run_path(tileset: NavTileset, settings: PathSettings, progress: Progress) -> PathResult:
    """Drive a route in all ways.

    Raises
    ------
    RouteError, TilesetError, PacketError
        When there is no route, or the tileset is not sound.
    """
    total = 2 * len(settings.policies) + 2
    progress("path", 0, total)
    route = find_route(tileset, settings.route)
    progress("path", 1, total)
    delivery = Delivery(tileset)
    drives: dict[int, dict[str, Drive]] = {settings.retain: {}, UNLIMITED: {}}
    done = 1
    for retain, driven in drives.items():
        for name in settings.policies:
            driven[name] = drive(delivery, route, DriveSettings(LevelPolicy(name), settings.speed, retain))
            done += 1
            progress("path", done, total)
    found = rivals(delivery, route, settings.speed, settings.comparison)
    progress("path", total, total)
    return PathResult(route, drives[settings.retain], drives[UNLIMITED], found)
