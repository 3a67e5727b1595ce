"""Settings of planar feature detection."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PlaneSettings:
    """How planar features are found. A length of 0 is taken from the data.

    Parameters
    ----------
    inlier_distance : float
        Greatest distance of an inlier from its plane, metres; 0: four standard deviations of the noise that
        the cloud shows.
    normal_sigmas : float
        Greatest deviation of a local normal from that of its plane, in standard deviations of the normals.
    min_points : int
        Fewest inliers of a feature.
    min_area : float
        Least area that the inliers of a feature cover, square metres.
    connection : float
        Greatest gap between points of one feature, metres; 0: from the spacing of the points.
    seed : int
        Of the random samples. The same seed gives the same features, on any number of threads.
    threads : int
        0: one for each usable processor.
    """

    inlier_distance: float = 0.0
    normal_sigmas: float = 4.0
    min_points: int = 30
    min_area: float = 0.0
    connection: float = 0.0
    seed: int = 0
    threads: int = 0
