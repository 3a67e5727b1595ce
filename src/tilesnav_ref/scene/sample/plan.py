"""Where streets, blocks and buildings are; independent of the detail."""

from __future__ import annotations

import random
from dataclasses import dataclass

from tilesnav_ref.scene.sample.canvas import Terrain
from tilesnav_ref.scene.sample.settings import BLOCK_PITCH, METRE, UNIT, TownSettings

STREET = 6 * METRE
"""Width of a street."""
KINDS = ("courtyard", "arcade", "tower", "houses")

Rectangle = tuple[int, int, int, int]
"""x0, y0, x1, y1 in grid steps, multiples of UNIT."""


@dataclass(frozen=True)
class Building:
    """The mass of a building."""

    name: str
    kind: str
    """house, courtyard, arcade or tower."""
    footprint: Rectangle
    storeys: int
    gabled: bool = False
    hollow: bool = False
    """Whether it can be entered by its door."""


@dataclass(frozen=True)
class Block:
    """The ground up to the middles of the streets around, and what stands on it."""

    ground: Rectangle
    buildings: tuple[Building, ...]


@dataclass(frozen=True)
class Plan:
    """A town without walls."""

    terrain: Terrain
    blocks: tuple[Block, ...]


def make_plan(settings: TownSettings) -> Plan:
    """Lay out the town for a seed and a size."""
    rng = random.Random(settings.seed)
    columns, rows = settings.width // BLOCK_PITCH, settings.depth // BLOCK_PITCH
    pitch = BLOCK_PITCH * METRE
    knots = tuple((i * pitch) - columns * pitch // 2 // UNIT * UNIT for i in range(columns + 1))
    slopes = tuple(rng.choice((-5, -3, -2, 2, 3, 5)) for _ in range(columns))
    terrain = Terrain(knots, slopes if settings.sloped else (0,) * columns)
    kinds = _block_kinds(rng, columns * rows)
    south = -(rows * pitch // 2 // UNIT * UNIT)
    blocks = []
    for i in range(columns * rows):
        x, y = knots[i % columns], south + (i // columns) * pitch
        blocks.append(_block(rng, i, kinds[i], (x, y, x + pitch, y + pitch)))
    return Plan(terrain, tuple(blocks))


def _block_kinds(rng: random.Random, count: int) -> list[str]:
    """One of each special kind in every eight blocks, as far as they go, in random places."""
    special = ["courtyard", "arcade", "tower"] * max(1, count // 8)
    kinds = special[:count] + ["houses"] * max(0, count - len(special))
    rng.shuffle(kinds)
    return kinds


def _block(rng: random.Random, number: int, kind: str, ground: Rectangle) -> Block:
    half = STREET // 2
    x0, y0, x1, y1 = ground[0] + half, ground[1] + half, ground[2] - half, ground[3] - half
    name = f"block {number}"
    if kind == "courtyard":
        return Block(
            ground, (Building(f"{name} courtyard", "courtyard", (x0, y0, x1, y1), rng.randint(2, 3)),)
        )
    if kind == "arcade":
        middle = y0 + (y1 - y0) * 3 // 8 // UNIT * UNIT
        arcade = Building(f"{name} arcade", "arcade", (x0, y0, x1, middle), 2, gabled=True)
        return Block(ground, (arcade, *_houses(rng, name, (x0, middle + 2 * METRE, x1, y1), (2, 1))))
    if kind == "tower":
        side = 6 * METRE
        tower = Building(f"{name} tower", "tower", (x0, y0, x0 + side, y0 + side), rng.randint(6, 8))
        east = (x0 + side + 3 * METRE, y0, x1, y0 + 8 * METRE)
        north = (x0, y0 + 10 * METRE, x1, y1)
        return Block(
            ground, (tower, *_houses(rng, f"{name} east", east, (1, 1)), *_houses(rng, name, north, (2, 1)))
        )
    return Block(ground, _houses(rng, name, (x0, y0, x1, y1), (2, 2)))


def _houses(rng: random.Random, name: str, plot: Rectangle, count: tuple[int, int]) -> tuple[Building, ...]:
    """Houses in equal lots of a plot, each smaller than its lot by a random yard, so that none touch."""
    width, depth = (plot[2] - plot[0]) // count[0], (plot[3] - plot[1]) // count[1]
    houses = []
    for i in range(count[0] * count[1]):
        x, y = plot[0] + (i % count[0]) * width, plot[1] + (i // count[0]) * depth
        yard = [rng.randrange(8, 25) * UNIT for _ in range(4)]  # 0.5 to 1.5 m
        x0, y0 = _up(x + yard[0]), _up(y + yard[1])
        x1, y1 = (x + width - yard[2]) // UNIT * UNIT, (y + depth - yard[3]) // UNIT * UNIT
        x1, y1 = x1 - (x1 - x0) % (2 * UNIT), y1 - (y1 - y0) % (2 * UNIT)  # a ridge in the middle
        storeys, gabled, hollow = rng.choice((1, 2, 2, 3)), rng.random() < 0.6, rng.random() < 0.35
        houses.append(Building(f"{name} house {i}", "house", (x0, y0, x1, y1), storeys, gabled, hollow))
    return tuple(houses)


def _up(value: int) -> int:
    return -(-value // UNIT) * UNIT
