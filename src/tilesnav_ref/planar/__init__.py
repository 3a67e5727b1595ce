"""Planar features of point clouds."""

from tilesnav_ref.planar.detect import detect_planes
from tilesnav_ref.planar.model import NO_PLANE, PlanarFeatures, Rectangles
from tilesnav_ref.planar.settings import PlaneSettings

__all__ = ["NO_PLANE", "PlanarFeatures", "PlaneSettings", "Rectangles", "detect_planes"]
