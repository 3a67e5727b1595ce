"""Settings of the way from planar features to a mesh."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MeshSettings:
    """How features become faces. Lengths are metres."""

    resolution: float = 0.1
    """Inliers of one feature that are nearer to each other than this add nothing to its outline."""
    alpha: float = 3.0
    """Radius of the emptiest circle that the outline spans, in spacings of the inliers; the spacing is the
    median circumradius of their Delaunay triangles."""
    tolerance: float = 1.0
    """Distance by which simplifying may move a free border, in spacings."""
    reach: float = 4.0
    """Distance over which a border is drawn to the line where its plane meets a neighbour, in spacings."""
    reach_max: float = 1.5
    """Greatest such distance, metres: sparse clouds must not be joined over a street."""
    least_angle: float = 0.2
    """Least angle between planes whose line is used, radians: below 11 degrees noise moves it too far."""
    hole: float = 4.0
    """Holes with an area of less than this many circles of the alpha radius are closed: chance, no window."""

    def __post_init__(self) -> None:
        """Refuse lengths that are not positive: ValueError."""
        for name, value in vars(self).items():
            if not 0.0 < value < float("inf"):
                raise ValueError(f"mesh setting {name}: found {value}; allowed: greater than 0 and finite")
