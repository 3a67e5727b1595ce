"""Planar features of point clouds."""

from tilesnav_ref.planar.model import NO_PLANE, PlanarFeatures, Rectangles
from tilesnav_ref.planar.settings import PlaneSettings

__all__ = ["NO_PLANE", "PlanarFeatures", "PlaneSettings", "Rectangles"]
