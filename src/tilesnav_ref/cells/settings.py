"""What a decomposition can be asked for, and the error it raises."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Point = tuple[float, float, float]


class CellError(ValueError):
    """No sound cell complex can be made from this scene with these settings."""


@dataclass(frozen=True)
class CellSettings:
    """Size, place and selection of navigation cells; lengths in metres, nav frame."""

    min_size: float = 2.0
    """Smallest edge of a cell, m; of a trapezoid's sides across its slant, the mean."""
    max_size: float = 16.0
    """Largest edge of a cell, m; a smaller cell has a smaller potentially visible set."""
    clearance: float = 0.25
    """Distance by which every plane of a cell can move outwards without meeting a face, m; rounded up to
    the grid."""
    mission: Literal["aerial", "ground", "corridor"] = "aerial"
    """Which free space is divided: a band of altitude above the ground, what ground vehicles reach, or the
    part of the band that tiles along a line hold."""
    altitude_min: float = 0.0
    """Lower end of the cells above the ground, m; missions "aerial" and "corridor"."""
    altitude_max: float | None = None
    """Upper end of the cells above the ground, m; None: the lower of 152.4 m (500 ft) above the ground and
    ``max_size`` above the highest point of the scene in the region."""
    altitude_above: Literal["ground", "lowest"] = "ground"
    """What altitudes count from: the ground straight below, or the lowest point in the region."""
    corridor: tuple[Point, ...] = ()
    """Points of the line that mission "corridor" follows, m, nav frame."""
    corridor_radius: float = 10.0
    """Radius of the tube around the line, m."""
    sector_size: float | None = None
    """Edge of the square sectors whose borders no cell crosses, m; borders lie at its multiples in the nav
    frame. None: no sectors."""
    sector: tuple[int, int] | None = None
    """Keep the cells of this sector alone: column and row, (0, 0) from the zero of the nav frame to
    ``sector_size``."""
    region: tuple[float, float, float, float] | None = None
    """(x0, y0, x1, y1) of the domain, m; None: the bounds of the scene. Faces beyond it still block."""
    ground_height: float = 3.0
    """A cell is of kind ground when a face that carries a vehicle lies at most this far below its lower
    face, m."""
    ground_slope: float = 1.0
    """Largest slope of a face that carries a vehicle, rise over run."""
    ground_step: float = 0.3
    """Highest step that a ground vehicle climbs, m; mission "ground"."""
    seeds: Literal["sky"] | tuple[Point, ...] = "sky"
    """Cells are kept when portals connect them to the open sky, or to the cells that hold these points
    (m)."""
    keep_interiors: bool = False
    """Keep every free cell, connected or not; for indoor scenes."""
    method: Literal["prisms", "boxes", "voxel"] = "prisms"
    """Greedy prisms over trapezoids; recursive boxes, or uniform voxels as baselines."""
    cell_price: float = 4.0
    """Volume that a prism must add to be worth a cell, in cubes of the smallest edge; method "prisms"
    only."""
    voxel_size: float = 2.0
    """Edge of a voxel, m; method "voxel" only."""
    coverage_points: int = 100_000
    """Random points that measure the coverage."""
    coverage_seed: int = 0
    """Seed of these points."""
    max_cells: int = 2_000_000
    """A decomposition into more cells than this is refused."""
    threads: int = 0
    """Threads that divide the space; 0: one for each usable processor. Cells do not depend on it."""

    def __post_init__(self) -> None:
        positive = {"min_size": self.min_size, "max_size": self.max_size, "voxel_size": self.voxel_size}
        for name, value in positive.items():
            if not 0.0 < value < float("inf"):
                raise CellError(f"{name} is {value} m; allowed: greater than 0 and finite")
        not_negative = {
            "clearance": self.clearance,
            "cell_price": self.cell_price,
            "ground_height": self.ground_height,
            "ground_slope": self.ground_slope,
            "ground_step": self.ground_step,
        }
        for name, value in not_negative.items():
            if not 0.0 <= value < float("inf"):
                raise CellError(f"{name} is {value}; allowed: 0 or greater and finite")
        altitudes = (self.altitude_min, self.altitude_min if self.altitude_max is None else self.altitude_max)
        if not all(abs(value) < float("inf") for value in altitudes):
            raise CellError(f"altitude_min and altitude_max are {altitudes} m; allowed: finite numbers")
        if self.max_size < self.min_size:
            raise CellError(f"max_size is {self.max_size} m; allowed: at least min_size, {self.min_size} m")
        if self.method not in ("prisms", "boxes", "voxel"):
            raise CellError(f"method is {self.method!r}; allowed: 'prisms', 'boxes', 'voxel'")
        self._check_mission()
        if self.threads < 0:
            raise CellError(f"threads is {self.threads}; allowed: 0 or greater")
        if self.coverage_points < 1 or self.max_cells < 1:
            raise CellError(
                f"coverage_points is {self.coverage_points}, max_cells is {self.max_cells}; "
                "allowed: 1 or greater"
            )

    def _check_mission(self) -> None:
        if self.mission not in ("aerial", "ground", "corridor"):
            raise CellError(f"mission is {self.mission!r}; allowed: 'aerial', 'ground', 'corridor'")
        if self.altitude_above not in ("ground", "lowest"):
            raise CellError(f"altitude_above is {self.altitude_above!r}; allowed: 'ground', 'lowest'")
        if self.mission == "ground" and self.ground_height <= 0.0:
            raise CellError(f"ground_height is {self.ground_height} m; mission ground needs more than 0")
        if self.mission == "ground" and (self.altitude_min, self.altitude_max) != (0.0, None):
            raise CellError(
                f"mission is ground with altitudes {self.altitude_min} and {self.altitude_max} m; allowed: "
                "ground_height alone"
            )
        if (self.mission == "corridor") != bool(self.corridor):
            raise CellError(
                f"mission is {self.mission!r} and corridor has {len(self.corridor)} points; "
                "allowed: 2 or more points with mission corridor, none without"
            )
        if self.corridor and (
            len(self.corridor) < 2
            or not all(len(p) == 3 and all(abs(v) < float("inf") for v in p) for p in self.corridor)
        ):
            raise CellError(f"corridor is {self.corridor}; allowed: 2 or more points of three finite numbers")
        if not 0.0 < self.corridor_radius < float("inf"):
            raise CellError(
                f"corridor_radius is {self.corridor_radius} m; allowed: greater than 0 and finite"
            )
        self._check_sectors()

    def _check_sectors(self) -> None:
        if self.sector is not None and self.sector_size is None:
            raise CellError(
                f"sector is {self.sector} without sector_size; allowed: both, or sector_size alone"
            )
        if self.sector_size is None:
            return
        largest = self.voxel_size if self.method == "voxel" else self.max_size
        if not largest <= self.sector_size < float("inf"):
            raise CellError(
                f"sector_size is {self.sector_size} m; allowed: finite and at least {largest} m, the largest "
                "cell"
            )
