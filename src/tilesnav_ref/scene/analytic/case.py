"""A small scene whose visibility is known by reasoning, and the pen that draws it."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from tilesnav_ref.scene.build import Soup, build_scene
from tilesnav_ref.scene.model import Scene
from tilesnav_ref.scene.settings import SceneSettings

STEPS = 1024
"""Grid steps of a metre."""

Point = tuple[float, float, float]
"""Metres, multiples of 2**-10."""


@dataclass(frozen=True)
class AnalyticScene:
    """A scene, a cell, and which faces are visible from it.

    Notes
    -----
    Visible and hidden are meant as the specification defines them: from the open interior of the cell, to
    the relative interior of the face, by half-open segments. A face in neither set is not determined.
    """

    name: str
    scene: Scene
    cell_lower: NDArray[np.int64]
    """(3,) grid coordinates."""
    cell_upper: NDArray[np.int64]
    """(3,) grid coordinates."""
    visible: frozenset[int]
    hidden: frozenset[int]
    why: str
    """The reasoning."""
    opening: tuple[Fraction, Fraction, Fraction] | None = None
    """Grid coordinates of a point in the opening through which some visible faces are seen, where it is
    narrow."""


@dataclass(frozen=True)
class Answer:
    """What is known, by the names of the drawn pieces."""

    visible: str
    """Names, separated by spaces."""
    hidden: str
    """Names, separated by spaces."""
    why: str
    opening: tuple[Fraction, Fraction, Fraction] | None = None


class Drawing:
    """Triangles with names.

    Parameters
    ----------
    name : str
        Of the scene.
    cell_lower, cell_upper : tuple of float
        Metres.
    """

    def __init__(self, name: str, cell_lower: Point, cell_upper: Point) -> None:
        self.name = name
        self.cell = (on_grid(cell_lower), on_grid(cell_upper))
        self._corners: list[NDArray[np.int64]] = []
        self._names: list[str] = []

    def triangle(self, name: str, a: Point, b: Point, c: Point) -> None:
        """Draw a triangle."""
        self._corners.append(np.stack([on_grid(p) for p in (a, b, c)]))
        self._names.append(name)

    def quad(self, name: str, a: Point, b: Point, c: Point, d: Point) -> None:
        """Draw the triangles a, b, c and a, c, d."""
        self.triangle(name, a, b, c)
        self.triangle(name, a, c, d)

    def wall_y(self, name: str, y: float, x: tuple[float, float], z: tuple[float, float] = (-20, 20)) -> None:
        """Draw a rectangle in a plane of constant y."""
        self.quad(name, (x[0], y, z[0]), (x[1], y, z[0]), (x[1], y, z[1]), (x[0], y, z[1]))

    def wall_x(self, name: str, x: float, y: tuple[float, float], z: tuple[float, float] = (-20, 20)) -> None:
        """Draw a rectangle in a plane of constant x."""
        self.quad(name, (x, y[0], z[0]), (x, y[1], z[0]), (x, y[1], z[1]), (x, y[0], z[1]))

    def plate(self, name: str, z: float, x: tuple[float, float], y: tuple[float, float]) -> None:
        """Draw a rectangle in a plane of constant z."""
        self.quad(name, (x[0], y[0], z), (x[1], y[0], z), (x[1], y[1], z), (x[0], y[1], z))

    def room(self, prefix: str, lower: Point, upper: Point) -> None:
        """Draw a closed box: west, east (x), south, north (y), floor, ceiling (z)."""
        x, y, z = zip(lower, upper, strict=True)
        self.wall_x(f"{prefix}west", x[0], y, z)
        self.wall_x(f"{prefix}east", x[1], y, z)
        self.wall_y(f"{prefix}south", y[0], x, z)
        self.wall_y(f"{prefix}north", y[1], x, z)
        self.plate(f"{prefix}floor", z[0], x, y)
        self.plate(f"{prefix}ceiling", z[1], x, y)

    def finish(self, answer: Answer) -> AnalyticScene:
        """Build the scene; parts of a divided triangle have the name, and the answer, of the triangle.

        Raises
        ------
        ValueError
            When the answer has a name that was not drawn.
        """
        corners = np.concatenate(self._corners)
        count = len(self._names)
        faces = np.arange(3 * count).reshape(-1, 3)
        built = build_scene(
            Soup(corners, faces, np.arange(count), tuple(self._names)), SceneSettings(), name=self.name
        )
        names = [self._names[i] for i in built.source]
        for wanted in (answer.visible + " " + answer.hidden).split():
            if wanted not in names:
                raise ValueError(f"{self.name}: no piece named {wanted}")
        visible, hidden = answer.visible.split(), answer.hidden.split()
        return AnalyticScene(
            name=self.name,
            scene=built.scene,
            cell_lower=self.cell[0],
            cell_upper=self.cell[1],
            visible=frozenset(i for i, n in enumerate(names) if n in visible),
            hidden=frozenset(i for i, n in enumerate(names) if n in hidden),
            why=answer.why,
            opening=answer.opening,
        )


def on_grid(point: Point) -> NDArray[np.int64]:
    """Grid coordinates of a point.

    Raises
    ------
    ValueError
        When it is not on the grid.
    """
    scaled = np.array(point, np.float64) * STEPS
    rounded = np.rint(scaled).astype(np.int64)
    if not np.array_equal(rounded, scaled):
        raise ValueError(f"{point} is not on the grid")
    return rounded
